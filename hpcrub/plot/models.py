"""Disks of model files in three dimensions: what has been imported, and its mode shapes."""

import os
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.axes import Axes
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from hpcrub.errors import InputError
from hpcrub.model.imported import assembly, neutral
from hpcrub.model.imported.craig_bampton import lowest_modes
from hpcrub.model.imported.frames import node_angle
from hpcrub.plot.style import BLUE, COLOURS, STYLE
from hpcrub.results import model_file

DEFORMED = 0.1  # largest displacement drawn, in tip radii
FACE = "0.85"
Array = np.ndarray[Any, np.dtype[np.float64]]


def model(path: str | os.PathLike[str], ax: Axes | None = None, mode: int | None = None) -> Axes:
    """The disk of a model file with its contact nodes, at rest or in one of its modes.

    Parameters
    ----------
    path
        Model file, as `hpcrub import` writes it.
    ax
        Axes with `projection="3d"` to draw into. By default a new figure is made.
    mode
        Mode at rest without contact, counted from 1, whose shape is drawn, coloured by the size of
        the displacement; by default the undeformed disk.

    Returns
    -------
    Axes
        The axes drawn into.

    Raises
    ------
    InputError
        The file is no model file, the axes are flat, or the model has no such mode. A reduced model
        has no shapes, as the file does not tell the motion of its inner nodes.
    """
    file = neutral.from_arrays(model_file.read(Path(path)))
    if mode is not None and (file.kind == "reduced" or not 1 <= mode <= len(file.dof) - 2):
        raise InputError(f"{path}: no shape of mode {mode} can be drawn of this model")
    disk: Any = file if file.kind == "reduced" else assembly.assemble(file)
    with rc_context(STYLE if ax is None else {}):
        axes = _axes() if ax is None else ax
        if not hasattr(axes, "get_zlim"):
            raise InputError('a disk in three dimensions needs axes with projection="3d"')
        moved, title = np.zeros_like(disk.nodes), Path(path).name
        if mode is not None:
            frequency, moved = shape(disk, mode)
            title += f", mode {mode}: {frequency:.5g} Hz"
        radius = np.nanmax(np.hypot(*disk.nodes[disk.contact_node, :2].T))
        _draw(axes, disk, moved, 1e3 * DEFORMED * radius if mode is not None else 0.0)
        axes.set_title(title)
    return axes


def shape(disk: assembly.SparseDisk, mode: int) -> tuple[float, Array]:
    """Frequency and displacements of a mode of the disk at rest.

    Parameters
    ----------
    disk
        The whole disk, n rows.
    mode
        Counted from 1.

    Returns
    -------
    tuple
        Frequency [Hz]; displacements x, y, z of the nodes (n_nodes, 3), the largest one is 1.
    """
    values, modes = lowest_modes(disk.stiffness[0].tocsc(), disk.mass.tocsc(), mode)
    padded = np.append(modes[:, mode - 1], 0.0)  # row -1 is held
    radial, tangential, axial = padded[disk.row].T
    c, s = np.cos(node_angle(disk.nodes)), np.sin(node_angle(disk.nodes))
    moved = np.stack([c * radial - s * tangential, s * radial + c * tangential, axial], axis=1)
    size = np.linalg.norm(moved, axis=1).max()
    return float(np.sqrt(values[mode - 1]) / (2 * np.pi)), moved / size


def _axes() -> Any:
    from matplotlib import pyplot

    return pyplot.figure(figsize=(8, 8)).add_subplot(projection="3d")


def _draw(axes: Any, disk: Any, moved: Array, scale: float) -> None:
    nodes = 1e3 * disk.nodes + scale * moved
    if len(disk.surface):
        colours: Any = FACE
        if scale:
            size = np.linalg.norm(moved, axis=1)[disk.surface].mean(axis=1)
            colours = _shades(size)
        faces = Poly3DCollection(nodes[disk.surface], facecolors=colours, edgecolors="0.5", lw=0.2)
        axes.add_collection3d(faces)
    else:
        axes.plot(*nodes.T, ".", color=BLUE, ms=2)
    for blade in np.unique(disk.contact_blade):
        mine = nodes[disk.contact_node[disk.contact_blade == blade]]
        axes.plot(*mine.T, "o", color=COLOURS[blade % len(COLOURS)], ms=3)
        axes.text(*(1.12 * np.array([1.0, 1.0, 0.0]) * mine.mean(axis=0)), f"{blade + 1}")
    known = nodes[np.isfinite(nodes).all(axis=1)]
    for side, ends in zip("xyz", np.transpose([known.min(axis=0), known.max(axis=0)]), strict=True):
        axes.set(**{f"{side}lim": ends, f"{side}label": f"{side} [mm]"})
    axes.set_aspect("equal")
    axes.locator_params(axis="z", nbins=3)


def _shades(size: Array) -> Any:
    return colormaps["viridis"](size / size.max())
