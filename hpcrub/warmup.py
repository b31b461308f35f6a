"""Compiled code → every rank, compiled by one of them only."""

import contextlib
from pathlib import Path

import numba
import numpy as np

from hpcrub import history, sweep
from hpcrub.statistics import running_statistics

MARK = "complete"  # begin of the names of files that say what the cache holds
WITH_HISTORIES = "time_response", "interaction_map", "energy", "branches"  # studies


def warm_up(team, config, progress=None):
    """Load what a study will need on all ranks, so that from now on they can stop promptly.

    team: Team; config: Config; progress: Progress on rank 0.
    Without a cache of compiled code rank 0 goes first; then the others find what it compiled.
    """
    team.on_root(lambda: _compile_once(config, progress))
    _load(config)
    if team.rank == 0:
        _warm_statistics()


def _compile_once(config, progress):
    mark = Path(numba.config.CACHE_DIR) / "-".join([MARK, *_more(config)])
    if numba.config.CACHE_DIR and mark.exists():
        return
    if progress:
        progress.say("compiling the kernel (once after every change of the program: a minute)")
    _load(config)
    _warm_statistics()
    with contextlib.suppress(OSError):  # a full disk: next time it is compiled again
        if numba.config.CACHE_DIR:
            mark.touch()


def _more(config):
    """What a study needs beside the kernel itself."""
    if config.debug.energy_audit:
        yield "audit"
    if config.study in WITH_HISTORIES:
        yield "history"


def _load(config):
    more = set(_more(config))
    sweep.warm_up()
    if "audit" in more:
        sweep.warm_up(audit=True)
    if "history" in more:
        modes, scene = sweep.smallest_case()
        scene = scene._replace(audit="audit" in more)
        list(history.march(modes, scene, [100.0], scene.steady.first_check))


def _warm_statistics():
    """A stop leaves little time for them."""
    running_statistics(np.ones(1), [50.0], 1, 1.0)
