"""The blade of NASA rotor 67 between its published sections.

Source: Strazisar, Wood, Hathaway, Suder (1989), NASA TP 2879. Sections lie on stream surfaces from
hub to casing, the last of which is the casing: the blade ends a running clearance before it.

The frame is hpcrub's: z against the flow, so that the fan turns about it towards +theta.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

CLEARANCE = 0.61  # at the design speed, normal to the casing [mm]
EDGE = 0.005  # share of a section's arc that the mesh leaves out at each edge's circle


class Sections(NamedTuple):
    """Surfaces and end walls of the blade, lengths in mm."""

    n_blades: int
    sides: tuple  # surface at the smaller angle, and the other: see `Blade`
    hub: tuple  # z, radius, by increasing z
    casing: tuple


def read(path: Path) -> Sections:
    """Sections of a NumPy archive (.npz) of the published numbers.

    `axial_m`, `r_theta_upper_m` (radius times angle), `tangential_thickness_m` (to be subtracted),
    `radius_m`, each (surfaces, points); `leading_edge`, `trailing_edge`: first and last point of
    the blade; `n_blades`.
    """
    with np.load(path) as file:
        data = {name: file[name] for name in file.files}
    z, r = -1e3 * data["axial_m"], 1e3 * data["radius_m"]
    upper = 1e3 * data["r_theta_upper_m"]
    lower = upper - 1e3 * data["tangential_thickness_m"]
    blade = slice(int(data["leading_edge"]), int(data["trailing_edge"]) + 1)
    sides = tuple(
        _by_arc(r[:, blade], -arc[:, blade] / r[:, blade], z[:, blade]) for arc in (upper, lower)
    )
    walls = [(z[k, ::-1], r[k, ::-1]) for k in (0, -1)]
    return Sections(int(data["n_blades"]), sides, *walls)


def _by_arc(r, theta, z):
    """Splines of r, theta, z of every surface over the share of the arc from leading edge."""
    splines = []
    for one in zip(r, theta, z, strict=True):
        x = np.column_stack([one[0] * np.cos(one[1]), one[0] * np.sin(one[1]), one[2]])
        arc = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(x, axis=0), axis=1)))
        splines.append(CubicSpline(arc / arc[-1], np.column_stack(one)))
    return splines


def side(sections: Sections, which: int, share: np.ndarray) -> CubicSpline:
    """One surface at some shares of its arcs, as a spline over the stream surfaces.

    Its values at a surface number, 0 at the hub, are (shares, 3): r, theta, z.
    """
    rows = np.stack([spline(share) for spline in sections.sides[which]])
    return CubicSpline(np.arange(len(rows)), rows)


def wall(curve: tuple, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Radius of an end wall [mm] and its slope dr/dz at some z [mm]."""
    spline = CubicSpline(*curve)
    return spline(z), spline(z, 1)


def tip(sections: Sections, spline: CubicSpline, clearance: float = CLEARANCE) -> np.ndarray:
    """Surface number at which each share of `side` is as far from the casing as the clearance."""
    last = spline.x[-1]
    number = np.full(spline(last).shape[0], last)
    at = np.arange(len(number))
    for _ in range(20):  # Newton's method; the radius grows by some 12 mm a surface
        r, _, z = spline(number)[at, at].T
        radius, slope = wall(sections.casing, z)
        beyond = (radius - r) / np.hypot(1.0, slope) - clearance
        number += beyond / spline(number, 1)[at, at, 0]
    if not np.abs(beyond).max() < 1e-9:
        raise ValueError("the blade's end does not follow the casing")
    return number
