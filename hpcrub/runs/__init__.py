"""Everything that all studies share: definition of a study, tasks, result file, execution.

In: a `Run`, which is a study with its `Config`. Out: a result file, which all ranks fill.
"""
