"""The bladed disk and its casing: finite elements, reduction, mistuning, bumps.

From dimensions, materials and mistuning patterns, plain numbers in SI units, the room makes reduced
models and the modes of any sample. It imports nothing of hpcrub but its errors.
"""
