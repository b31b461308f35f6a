"""Linear stability of tips that slide along a vibrating casing without leaving it.

Disk and pairs of the casing are joined at all contact points, R x = 0, by forces λ along R + μT,

    x'' + D x' + S x = −(R + μT)ᵀ λ,

with the pairs as seen from the rotor (`docs/theory.md`, a casing that vibrates). Bumps, clearance
and the end of contact are left out: a motion that grows here grows until the tips leave the casing,
or without bound.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import eig, null_space

from hpcrub.model.damping import Damping, state_matrix
from hpcrub.model.reduction import Modes


class Growth(NamedTuple):
    """The motion in permanent contact that grows fastest."""

    rate: float  # real part of its eigenvalue [1/s]; below 0: all decay
    waves: int  # n of the casing's wave that moves most
    frequency: float  # at which it moves, seen from the rotor [Hz]


def turned_matrices(
    modes: Modes, ratios: np.ndarray, speed: float
) -> tuple[np.ndarray, np.ndarray]:
    """D [1/s] and S [1/s²] of disk and casing, (n, n), seen from the rotor, without contact.

    ratios: damping ratios of all coordinates (n,) [-]; speed: of rotation [rad/s].
    """
    omega = modes._replace(waves=None).rows.omega
    damping, stiffness = np.diag(2.0 * ratios * omega), np.diag(omega**2)
    if modes.waves:
        family = np.ix_(modes.waves.rows, modes.waves.rows)
        damping[family] = modes.waves.damping
        stiffness[family] += modes.waves.stiffness
    for j, n in enumerate(modes.pairs.n_waves):
        c = len(modes.omega) + 2 * j
        s, turn = c + 1, n * speed
        damping[c, s], damping[s, c] = -2.0 * turn, 2.0 * turn
        stiffness[c, c] -= turn**2
        stiffness[s, s] -= turn**2
        twist = 2.0 * ratios[c] * omega[c] * turn
        stiffness[c, s], stiffness[s, c] = -twist, twist
    return damping, stiffness


def eigenvalues(
    mass: np.ndarray, damping: np.ndarray, stiffness: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues (2n,) [1/s] and vectors (n, 2n) of M x'' + D x' + S x = 0, matrices (n, n)."""
    scale = np.sqrt(np.abs(stiffness).max() / np.abs(mass).max())  # frequency to balance the blocks
    inverse = np.linalg.inv(mass)
    values, vectors = eig(state_matrix(inverse @ damping, inverse @ stiffness, scale))
    return values * scale, vectors[: len(mass)]


def growth(modes: Modes, damping: float | Damping, friction: float, speed_hz: float) -> Growth:
    """Fastest growing motion at a speed [Hz] when all tips slide along the casing.

    modes: Modes of the disk at this speed, with the pairs of the casing; damping: of the disk.
    """
    real = modes._replace(waves=None)
    rows, ratios = real.rows, real.damping_ratios(damping)
    D, S = turned_matrices(modes, ratios, 2.0 * np.pi * speed_hz)
    free, left = null_space(rows.normal), null_space(rows.normal + friction * rows.tangential)
    values, vectors = eigenvalues(left.T @ free, left.T @ D @ free, left.T @ S @ free)
    fastest = int(np.argmax(values.real))
    pairs = (free @ vectors[:, fastest])[len(modes.omega) :].reshape(-1, 2)
    size = np.linalg.norm(pairs, axis=1) * np.abs(modes.pairs.radial)
    value, wave = complex(values[fastest]), int(modes.pairs.n_waves[np.argmax(size)])
    return Growth(value.real, wave, abs(value.imag) / (2.0 * np.pi))
