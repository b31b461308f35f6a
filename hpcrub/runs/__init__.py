"""What all studies have in common: what a study is, its result file, its tasks, how it is run.

In: a `Run`, a study with its `Config`. Out: a result file, laid out, then filled by all ranks.
"""
