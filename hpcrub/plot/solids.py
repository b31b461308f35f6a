"""Disks of model files in three dimensions: faces or nodes, contact nodes, a number a blade."""

from typing import Any, NamedTuple

import numpy as np
from matplotlib import colormaps
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from hpcrub.errors import InputError
from hpcrub.plot.style import BLUE, COLOURS
from hpcrub.results.storage import ResultFile

DEFORMED = 0.14  # largest displacement drawn, in tip radii
NUMBERED, ALONE = 1.1, 1.3  # how large a disk is drawn, with numbers and axes, and without
FACE = "0.85"
THREE = {"projection": "3d"}
Array = np.ndarray[Any, np.dtype[np.float64]]


class Solid(NamedTuple):
    """What is drawn of a disk."""

    nodes: Array  # (n, 3) [m]
    surface: Any  # (F, 4) nodes of faces, none of a reduced model
    contact_node: Any  # (C,)
    contact_blade: Any  # (C,)

    @classmethod
    def of(cls, disk: Any) -> "Solid":
        """That of anything that has these members."""
        return cls(*(getattr(disk, name) for name in cls._fields))

    @classmethod
    def of_result(cls, file: ResultFile) -> "Solid":
        """That of a modal study of a model file."""
        return cls(*map(file.read, ("position_m", *cls._fields[1:])))

    @property
    def tip_radius(self) -> float:
        """Largest radius of a contact node [m]."""
        return float(np.hypot(*self.nodes[self.contact_node, :2].T).max())

    def moved(self, shape: Array) -> Array:
        """Nodes (n, 3) [mm] displaced by a shape (n, 3) whose largest displacement is 1."""
        return 1e3 * (self.nodes + DEFORMED * self.tip_radius * shape)


def check(axes: Any) -> None:
    """Raise InputError for axes that are flat."""
    if not hasattr(axes, "get_zlim"):
        raise InputError('a disk in three dimensions needs axes with projection="3d"')


def draw(axes: Any, solid: Solid, shape: Array | None = None, numbers: bool = True) -> Any:
    """Draw a disk.

    shape: displacements (n, 3), the largest one is 1; faces are coloured by their size.
    numbers: whether every blade gets its number.
    Returns faces, or the nodes where there are none, and the contact nodes of every blade.
    Raises InputError when the axes are flat.
    """
    check(axes)
    nodes = 1e3 * solid.nodes if shape is None else solid.moved(shape)
    drawn: list[Any] = []
    if len(solid.surface):
        colours: Any = FACE if shape is None else _shades(shape, solid.surface)
        faces = Poly3DCollection(nodes[solid.surface], facecolors=colours, edgecolors="0.5", lw=0.2)
        drawn.append(axes.add_collection3d(faces))
    else:
        drawn += axes.plot(*nodes.T, ".", color=BLUE, ms=2)
    for blade in np.unique(solid.contact_blade):
        mine = nodes[solid.contact_node[solid.contact_blade == blade]]
        style = "o" if len(solid.surface) else "o-"
        drawn += axes.plot(*mine.T, style, color=COLOURS[blade % len(COLOURS)], ms=3)
        if numbers:
            place = 1.15 * np.array([1.0, 1.0, 0.0]) * mine.mean(axis=0)
            axes.text(*place, f"{blade + 1}")
    _frame(axes, 1e3 * solid.nodes, NUMBERED if numbers else ALONE)
    return drawn


def move(drawn: list[Any], solid: Solid, shape: Array) -> list[Any]:
    """Take what `draw` returned to another displacement; returns it."""
    nodes, (body, *tips) = solid.moved(shape), drawn
    if len(solid.surface):
        body.set_verts(nodes[solid.surface])
    else:
        body.set_data_3d(*nodes.T)
    for blade, tip in zip(np.unique(solid.contact_blade), tips, strict=True):
        tip.set_data_3d(*nodes[solid.contact_node[solid.contact_blade == blade]].T)
    return drawn


def _shades(shape: Array, surface: Any) -> Any:
    size = np.linalg.norm(shape, axis=1)[surface].mean(axis=1)
    return colormaps["viridis"](size / max(size.max(), 1e-300))


def _frame(axes: Any, nodes: Array, zoom: float) -> None:
    """Axes as long as the undeformed disk, so that shapes beside each other have one scale."""
    sides = []
    known = nodes[np.isfinite(nodes).all(axis=1)]
    low, high = known.min(axis=0), known.max(axis=0)
    least = 0.02 * (high - low).max()  # contact nodes of a planar disk lie in one plane
    for side, a, b in zip("xyz", low - least, high + least, strict=True):
        axes.set(**{f"{side}lim": (a, b), f"{side}label": f"{side} [mm]"})
        sides.append(b - a)
    axes.set_box_aspect(sides, zoom=zoom)
    axes.locator_params(axis="z", nbins=3)
