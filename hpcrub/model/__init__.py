"""The bladed disk and its casing: finite elements, reduction, mistuning, bumps.

In: dimensions, materials, mistuning patterns, as plain numbers in SI units.
Out: reduced models and the modes of any sample.
Imports nothing of hpcrub but its errors.
"""
