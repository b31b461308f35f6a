"""Compiled code → every rank, compiled by one of them only."""

from pathlib import Path

import numba
import numpy as np

from hpcrub import sweep
from hpcrub.statistics import running_intervals, running_percentiles

MARK = "complete"  # file that says that the cache holds everything


def warm_up(team, progress=None):
    """Load what will be needed on all ranks, so that from now on they can stop promptly.

    team: Team; progress: Progress on rank 0.
    Without a cache of compiled code rank 0 goes first; then the others find what it compiled.
    """
    team.on_root(lambda: _compile_once(progress))
    sweep.warm_up()
    if team.rank == 0:
        _warm_statistics()


def _compile_once(progress):
    mark = Path(numba.config.CACHE_DIR) / MARK
    if numba.config.CACHE_DIR and mark.exists():
        return
    if progress:
        progress.say("compiling the kernel (once after every change of the program: a minute)")
    sweep.warm_up()
    _warm_statistics()
    if numba.config.CACHE_DIR:
        mark.touch()


def _warm_statistics():
    """A stop leaves little time for them."""
    running_percentiles(np.ones(1), [50.0], 1, 1.0)
    running_intervals(np.ones(1), [50.0], 1, 1.0)
