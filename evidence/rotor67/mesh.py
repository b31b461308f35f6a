"""Structured mesh of one sector of the fan, hexahedra of 20 nodes; the disk is a design of ours.

The sides of the sector follow the blade's mean line, for the blades overlap along the axis. Every
block is a grid of twice as many intervals as elements, so that midside nodes lie on the surfaces.
Lengths in mm.
"""

from typing import NamedTuple

import numpy as np

from evidence.calculix import Mesh
from evidence.rotor67 import sections as geometry
from evidence.rotor67.sections import Sections


class Disk(NamedTuple):
    """Dimensions of the disk [mm], and shares."""

    fore: float = 8.0  # of the rim before the leading edge, axial
    aft: float = 7.0
    rim: float = 14.0  # radial depth, below the hub's surface
    bore: float = 45.0  # radius of the surface that is held
    web_from: float = 2 / 7  # the part of the blade's root, by arc, that stands on the web
    web_to: float = 5 / 7
    web: float = 0.6  # width of web, and of bore, as a share of the width at the rim
    hub: float = 1.3
    depths: tuple = (0.0, 0.2, 0.6, 0.8, 1.0)  # from the rim to the bore: where widths change
    foot: float = 3.0  # tangential width of the blade's column on the rim's faces


class Size(NamedTuple):
    """Numbers of elements."""

    chord: int = 14  # a multiple of 7
    span: int = 16
    through: int = 1
    between: int = 2  # from a blade to the sector's side
    rim: int = 2  # radial
    web: int = 1  # radial, for each of its parts


# corners, then midsides, on the grid of twice as many intervals: along chord, across, span
PLACES = np.array([
    (0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2),
    (1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2),
    (0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1),
])  # fmt: skip

MIRRORED = [4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11, 16, 17, 18, 19]


def sector(sections: Sections, size: Size = Size(), disk: Disk = Disk()) -> Mesh:  # noqa: B008
    """One sector of the fan in the shape of the sections. Returns a Mesh."""
    blade = _blade(sections, size)
    rim = _rim(sections, size, disk, blade[:, :, 0])
    web = _web(sections, size, disk, rim)
    nodes, elements = _joined([blade, rim, web])
    find = _finder(nodes)
    sets = {
        "low": np.unique(np.concatenate([find(block[:, 0]) for block in (rim, web)])),
        "high": np.unique(np.concatenate([find(block[:, -1]) for block in (rim, web)])),
        "bore": np.unique(find(web[:, :, -1])),
        "root": np.unique(find(blade[:, :, 0])),
        "tip": find(blade[:, size.through, -1]),  # the mean line's, from the leading edge on
    }
    blade_elements = np.arange(size.chord * size.through * size.span)  # these come first
    return Mesh(nodes, elements, {k: v[v >= 0] for k, v in sets.items()}, blade_elements)


def _blade(sections, size):
    """Places r, theta, z of the blade's grid (chord, through, span, 3)."""
    share = np.linspace(geometry.EDGE, 1.0 - geometry.EDGE, 2 * size.chord + 1)
    eta = np.linspace(0.0, 1.0, 2 * size.span + 1)
    sides = []
    for which in range(2):
        spline = geometry.side(sections, which, share)
        end = geometry.tip(sections, spline)
        at = np.arange(len(share))
        sides.append(np.stack([spline(e * end)[at, at] for e in eta], axis=1))
    across = np.linspace(0.0, 1.0, 2 * size.through + 1)[:, None, None]
    return (1.0 - across) * sides[0][:, None] + across * sides[1][:, None]


def _rim(sections, size, disk, root):
    """Places of the rim's grid (chord and faces, across, from the hub's surface inwards, 3)."""
    ends = [_face(sections, disk, root, at, out) for at, out in ((0, disk.fore), (-1, -disk.aft))]
    halfway = [(ends[0] + root[0]) / 2, (root[-1] + ends[1]) / 2]
    foot = np.concatenate([[ends[0], halfway[0]], root, [halfway[1], ends[1]]])
    half = np.pi / sections.n_blades
    mean = (foot[:, 0] + foot[:, -1]) / 2
    sides = [mean + [0.0, turn, 0.0] for turn in (-half, half)]
    t = np.linspace(0.0, 1.0, 2 * size.between + 1)[:, None, None]
    low = (1 - t) * sides[0] + t * foot[:, 0]
    high = (1 - t) * foot[:, -1] + t * sides[1]
    top = np.concatenate([low[:-1], foot.transpose(1, 0, 2), high[1:]]).transpose(1, 0, 2)
    wall = geometry.wall(sections.hub, top[..., 2])[0]
    blade = slice(2 * size.between, 2 * (size.between + size.through) + 1)
    wall[2:-2, blade] = top[2:-2, blade, 0]
    top[..., 0] = wall
    depth = np.linspace(0.0, disk.rim, 2 * size.rim + 1)
    rim = np.repeat(top[:, :, None], len(depth), axis=2)
    rim[..., 0] -= depth
    return rim


