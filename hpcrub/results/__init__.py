"""Result files: their layout, and `storage`, the only module that reads and writes HDF5.

In: arrays computed by `studies`. Out: HDF5 files. Imports `config`.
"""
