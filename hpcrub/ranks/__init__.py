"""Execution of a study on MPI ranks: schedule of the tasks, progress on a terminal, logs.

This room knows nothing of physics. Only its module `parallel` imports mpi4py.
"""