def _face(sections, disk, root, at, out):
    """The blade's column on a face of the rim (through, 3): the mean line goes straight on."""
    mean = root.mean(axis=1)
    inward = 2 if at == 0 else -3
    slope = (mean[at, 1] - mean[inward, 1]) / (mean[at, 2] - mean[inward, 2])
    z = mean[at, 2] + out
    r = float(geometry.wall(sections.hub, z)[0])
    theta = mean[at, 1] + slope * out
    across = np.linspace(-0.5, 0.5, root.shape[1]) * disk.foot / r
    return np.column_stack([np.full(len(across), r), theta + across, np.full(len(across), z)])


def _web(sections, size, disk, rim):
    """Places of web and bore (chord, across, from the rim inwards, 3)."""
    first, last = (2 + round(2 * size.chord * s) for s in (disk.web_from, disk.web_to))
    top = rim[first : last + 1, :, -1]
    middle = top[:, [0, -1]].mean(axis=(0, 1))
    mean = top[:, [0, -1]].mean(axis=1)
    depth = np.concatenate([
        np.linspace(a, b, 2 * size.web + 1)[:-1]
        for a, b in zip(disk.depths[:-1], disk.depths[1:], strict=True)
    ])  # fmt: skip
    depth = np.append(depth, 1.0)
    width = np.interp(depth, disk.depths, (1.0, disk.web, disk.web, disk.hub, disk.hub))
    web = np.repeat(top[:, :, None], len(depth), axis=2)
    web[..., 0] += (disk.bore - web[..., 0]) * depth
    web[..., 1] -= ((mean[:, 1] - middle[1])[:, None, None]) * depth
    web[..., 2] = middle[2] + (web[..., 2] - middle[2]) * width
    return web


def _joined(blocks):
    """Nodes (n, 3) in Cartesian coordinates, and elements (e, 20), of blocks that share faces."""
    places, elements, count = [], [], 0
    for block in blocks:
        n = np.array(block.shape[:3])
        number = count + np.arange(n.prod()).reshape(n)
        corner = 2 * np.stack(np.meshgrid(*map(np.arange, (n - 1) // 2), indexing="ij"), -1)
        at = corner.reshape(-1, 1, 3) + PLACES
        elements.append(number[tuple(at.transpose(2, 0, 1))])
        places.append(cartesian(block.reshape(-1, 3)))
        count += n.prod()
    places, elements = np.concatenate(places), np.concatenate(elements)
    used = np.unique(elements)
    _, first, again = np.unique(
        np.round(places[used], 6), axis=0, return_index=True, return_inverse=True
    )
    new = np.full(count, -1)
    new[used] = again.ravel()
    nodes = places[used[first]]
    elements = new[elements]
    x = nodes[elements]
    volume = np.linalg.det(np.stack([x[:, k] - x[:, 0] for k in (1, 3, 4)], axis=1))
    elements[volume < 0] = elements[volume < 0][:, MIRRORED]  # grids that run inwards
    return nodes, elements


def _finder(nodes):
    """Function from places (..., 3) in r, theta, z to nodes, -1 where there is none."""
    table = {tuple(x): k for k, x in enumerate(np.round(nodes, 6) + 0.0)}

    def find(block):
        x = np.round(cartesian(block.reshape(-1, 3)), 6) + 0.0
        return np.array([table.get(tuple(row), -1) for row in x])

    return find


def cartesian(places: np.ndarray) -> np.ndarray:
    """x, y, z of r, theta, z, each (n, 3)."""
    r, theta, z = places.T
    return np.column_stack([r * np.cos(theta), r * np.sin(theta), z])
