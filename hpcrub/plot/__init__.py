"""Figures of result files, in the user's own axes or as pictures for paper and talk.

Every figure is a function of a result file, a path or an open one, and of axes to draw into::

    import hpcrub

    hpcrub.plot.summary("results/quickstart.h5")            # a new figure
    hpcrub.plot.summary("results/quickstart.h5", ax=axes)   # into axes of one's own

Some compare several files, given as a list. `FIGURES` lists all of them, with `about` each. The
command `hpcrub plot` draws them into files (`hpcrub.plot.pictures`). `model` shows a model file,
which is no result, in three dimensions.
"""

from hpcrub.errors import InputError
from hpcrub.plot.amplifications import amplitudes, damping, linear, percentiles
from hpcrub.plot.canvas import Drawing
from hpcrub.plot.casings import casing
from hpcrub.plot.coexistence import branches
from hpcrub.plot.convergence import errors, running
from hpcrub.plot.densities import cross
from hpcrub.plot.disks import animation, disk, safe, shapes
from hpcrub.plot.histories import cutting, time
from hpcrub.plot.maps import interaction_map
from hpcrub.plot.models import model
from hpcrub.plot.responses import family, summary
from hpcrub.plot.rubbing import rubbing
from hpcrub.plot.strain_energy import energy
from hpcrub.plot.wear import wear

FIGURES: list[Drawing] = [
    summary, family, percentiles, amplitudes, running, errors, disk, safe, shapes, animation,
    casing, linear, time, rubbing, interaction_map, energy, cross, damping, branches, wear, cutting,
]  # fmt: skip

__all__ = [
    "FIGURES", "find", "amplitudes", "animation", "branches", "casing", "cross", "cutting",
    "damping", "disk", "energy", "errors", "family", "interaction_map", "linear", "model",
    "percentiles", "rubbing", "running", "safe", "shapes", "summary", "time", "wear",
]  # fmt: skip


def find(name: str) -> Drawing:
    """The figure of that name. Raises InputError, which names all figures."""
    for figure in FIGURES:
        if figure.__name__ == name:
            return figure
    names = ", ".join(figure.__name__ for figure in FIGURES)
    raise InputError(f"no figure {name!r}; there are {names}")
