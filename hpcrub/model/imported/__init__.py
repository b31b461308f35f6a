"""Bladed disks of any finite-element program: the neutral file, its disk, the reduced model.

In: arrays of a model file, or what a reader made of the files of another program.
Out: a ReducedModel like the planar disk's.
Imports of hpcrub: its errors and the rest of the model room.
"""
