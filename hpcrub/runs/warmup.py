"""Compilation of the kernel by one rank, and loading by all ranks, before a study begins."""

import numba
import numpy as np

from hpcrub.config.schema import Config
from hpcrub.model.interface import planar_interface
from hpcrub.model.reduction import Blades, Modes
from hpcrub.ranks.parallel import Team
from hpcrub.ranks.progress import print_item
from hpcrub.response import history, sweep
from hpcrub.response.scene import Scene
from hpcrub.response.steady import SteadyCriteria
from hpcrub.setup.disks import rubbing_modes
from hpcrub.setup.problem import Problem

LOADING = "loading the kernel; a new one is compiled first, in half a minute"
COMPILING = (
    "compiling the kernel on every rank, half a minute in every run: compiled code cannot be kept; "
    "set NUMBA_CACHE_DIR or XDG_CACHE_HOME to a folder that can be written"
)


def warm_up(team: Team, config: Config, problem: Problem, histories: bool) -> None:
    """Load all compiled code of a study on all ranks, so that later they can stop promptly.

    Rank 0 compiles the code, and the others load it; without a cache folder every rank compiles.
    The code depends on disk, contact law and `histories`: whether the study keeps motions.
    """
    tuned = rubbing_modes(config, problem, np.zeros(config.disk.n_blades))
    kept = numba.config.CACHE_DIR  # type: ignore[attr-defined]
    if team.rank == 0:
        print_item(LOADING if kept else COMPILING)
    if kept:
        team.on_root(lambda: _load(tuned, problem.scene, histories))
    _load(tuned, problem.scene, histories)


def _load(modes: Modes, scene: Scene, histories: bool) -> None:
    """Integrate one contact point for a few steps, with Modes and Scene of the types given."""
    two = np.eye(1, 2)  # arrays of a single mode would have another memory layout
    few = Modes.planar(np.ones(2), two, two)
    interface = planar_interface(np.zeros(1), 1.0)
    if len(modes.axial):
        few, interface = few._replace(axial=two), interface._replace(axial=np.zeros((1, 2)))
    if len(modes.stiffening):
        few = few._replace(stiffening=np.zeros((2, 2)))
    if modes.blades:
        few = few._replace(blades=Blades.of_one(two))
    short = scene._replace(
        interface=interface,
        damping_ratio=0.01,
        running=None,
        step=1e-3,
        steady=SteadyCriteria(first_check=0.01, window_revolutions=1, max_time=0.02),
        observes_stress=False,
    )
    for width in scene.lanes:
        sweep.run_sweep(few, short, [100.0], width=width)
    if histories:
        list(history.integrate(few, short, np.array([100.0]), short.steady.first_check))
