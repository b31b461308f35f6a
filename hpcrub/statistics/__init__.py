"""Percentiles of amplifications, their confidence and convergence; coexisting motions.

In: arrays of numbers. Out: arrays of numbers. From `contact` it imports only the status codes.
"""
