"""Compilation of the kernel by one rank, and loading by all ranks, before a study begins."""

import contextlib
import gc
from collections.abc import Callable

import numba
import numpy as np

from hpcrub.config.schema import Config
from hpcrub.errors import HpcrubError
from hpcrub.ranks.parallel import Team
from hpcrub.ranks.progress import print_item
from hpcrub.response import history, sweep
from hpcrub.setup.disks import rubbing_modes
from hpcrub.setup.problem import Problem

SPEED = 100.0  # [Hz] of the two revolutions that are integrated for nothing
LOADING = "loading {}; a new one is compiled first, in half a minute"
COMPILING = (
    "compiling {} on every rank, half a minute in every run: compiled code cannot be kept; "
    "set NUMBA_CACHE_DIR or XDG_CACHE_HOME to a folder that can be written"
)


def warm_up(
    team: Team,
    config: Config,
    problem: Problem,
    histories: bool,
    next_problem: Callable[[], Problem] | None = None,
) -> None:
    """Load all compiled code of a study on all ranks, so that later they can stop promptly.

    Rank 0 compiles the code, and the others load it; without a cache folder every rank compiles.
    The code depends on disk, contact law and `histories`: whether the study keeps motions.
    next_problem: builds a problem that may follow; the last of several ranks compiles its code
    while it would wait for rank 0.
    """

    def compile_one() -> None:
        if team.rank == 0:
            _load(config, problem, histories)
        elif team.rank == team.size - 1 and next_problem:
            with contextlib.suppress(HpcrubError):  # the problem may never be needed
                _load(config, next_problem(), False)

    kept = numba.config.CACHE_DIR  # type: ignore[attr-defined]
    if team.rank == 0:
        is_small = problem.scene.interface.second_order is None
        kernel = "the kernel" if is_small else "the kernel of second order"
        print_item((LOADING if kept else COMPILING).format(kernel))
    if kept:
        team.together(compile_one)
    _load(config, problem, histories)


def _load(config: Config, problem: Problem, histories: bool) -> None:
    """Run all code of a problem, which compiles it or loads it from the cache."""
    modes = rubbing_modes(config, problem, np.zeros(config.disk.n_blades))
    steady = problem.scene.steady._replace(
        window_revolutions=1, first_check=1.0 / SPEED, max_time=2.0 / SPEED
    )
    scene = problem.scene._replace(steady=steady, running=None)  # else nothing might touch
    gc.disable()  # in a compiler, whose objects stay, it takes a tenth of the time for nothing
    try:
        for width in scene.lanes:
            sweep.run_sweep(modes, scene, [SPEED], width=width)
        if histories:
            list(history.integrate(modes, scene, np.array([SPEED]), 1.0 / SPEED))
    finally:
        gc.enable()
