"""The contact interface: what the casing and the observer see of a reduced disk.

A disk of any origin meets the contact kernel through this tuple alone. Any number of contact points
may belong to a blade, at any radius and axial position.
"""

from typing import NamedTuple

import numpy as np


class Interface(NamedTuple):
    """Contact points between disk and casing: C points, N blades, O observed displacements.

    Displacements are rows over the m coordinates of the reduced model.
    """

    blade: np.ndarray  # (C,) int, index of the blade of each contact point
    angle: np.ndarray  # (C,) in the rotating frame [rad]
    radius: np.ndarray  # (C,) [m]
    axial_position: np.ndarray  # (C,) z [m]
    clearance: np.ndarray  # (C,) of each point, beyond the casing's own [m]
    normal: np.ndarray  # (C, m) displacement along the outward normal of the casing
    tangential: np.ndarray  # (C, m) displacement towards +theta
    # (C, m) along the casing's generator, axial for a cylinder; (0, m) for a planar disk
    axial: np.ndarray
    observed: np.ndarray  # (O, m) displacements whose largest magnitude is the amplitude
    observed_blade: np.ndarray  # (O,) int, blade of each observed displacement
    # stress at R places, (R, m) [Pa per coordinate], and the blade of each (R,); (0, m): not known
    stress: np.ndarray = np.zeros((0, 0))
    stress_blade: np.ndarray = np.zeros(0, dtype=int)
    stress_static: np.ndarray = np.zeros(0)  # of the rotation (R,) [Pa]; (0,): not known

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
        """Part of its blade's load on each contact point (C,), the same on all of a blade."""
        return 1.0 / self.points_per_blade[self.blade]

    @property
    def strip(self) -> np.ndarray:
        """Strip of a coating that each contact point meets (C,) int: one for each axial place."""
        return strips(self.axial_position)

    @property
    def n_strips(self) -> int:
        """Strips of a coating."""
        return 1 + int(self.strip.max())

    def of_points(self, touching: np.ndarray) -> np.ndarray:
        """Whether any contact point of each blade touches, (..., C) to (..., N) of bool."""
        found = np.zeros((*touching.shape[:-1], self.n_blades), dtype=bool)
        for point, blade in enumerate(self.blade):
            found[..., blade] |= touching[..., point]
        return found

    def of_blades(self, magnitude: np.ndarray) -> np.ndarray:
        """Largest of the observed magnitudes (..., O) of every blade (..., N); NaN where one is."""
        largest = np.zeros((*magnitude.shape[:-1], self.n_blades))
        np.maximum.at(largest, (..., self.observed_blade), magnitude)  # type: ignore[arg-type]
        return largest


def strips(axial_position: np.ndarray) -> np.ndarray:
    """Strip of a coating that points at axial places (C,) [m] meet, (C,) int, from 0."""
    return np.unique(np.round(axial_position, 9), return_inverse=True)[1]


def planar_interface(
    angle: np.ndarray,
    radius: float | np.ndarray,
    normal: np.ndarray | None = None,
    tangential: np.ndarray | None = None,
    blade: np.ndarray | None = None,
) -> Interface:
    """Interface of a planar disk, whose amplitude is the largest tangential displacement.

    - angle: (C,) angle of each contact point in the rotating frame [rad].
    - radius: (C,) of all of them, or of each [m].
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
