"""Disks of model files in three dimensions: what has been imported, and its mode shapes."""

import os
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes

from hpcrub.errors import InputError
from hpcrub.model.imported import assembly, neutral
from hpcrub.model.imported.craig_bampton import lowest_modes
from hpcrub.model.imported.frames import to_cartesian
from hpcrub.plot import solids
from hpcrub.plot.style import STYLE
from hpcrub.results import model_file

Array = np.ndarray[Any, np.dtype[np.float64]]


def model(path: str | os.PathLike[str], ax: Axes | None = None, mode: int | None = None) -> Axes:
    """The disk of a model file with its contact nodes, at rest or in one of its modes.

    - path: model file, as `hpcrub import` writes it.
    - ax: axes with `projection="3d"` to draw into. By default a new figure is made.
    - mode: mode at rest without contact, counted from 1, whose shape is drawn, coloured by the size
      of the displacement; by default the undeformed disk.

    Returns the axes drawn into.
    Raises InputError: the file is no model file, the axes are flat, or the model has no such mode.
    A reduced model has no shapes, as the file does not tell the motion of its inner nodes.
    """
    file = neutral.from_arrays(model_file.read(Path(path)))
    if mode is not None and (file.kind == "reduced" or not 1 <= mode <= len(file.dof) - 2):
        raise InputError(f"{path}: no shape of mode {mode} can be drawn of this model")
    disk: Any = file if file.kind == "reduced" else assembly.assemble(file)
    with rc_context(STYLE if ax is None else {}):
        axes = _axes() if ax is None else ax
        solids.check(axes)
        moved, title = None, Path(path).name
        if mode is not None:
            frequency, moved = shape(disk, mode)
            title += f", mode {mode}: {frequency:.5g} Hz"
        solids.draw(axes, solids.Solid.of(disk), moved)
        axes.set_title(title)
    return axes


def shape(disk: assembly.SparseDisk, mode: int) -> tuple[float, Array]:
    """Frequency [Hz] of a mode of the disk at rest, counted from 1, and displacements of its nodes.

    These are x, y, z (n_nodes, 3), the largest one is 1.
    """
    values, modes = lowest_modes(disk.stiffness[0].tocsc(), disk.mass.tocsc(), mode)
    padded = np.append(modes[:, mode - 1], 0.0)  # row -1 is held
    moved = to_cartesian(disk.nodes, padded[disk.row])
    size = np.linalg.norm(moved, axis=1).max()
    return float(np.sqrt(values[mode - 1]) / (2 * np.pi)), moved / size


def _axes() -> Any:
    from matplotlib import pyplot

    return pyplot.figure(figsize=(8, 8)).add_subplot(projection="3d")
