"""What a study needs is compiled by one rank, and loaded by all."""

import sys
from pathlib import Path

import numba

from hpcrub.config.schema import Config
from hpcrub.contact import jit
from hpcrub.errors import reason
from hpcrub.ranks.parallel import Team
from hpcrub.ranks.progress import Progress
from hpcrub.response import history, sweep

MARK = "complete"  # begin of the names of files that say what the cache holds


def warm_up(
    team: Team, config: Config, histories: bool = False, progress: Progress | None = None
) -> None:
    """Load what a study will need on all ranks, so that from now on they can stop promptly.

    Without a cache of compiled code rank 0 goes first; then the others find what it compiled.
    What is wrong with the cache is said once, for all ranks.

    Parameters
    ----------
    team
        All ranks.
    config
        Configuration of the study.
    histories
        Whether it keeps motions.
    progress
        Where to say that something is compiled (rank 0).
    """
    more = [*_more(config, histories)]
    lost = team.gather(jit.cache.lost)
    if lost and any(lost):
        _say_lost(next(filter(None, lost)), f" on {sum(map(bool, lost))} of {team.size} ranks")
    team.on_root(lambda: _compile_once(more, progress))
    _load(more)


def _compile_once(more, progress):
    mark = Path(numba.config.CACHE_DIR) / "-".join([MARK, *more])
    if numba.config.CACHE_DIR and mark.exists():
        return
    if progress:
        once = "once after every change of the program: " if numba.config.CACHE_DIR else ""
        progress.say(f"compiling the kernel ({once}a minute)")
    if not numba.config.CACHE_DIR:  # the others would find nothing: all compile at once
        return
    _load(more)
    try:
        if not jit.cache.lost:
            mark.touch()
    except OSError as error:
        jit.cache.lost = f"{mark}: {reason(error)}"
    if jit.cache.lost:
        _say_lost(jit.cache.lost)


def _say_lost(why, where=""):
    _say(
        f"compiled code cannot be kept{where} and every run compiles it anew (a minute): {why}; "
        "XDG_CACHE_HOME=FOLDER gives it another place"
    )


def _say(text):
    print(f"hpcrub: {text}", file=sys.stderr, flush=True)


def _more(config, histories):
    """What a study needs beside the kernel itself."""
    if config.disk.model is not None:  # it may move axially
        yield "axial"
    if histories:
        yield "history"


def _load(more):
    for axial in (False, True) if "axial" in more else (False,):
        sweep.warm_up(axial)
        if "history" in more:
            modes, scene = sweep.smallest_case(axial)
            list(history.integrate(modes, scene, [100.0], scene.steady.first_check))
