"""Percentiles of amplifications, their confidence and convergence; coexisting motions.

In: arrays of numbers. Out: arrays of numbers. Imports `contact` for its compilation policy.
"""
