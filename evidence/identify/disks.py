"""Disks that the search tries: their dimensions, and finite elements with four more freedoms.

The reference model has a ring on the hub circle, one width for all parts and a parabolic blade
axis. The paper says none of this, so the search may also move the ring inwards, make ring and
spokes narrower than the blades and skew the bow towards root or tip.
"""

from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, eigh
from scipy.optimize import root

from hpcrub.config.schema import Config
from hpcrub.model.disk import build_disk
from hpcrub.model.reduction import craig_bampton

BAND = 90.1, 93.2  # [Hz] lowest and highest frequency of family 1B: paper, section 2.1
N_MODES = 60  # of the reduced model: paper, table 4
_PAPER = Config()  # what the paper gives of the disk is the same in every input


class Dimensions(NamedTuple):
    """All that the paper leaves open of the disk; the last four are those of the variations."""

    lean_deg: float
    bow: float  # offset of the blade's axis from its chord over the chord [-]
    inner_radius_mm: float
    ring_thickness_mm: float
    spoke_thickness_mm: float
    blade_thickness_mm: float
    skew: float = 0.0  # of the bow: 1 + skew (2z - 1) times the parabola [-]
    ring_inset_mm: float = 0.0  # how far the ring's axis lies inside the hub circle
    ring_width: float = 1.0  # over that of the blades [-]
    spoke_width: float = 1.0

    @property
    def is_plain(self):
        """Whether the reference model can describe it: none of the variations."""
        return self[6:] == (0.0, 0.0, 1.0, 1.0)


# The range of the search; the thicknesses of spokes and blades follow from the band. Blades lean
# with the rotation (positive) or against it.
BOUNDS = {
    "lean_deg": (-70.0, 70.0),
    "bow": (-0.12, 0.12),
    "inner_radius_mm": (15.0, 185.0),
    "ring_thickness_mm": (8.0, 40.0),
}
VARIATIONS = {
    "skew": (-1.0, 1.0),
    "ring_inset_mm": (0.0, 30.0),
    "ring_width": (0.4, 1.6),
    "spoke_width": (0.4, 1.6),
}
# Disks of earlier, shorter searches: the reference of hpcrub 0.1, that of hpcrub since, four that
# lean against the rotation, and the first one's hub with blades that lean against the rotation.
EARLIER = (
    Dimensions(45.41, -0.0459, 169.9, 13.39, 7.23, 13.44),
    Dimensions(53.11, -0.0492, 38.13, 23.67, 33.23, 14.13),
    Dimensions(-42.43, 0.077, 44.19, 19.03, 33.41, 12.75),
    Dimensions(-39.27, 0.0672, 42.40, 18.20, 33.73, 12.31),
    Dimensions(-39.43, 0.0679, 32.06, 21.58, 33.67, 12.32),
    Dimensions(-38.66, 0.067, 23.55, 20.97, 35.97, 12.23),
    Dimensions(-39.0, 0.067, 169.9, 13.39, 6.78, 12.67),
    Dimensions(-45.4, 0.08, 169.9, 13.39, 7.32, 13.66),
    # met in a first part of this search; their tuned peaks repeat
    Dimensions(-54.434784, 0.089249, 168.06052, 14.581021, 8.211381, 15.219531),
    Dimensions(-36.286201, 0.067167, 165.809546, 14.871743, 6.218391, 12.23746),
    Dimensions(-42.348062, 0.062394, 158.85209, 15.089206, 7.409614, 12.934044),
    Dimensions(-38.669148, 0.06177, 144.998908, 16.122885, 8.528883, 12.401432),
    Dimensions(-35.620927, 0.058249, 166.690201, 14.337472, 6.37629, 12.144966),
)
REFERENCE = EARLIER[1]  # of hpcrub when this search began


def build(dimensions):
    """Finite-element model of the tuned disk.

    Parameters
    ----------
    dimensions : Dimensions

    Returns
    -------
    hpcrub.model.disk.Disk
        Its `points`, which only drawings use, ignore `ring_inset_mm`.

    Raises
    ------
    ValueError
        The leaned chord misses the tip circle.
    """
    d = dimensions
    hub = _PAPER.disk.hub_radius
    ring_radius = hub - 1e-3 * d.ring_inset_mm
    blades = _part(d, hub, blade=d.blade_thickness_mm)
    ring = _part(d, ring_radius, ring=d.ring_thickness_mm)
    spokes = _part(d, ring_radius, spoke=d.spoke_thickness_mm)
    to_ring = np.eye(blades.blade_dof.shape[1])
    to_ring[:3, :3] = _hub_motion(ring_radius, hub)
    everywhere = np.eye(len(blades.mass))
    for dof in blades.blade_dof:
        everywhere[np.ix_(dof[:3], dof[:3])] = to_ring[:3, :3]

    def whole(matrix):
        on_ring = everywhere.T @ getattr(blades, matrix) @ everywhere
        disk = d.ring_width * getattr(ring, matrix) + d.spoke_width * getattr(spokes, matrix)
        return on_ring + disk

    return blades._replace(
        mass=whole("mass"),
        stiffness=whole("stiffness"),
        blade_stiffness=to_ring.T @ blades.blade_stiffness @ to_ring,
    )


