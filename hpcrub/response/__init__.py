"""Frequency responses in contact, whole histories, steady states, the linear response.

From the modes of a sample and a Scene, the room computes amplitudes, point statuses and histories.
It imports `model` and `contact`.
"""
