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
from hpcrub.plot.convergence import convergence_errors, running_means
from hpcrub.plot.densities import contact_over_linear
from hpcrub.plot.disks import disk, mode_animation, mode_shapes, safe_diagram
from hpcrub.plot.histories import cutting, time_response
from hpcrub.plot.maps import interaction_map
from hpcrub.plot.responses import compare, summary
from hpcrub.plot.rubbing import rubbing
from hpcrub.plot.solids import model
from hpcrub.plot.strain_energy import energy
from hpcrub.plot.wear import wear

FIGURES: list[Drawing] = [
    summary, compare, percentiles, amplitudes, running_means, convergence_errors, disk,
    safe_diagram, mode_shapes, mode_animation, casing, linear, time_response, rubbing,
    interaction_map, energy, contact_over_linear, damping, branches, wear, cutting,
]  # fmt: skip

__all__ = [
    "FIGURES", "find", "amplitudes", "branches", "casing", "compare", "contact_over_linear",
    "convergence_errors", "cutting", "damping", "disk", "energy", "interaction_map", "linear",
    "mode_animation", "mode_shapes", "model", "percentiles", "rubbing", "running_means",
    "safe_diagram", "summary", "time_response", "wear",
]  # fmt: skip


def find(name: str) -> Drawing:
    """The figure of that name. Raises InputError, which names all figures."""
    for figure in FIGURES:
        if figure.__name__ == name:
            return figure
    names = ", ".join(figure.__name__ for figure in FIGURES)
    raise InputError(f"no figure {name!r}; there are {names}")