def _part(d, hub_radius, ring=0.0, spoke=0.0, blade=0.0):
    """The disk of which only the parts with a thickness [mm] have mass and stiffness."""
    n_elements = _PAPER.disk.blade.n_elements
    z = np.linspace(0, 1, n_elements + 1)[:, None]  # of the blade's nodes, root to tip
    return build_disk(
        SimpleNamespace(
            n_blades=_PAPER.disk.n_blades,
            tip_radius=_PAPER.disk.tip_radius,
            hub_radius=hub_radius,
            inner_radius=1e-3 * d.inner_radius_mm,
            width=_PAPER.disk.width,
            ring_thickness=1e-3 * ring,
            spoke_thickness=1e-3 * spoke,
            blade=SimpleNamespace(
                n_elements=n_elements,
                thickness=1e-3 * blade,
                lean=np.radians(d.lean_deg),
                bow=d.bow * (1 + d.skew * (2 * z - 1)),
            ),
        ),
        _PAPER.material,
    )


def _hub_motion(ring_radius, hub_radius):
    """Ring u, u', v at its own radius to those of the section's point on the hub circle, (3, 3).

    The section turns by omega = v/R - u' and moves that point, (hub - ring) further out, with it.
    """
    omega = np.array([0, -1, 1 / ring_radius])
    u, v = np.array([1, 0, 0]), np.array([0, 0, 1]) + (hub_radius - ring_radius) * omega
    return np.array([u, v / hub_radius - omega, v])


def family(disk):
    """Frequencies of the first family of a tuned disk, ascending, (N,) [Hz]."""
    n = len(disk.blade_dof)
    squares = eigh(
        disk.stiffness, disk.mass, eigvals_only=True, subset_by_index=[0, n - 1], check_finite=False
    )
    return np.sqrt(np.maximum(squares, 0)) / (2 * np.pi)


def in_band(dimensions):
    """The disk with the paper's band: thicknesses of spokes and blades are changed to meet it.

    Parameters
    ----------
    dimensions : Dimensions
        The thicknesses of spokes and blades are where the search starts.

    Returns
    -------
    Dimensions or None
        None if no thicknesses near by meet the band.
    """

    def thick(logarithms):
        spoke, blade = np.exp(np.clip(logarithms, -5, 5))
        return dimensions._replace(spoke_thickness_mm=spoke, blade_thickness_mm=blade)

    def distance(logarithms):
        found = family(build(thick(logarithms)))
        return found[[0, -1]] / BAND - 1

    start = np.log([dimensions.spoke_thickness_mm, dimensions.blade_thickness_mm])
    try:
        found = root(distance, start, method="hybr", options={"maxfev": 60, "xtol": 1e-6})
        if np.abs(found.fun).max() > 1e-4:
            return None
        return Dimensions(*(round(float(x), 6) for x in thick(found.x)))
    except (ValueError, LinAlgError):
        return None


def place(unit, bounds, base):
    """The disk at a point of the unit cube.

    Parameters
    ----------
    unit : (n,) [-]
    bounds : dict
        Name and range of what the n coordinates stand for.
    base : Dimensions
        All else.

    Returns
    -------
    Dimensions
    """
    values = {
        name: float(low + u * (high - low))
        for u, (name, (low, high)) in zip(unit, bounds.items(), strict=True)
    }
    return base._replace(**values)


def unit_of(dimensions, bounds):
    """The point of the unit cube of a disk, (n,); the inverse of `place`."""
    ends = np.array(list(bounds.values()))
    values = np.array([getattr(dimensions, name) for name in bounds])
    return (values - ends[:, 0]) / (ends[:, 1] - ends[:, 0])


def reduced(dimensions):
    """Reduced model of a disk. Returns a ReducedModel."""
    return craig_bampton(build(dimensions), N_MODES)
