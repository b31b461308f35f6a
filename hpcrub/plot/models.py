"""Disks of model files in three dimensions, as they have been imported."""

import os
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes

from hpcrub.model.imported import assembly, neutral
from hpcrub.plot import solids
from hpcrub.plot.style import STYLE
from hpcrub.results import model_file


def model(path: str | os.PathLike[str], ax: Axes | None = None) -> Axes:
    """The disk of a model file with its contact nodes; a modal study shows its modes.

    - path: model file, as `hpcrub import` writes it.
    - ax: axes with `projection="3d"` to draw into. By default a new figure is made.

    Returns the axes drawn into.
    Raises InputError: the file is no model file, or the axes are flat.
    """
    file = neutral.from_arrays(model_file.read(Path(path)))
    disk: Any = file if file.kind == "reduced" else assembly.assemble(file)
    with rc_context(STYLE if ax is None else {}):
        axes = _axes() if ax is None else ax
        solids.check(axes)
        solids.draw(axes, solids.Solid.of(disk))
        axes.set_title(Path(path).name)
    return axes


def _axes() -> Any:
    from matplotlib import pyplot

    return pyplot.figure(figsize=(8, 8)).add_subplot(projection="3d")
