"""The contact interface: contact points and observed displacements of a reduced disk.

The contact kernel knows a disk of any origin through this tuple alone. Any number of contact points
may belong to a blade, at any radius and axial position.
"""

from typing import NamedTuple

import numpy as np

from hpcrub.model.second_order import SecondOrder

STRIP_GAP = (
    1e-4  # axial distance of places, as a share of the largest radius; nodes pair up to it, too
)


class Interface(NamedTuple):
    """Contact points between disk and casing: C points, N blades, O observed displacements.

    Displacements are rows over the m coordinates of the reduced model.
    """

    blade: np.ndarray  # (C,) int, index of the blade of each contact point
    angle: np.ndarray  # (C,) in the rotating frame [rad]
    radius: np.ndarray  # (C,) [m]
    axial_position: np.ndarray  # (C,) z [m]
    clearance: np.ndarray  # (C,) added to the clearance of the casing [m]
    normal: np.ndarray  # (C, m) displacement along the outward normal of the casing
    tangential: np.ndarray  # (C, m) displacement towards +theta
    # (C, m) along the casing's generator, axial for a cylinder; (0, m) for a planar disk
    axial: np.ndarray
    observed: np.ndarray  # (O, m) displacements whose largest magnitude is the amplitude
    observed_blade: np.ndarray  # (O,) int, blade of each observed displacement
    stress: np.ndarray = np.zeros((0, 0))  # (R, m) at R places [Pa per coordinate]; R = 0: unknown
    stress_blade: np.ndarray = np.zeros(0, dtype=int)  # (R,) blade of each place
    stress_static: np.ndarray = np.zeros(0)  # (R,) stress by rotation [Pa]; (0,): unknown
    second_order: SecondOrder | None = None  # None: displacements are small, or it is unknown

    @property
    def n_blades(self) -> int:
        """Number of blades N."""
        return 1 + int(max(self.blade.max(), self.observed_blade.max()))

    @property
    def points_per_blade(self) -> np.ndarray:
        """Number of contact points of every blade (N,)."""
        return np.bincount(self.blade, minlength=self.n_blades)

    @property
    def share(self) -> np.ndarray:
        """Share of a blade's load on each contact point (C,), equal for all points of a blade."""
        return 1.0 / self.points_per_blade[self.blade]

    @property
    def strip(self) -> np.ndarray:
        """Strip of a coating that each contact point meets (C,) int, one per axial position."""
        return strips(self.axial_position, self.radius)

    @property
    def bent(self) -> np.ndarray:
        """Amplitudes of the bent modes of all blades (N·p, m) [√kg]; (0, m) without any."""
        if self.second_order is None:
            return np.zeros((0, self.normal.shape[1]))
        return self.second_order.participation.reshape(-1, self.normal.shape[1])

    @property
    def n_strips(self) -> int:
        """Number of strips of a coating."""
        return 1 + int(self.strip.max())

    def of_points(self, touching: np.ndarray) -> np.ndarray:
        """Whether any contact point of each blade touches (..., N), from points (..., C)."""
        touches = np.zeros((*touching.shape[:-1], self.n_blades), dtype=bool)
        np.logical_or.at(touches, (..., self.blade), touching)  # type: ignore[arg-type]
        return touches

    def of_blades(self, magnitude: np.ndarray) -> np.ndarray:
        """Largest observed magnitude of every blade (..., N), from (..., O); NaN stays NaN."""
        largest = np.zeros((*magnitude.shape[:-1], self.n_blades))
        np.maximum.at(largest, (..., self.observed_blade), magnitude)  # type: ignore[arg-type]
        return largest


def corresponding(blade: np.ndarray) -> np.ndarray:
    """Rows in the same place on every blade (N, P) int; P is the fewest of any blade.

    blade: blade of each row (n,). The place of a row is that in the order of its blade's rows.
    """
    parts = np.split(np.argsort(blade, kind="stable"), np.cumsum(np.bincount(blade))[:-1])
    return np.array([part[: min(map(len, parts))] for part in parts])


def strips(axial_position: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Strip of a coating (C,) int, from 0, that points at axial positions and radii (C,) [m] meet.

    Points share a strip where no gap wider than STRIP_GAP lies between them.
    """
    order, strip = np.argsort(axial_position), np.zeros(len(radius), dtype=int)
    strip[order[1:]] = np.cumsum(np.diff(axial_position[order]) > STRIP_GAP * radius.max())
    return strip


def planar_interface(
    angle: np.ndarray,
    radius: float | np.ndarray,
    normal: np.ndarray | None = None,
    tangential: np.ndarray | None = None,
    blade: np.ndarray | None = None,
) -> Interface:
    """Interface of a planar disk, whose amplitude is the largest tangential displacement.

    - angle: (C,) angle of each contact point in the rotating frame [rad].
    - radius: (C,) radius of each point, or one for all [m].
    - normal, tangential: (C, m) displacements per unit coordinate; by default the coordinates are
      all u_r, then all u_t.
    - blade: (C,) blade of each point; by default every blade has one.
    """
    angle = np.asarray(angle, dtype=float)
    n = len(angle)
    if normal is None or tangential is None:
        normal, tangential = np.eye(2 * n)[:n], np.eye(2 * n)[n:]
    blade = np.arange(n) if blade is None else np.asarray(blade)
    return Interface(
        blade=blade,
        angle=angle,
        radius=np.broadcast_to(radius, n).astype(float),
        axial_position=np.zeros(n),
        clearance=np.zeros(n),
        normal=normal,
        tangential=tangential,
        axial=np.zeros((0, normal.shape[1])),
        observed=tangential,
        observed_blade=blade,
    )
