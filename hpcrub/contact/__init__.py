"""The contact kernel: time steps of many angular speeds at once, and the contact forces.

In: modes of a sample, time step, casing. Out: displacements and contact forces, status codes.
Imports `model`.
"""
