"""Hexahedral mesh of a blisk of our own: a rim with twisted, tapered blades, sector by sector.

Lengths in mm. The disk turns about z; sector 0 lies about the x axis.
"""

from typing import NamedTuple

import numpy as np

from evidence.calculix import Mesh


class Shape(NamedTuple):
    """Dimensions [mm] and numbers of elements of one sector."""

    n_sectors: int = 12
    bore: float = 60.0  # radius of the held inner surface
    rim: float = 120.0  # radius of the blade roots
    tip: float = 220.0
    width: float = 40.0  # axial, of the rim and of a blade's root
    web: float = 6.0  # axial, below the rim
    depth: float = 8.0  # radial, of the rim
    thickness: float = 6.0  # of a blade at its root
    taper: float = 0.45  # of the thickness, to the tip
    twist: float = np.deg2rad(35.0)  # of the tip against the root
    radial: int = 4  # elements of web and rim, of which the rim has one
    around: int = 6
    axial: int = 3
    span: int = 8  # elements of a blade
    through: int = 2  # elements through the thickness, of the columns of `around`


BLISK = Shape()


def sector(shape: Shape = BLISK) -> Mesh:
    """One sector: the rim between two radii, and the blade in its middle. Returns a Mesh."""
    places, nodes, elements = {}, [], []

    def node(key, place):
        if key not in places:
            places[key] = len(nodes)
            nodes.append(place)
        return places[key]

    side = (shape.around - shape.through) // 2
    angle = _columns(shape, side)
    web = np.linspace(shape.bore, shape.rim - shape.depth, shape.radial)
    radius = np.append(web, shape.rim)
    height = np.linspace(-shape.width / 2, shape.width / 2, shape.axial + 1)

    def rim(i, j, k):
        z = height[k] if i >= shape.radial - 1 else height[k] * shape.web / shape.width
        place = radius[i] * np.cos(angle[j]), radius[i] * np.sin(angle[j]), z
        return node(("rim", i, j, k), place)

    def blade(i, j, k):
        if i == 0:
            return rim(shape.radial, side + j, k)
        return node(("blade", i, j, k), _blade_place(shape, i / shape.span, j, height[k]))

    for part, size in (
        (rim, (shape.radial, shape.around, shape.axial)),
        (blade, (shape.span, shape.through, shape.axial)),
    ):
        elements += [[part(i + a, j + b, k + c) for a, b, c in CORNERS]
                     for i, j, k in np.ndindex(size)]  # fmt: skip
    grid = list(np.ndindex(shape.radial + 1, shape.axial + 1))
    sets = {
        "low": [rim(i, 0, k) for i, k in grid],
        "high": [rim(i, shape.around, k) for i, k in grid],
        "bore": [rim(0, j, k) for j, k in np.ndindex(shape.around + 1, shape.axial + 1)],
        "tip": [blade(shape.span, shape.through // 2, k) for k in range(shape.axial + 1)],
    }
    n_rim = shape.radial * shape.around * shape.axial
    return Mesh(
        np.array(nodes),
        np.array(elements),
        {name: np.array(numbers) for name, numbers in sets.items()},
        np.arange(n_rim, len(elements)),
    )


CORNERS = [  # along radius, circumference, axis
    (0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1),
]  # fmt: skip


def _columns(shape, side):
    """Angles of the columns of nodes around the rim; a blade stands on the middle ones."""
    edge, foot = np.pi / shape.n_sectors, shape.thickness / 2 / shape.rim
    return np.concatenate([
        np.linspace(-edge, -foot, side + 1)[:-1],
        np.linspace(-foot, foot, shape.through + 1),
        np.linspace(foot, edge, side + 1)[1:],
    ])  # fmt: skip


def _blade_place(shape, s, column, height):
    """Place of a blade's node at the share s of its span; the tip lies on a cylinder."""
    thickness = shape.thickness * (1 - shape.taper * s)
    across, along = (column / shape.through - 0.5) * thickness, height * (1 - 0.15 * s)
    c, sine = np.cos(shape.twist * s), np.sin(shape.twist * s)
    y, z = across * c - along * sine, across * sine + along * c
    r = shape.rim + s * (shape.tip - shape.rim)
    return np.sqrt(r**2 - y**2), y, z


def whole_disk(mesh: Mesh, n_sectors: int) -> Mesh:
    """All sectors of a Mesh, joined; sets and blade elements of all of them. Returns a Mesh.

    The tip nodes come sector by sector.
    """
    n, (low, high) = len(mesh.nodes), (mesh.sets[name] for name in ("low", "high"))
    own = np.setdiff1d(np.arange(n), high)
    number = np.empty((n_sectors, n), dtype=int)
    number[:, own] = np.arange(n_sectors)[:, None] * len(own) + np.arange(len(own))
    number[:, high] = np.roll(number, -1, axis=0)[:, low]
    nodes = np.empty((n_sectors * len(own), 3))
    for s in range(n_sectors):
        c, sine = np.cos(2 * np.pi * s / n_sectors), np.sin(2 * np.pi * s / n_sectors)
        turn = np.array([[c, -sine, 0], [sine, c, 0], [0, 0, 1]])
        nodes[number[s, own]] = mesh.nodes[own] @ turn.T
    first = np.arange(n_sectors)[:, None] * len(mesh.elements)
    sets = {
        "bore": np.unique(number[:, mesh.sets["bore"]]),
        "tip": number[:, mesh.sets["tip"]].ravel(),
    }
    elements = number[:, mesh.elements].reshape(-1, 8)
    return Mesh(nodes, elements, sets, (first + mesh.blade_elements).ravel())
