"""Percentiles of amplifications, their confidence and convergence; coexisting motions.

In: arrays of numbers. Out: arrays of numbers. Of `contact` it imports the status codes alone.
"""
