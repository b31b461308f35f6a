"""Readers of files of finite-element programs; each returns the arrays of a model file."""
