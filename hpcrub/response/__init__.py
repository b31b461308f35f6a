"""Frequency responses in contact, whole histories, steady states, the linear response.

In: modes of a sample and the contact case. Out: amplitudes, point statuses, histories.
Imports `model` and `contact`.
"""
