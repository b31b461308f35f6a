"""Drawing of model files in three dimensions: faces, or the tips of a reduced model."""

import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import FigureBase
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from hpcrub.model.imported import assembly, neutral
from hpcrub.plot.canvas import Canvas
from hpcrub.plot.style import ORANGE, STYLE
from hpcrub.results import model_file
from hpcrub.results.storage import ResultFile

DEFORMED = 0.14  # largest displacement drawn, in tip radii
NUMBERED, ALONE = 1.15, 1.35  # zoom of a disk, with numbers and without
ELEVATION = 50.0  # elevation of the view [deg]
NUMBERS = 1.17  # radius of the numbers of the blades, in radii of their contact nodes
FACE, SHEET = "0.85", 0.5  # colour; inner end of a blade of a reduced model, in radii of its tips
REDUCED = "Blades of a reduced model: sheets from the contact nodes inwards; it knows no more."
THREE: dict[str, Any] = {"projection": "3d"}
Array = np.ndarray[Any, np.dtype[np.float64]]


class Solid(NamedTuple):
    """Geometry of a disk as far as it is drawn."""

    nodes: Array  # (n, 3) [m]
    surface: Any  # (F, 4) nodes of faces; a reduced model has none
    contact_node: Any  # (C,) node of every contact point
    contact_blade: Any  # (C,) blade of every contact point, from 0

    @classmethod
    def of_result(cls, file: ResultFile) -> "Solid":
        """Read the geometry from a modal study of a model file."""
        return cls(*map(file.read, ("position_m", *cls._fields[1:])))

    @property
    def cells(self) -> Any:
        """Nodes of the faces (F, 4), or of the pieces (F, 2) of the tips of all blades."""
        if len(self.surface):
            return self.surface
        pieces = np.stack([self.contact_node[:-1], self.contact_node[1:]], axis=1)
        return pieces[self.contact_blade[1:] == self.contact_blade[:-1]]

    def faces(self, moved: Any) -> Array:
        """Return the corners (F, 4, 3) [m] of the faces after displacements (n, 3) [m].

        A reduced model knows only its contact nodes: the outer part of each blade is a sheet from
        these inwards, whose inner edge does not move.
        """
        corners = (self.nodes + moved)[self.cells]
        if len(self.surface):
            return corners
        roots = self.nodes[self.cells] * [SHEET, SHEET, 1.0]
        return np.concatenate([corners, roots[:, ::-1]], axis=1)

    @property
    def radius(self) -> float:
        """Largest radius of a contact node [m]."""
        return float(np.hypot(*self.nodes[self.contact_node, :2].T).max())

    def words(self, path: Path) -> str:
        """Return the title: name of the file, number of blades and tip radius."""
        blades = len(np.unique(self.contact_blade))
        return f"{path.name}: {blades} blades, tip radius {1e3 * self.radius:.4g} mm"


def model(path: str | os.PathLike[str], figure: FigureBase | None = None) -> Axes:
    """The disk of a model file with its contact nodes; a modal study shows its modes.

    - path: model file, as `hpcrub import` writes it.
    - figure: Figure or SubFigure to draw into. By default a new figure is made.

    Returns the axes drawn into.
    Raises InputError when the file is no model file.
    """
    disk = assembly.assemble(neutral.from_arrays(model_file.read(Path(path))))
    solid = Solid(*(getattr(disk, name) for name in Solid._fields))
    with rc_context(STYLE):
        axes: Axes = Canvas(figure).panels(1, 1, (8, 6), subplot_kw=THREE)[0, 0]
        draw(axes, solid)
        axes.set_title(solid.words(Path(path)))
        axes.legend(loc="lower right")
    return axes


def draw(axes: Any, solid: Solid, shape: Array | None = None) -> None:
    """Draw a disk at rest, with contact nodes and numbers of the blades, or a shape in colours.

    axes: with three dimensions; shape: displacements (n, 3), of which the largest is 1, and
    colours show their size, from 0 to 1.
    """
    nodes, tips = 1e3 * solid.nodes, solid.contact_node
    moved = 0.0 if shape is None else DEFORMED * solid.radius * shape
    body = Poly3DCollection(
        1e3 * solid.faces(moved), facecolors=FACE, edgecolors="0.5", lw=0.2, cmap="viridis"
    )
    axes.add_collection3d(body)
    if shape is not None:
        size = np.linalg.norm(shape, axis=1)[solid.cells].mean(axis=1)
        body.set(array=size, clim=(0.0, 1.0), edgecolors="face")
    else:
        axes.plot(*nodes[tips].T, "o", color=ORANGE, ms=3, label="contact nodes")
        for blade in np.unique(solid.contact_blade):
            place = nodes[tips[solid.contact_blade == blade]].mean(axis=0)
            axes.text(*(place * [NUMBERS, NUMBERS, 1.0]), f"{blade + 1}", ha="center", va="center")
    # axes without walls, which fit the undeformed disk, so that all shapes have one scale
    known = nodes[np.isfinite(nodes).all(axis=1)]
    low, high = known.min(axis=0), known.max(axis=0)
    least = 0.02 * (high - low).max()  # contact nodes of a planar disk lie in one plane
    for side, a, b in zip("xyz", low - least, high + least, strict=True):
        axes.set(**{f"{side}lim": (a, b)})
    axes.set_box_aspect(high - low + 2 * least, zoom=NUMBERED if shape is None else ALONE)
    axes.view_init(elev=ELEVATION)
    axes.set_axis_off()
