"""A casing that vibrates: waves around an elastic casing, as points in rotation see them.

At the angle θ of the casing the wave with n periods moves it outward by w and towards +θ by v,

    w = A (c cos nθ + s sin nθ),    v = B (c sin nθ − s cos nθ),

with ordinary modal coordinates c and s of one frequency. In coordinates that are turned by nΩt
the projections on contact points in rotation are constant, so that a casing that vibrates adds a
few pairs of rows to the modes of the disk (`Modes.rows`). `docs/theory.md` derives them.

Legrand, Pierre, Cartraud, Lombard, J. Sound Vib. 319 (2009), treats the ring in contact with a
bladed disk; Soedel, Vibrations of shells and plates, its free vibration.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh


class CasingModes(NamedTuple):
    """J mass-normalised pairs of modes of a round casing; for n = 0 the sine stays idle."""

    n_waves: np.ndarray  # n (J,) int, periods around the circumference [-]
    omega: np.ndarray  # angular eigenfrequency (J,) [rad/s]
    damping_ratio: np.ndarray  # (J,) [-]
    radial: np.ndarray  # A (J,), largest outward motion [1/√kg]
    tangential: np.ndarray  # B (J,) [1/√kg]

    def rows(self, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Motion w and v at angles (C,) [rad] per unit c, s of each pair: two (C, 2J) [1/√kg]."""
        phase = np.asarray(angle)[:, None] * self.n_waves
        cosine, sine = np.cos(phase), np.sin(phase)
        outward = np.stack([self.radial * cosine, self.radial * sine], axis=-1)
        along = np.stack([self.tangential * sine, -self.tangential * cosine], axis=-1)
        return outward.reshape(len(phase), -1), along.reshape(len(phase), -1)

    def seen_from(self, angle: np.ndarray) -> "Pairs":
        """Pairs as seen by contact points at angles (C,) [rad] of the rotating frame."""
        outward, along = self.rows(angle)
        return Pairs(self.n_waves, self.omega, self.damping_ratio, self.radial, -outward, -along)

    @property
    def critical_speeds(self) -> np.ndarray:
        """Speeds ω/n of the waves around the casing (J,) [rad/s]; infinite for n = 0."""
        with np.errstate(divide="ignore"):
            return self.omega / self.n_waves


class Pairs(NamedTuple):
    """J pairs of modes of a casing, projected on C contact points in rotation."""

    n_waves: np.ndarray  # (J,) int [-]
    omega: np.ndarray  # (J,) [rad/s]
    damping_ratio: np.ndarray  # (J,) [-]
    radial: np.ndarray  # A (J,) [1/√kg]
    # motion of the points relative to the casing per unit coordinate: towards the casing, and
    # forward along it (C, 2J) [1/√kg]
    normal: np.ndarray
    tangential: np.ndarray


NO_PAIRS = Pairs(np.zeros(0, dtype=int), *np.zeros((3, 0)), *np.zeros((2, 0, 0)))


class Ring(NamedTuple):
    """A circular ring of rectangular section on a bed of springs."""

    radius: float  # R, of the middle of the section [m]
    thickness: float  # t, radial [m]
    width: float  # b, axial [m]
    young: float  # E [Pa]
    density: float  # ρ [kg/m³]
    bed_radial: float = 0.0  # k_r, per metre of circumference [N/m²]
    bed_tangential: float = 0.0  # k_t [N/m²]


def ring_modes(ring: Ring, n_waves: np.ndarray, damping_ratio: float) -> CasingModes:
    """Flexural modes of a ring: for each n the lower root of membrane and bending together.

    n_waves: (J,) int; n = 0 is the breathing mode.
    Raises ValueError: for a wave without stiffness, such as n = 1 on a ring without a bed.
    Source: Soedel, Vibrations of shells and plates, chapter on rings; Love's theory.
    """
    R, E = ring.radius, ring.young
    area, inertia = ring.width * ring.thickness, ring.width * ring.thickness**3 / 12.0
    line = ring.density * area  # mass of a metre of circumference [kg/m]
    omega, radial, tangential = np.zeros((3, len(n_waves)))
    for j, n in enumerate(n_waves):
        membrane = E * area / R**2 * np.array([[1.0, n], [n, n**2]])
        bending = E * inertia / R**4 * np.array([[n**4, n**3], [n**3, n**2]], dtype=float)
        squares = (membrane + bending + np.diag([ring.bed_radial, ring.bed_tangential])) / line
        values, shapes = eigh(squares) if n else (squares[:1, 0], np.eye(2))  # n = 0: w alone
        if not values[0] > 1e-12 * squares[0, 0]:
            raise ValueError(f"nothing holds the wave n = {n}")
        omega[j] = np.sqrt(values[0])
        mass = line * np.pi * R * (1.0 if n else 2.0)
        radial[j], tangential[j] = shapes[:, 0] / np.sqrt(mass) * np.sign(shapes[0, 0])
    ratio = np.full(len(n_waves), damping_ratio)
    return CasingModes(np.asarray(n_waves), omega, ratio, radial, tangential)
