"""How a study runs: ranks, who computes what next, progress on a terminal, logs.

Knows nothing of physics. The one module that imports mpi4py is `ranks.parallel`.
"""
