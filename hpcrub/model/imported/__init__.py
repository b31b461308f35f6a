"""Bladed disks of any finite-element program: model file, assembled disk, reduced model.

In: arrays of a model file, also those that a reader makes from files of another program.
Out: a ReducedModel, as the planar disk has one.
Imports of hpcrub: its errors and the rest of the model room.
"""
