"""Figures of result files, on the screen or as pictures for paper and talk.

Every figure is a function of a result file, a path or an open one, and of where to draw it::

    import hpcrub

    hpcrub.plot.summary("results/quickstart.h5")                # a new figure
    hpcrub.plot.summary("results/quickstart.h5", figure=left)   # into a part of one's own

- Some compare several files, given as a list. `mode` is that of `mode_shapes`, from 1.
- `figure` is a Figure or a SubFigure (`Figure.subfigures`), which may stand beside axes of one's
  own; a Figure without axes gets the size that suits the drawing.
- Returned are the axes drawn into, one or an array, to be changed; their `figure` has everything
  else.
- A file of another study, or without what the figure shows, raises an InputError.

`FIGURES` lists all of them, with `about` each. The command `hpcrub plot` draws them into files
(`hpcrub.plot.pictures`). `model` shows a model file, which is no result, in three dimensions.
"""

from hpcrub.plot.amplifications import (
    amplitudes,
    convergence_errors,
    linear,
    percentiles,
    running_means,
)
from hpcrub.plot.canvas import Drawing
from hpcrub.plot.disks import campbell, casing, disk, mode_shapes, safe_diagram
from hpcrub.plot.effects import air, casing_motion, casing_waves, wear
from hpcrub.plot.histories import branches, interaction_map, time_response
from hpcrub.plot.responses import compare, summary
from hpcrub.plot.run_ups import run_up
from hpcrub.plot.samples import contact_over_linear, energy
from hpcrub.plot.searches import checklist, patterns, rare, threshold
from hpcrub.plot.solids import model

FIGURES: list[Drawing] = [
    summary, compare, percentiles, amplitudes, running_means, convergence_errors, disk,
    safe_diagram, campbell, mode_shapes, casing, linear, time_response,
    interaction_map, energy, contact_over_linear, branches, wear,
    casing_motion, casing_waves, air, run_up, threshold, checklist, patterns, rare,
]  # fmt: skip

__all__ = ["FIGURES", "model", *(figure.__name__ for figure in FIGURES)]
__all__.sort()  # as the page of the API lists them
