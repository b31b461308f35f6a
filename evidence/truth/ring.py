"""A disk in a casing that vibrates, in the fixed frame: the twin of the turned pairs of the kernel.

The casing's modes stay in the frame in which they do not turn; what turns are the places of the
blades, so that projections and Delassus operator are made anew at every step. Every mode follows
the exact three-level recurrence q⁺ = 2 e^{−ξωh} cos(ω_d h) q − e^{−2ξωh} q⁻ + g f, whose factor g
gives a constant force its static displacement, and stands where the blades are at the begin of its
step. Plain NumPy and a projected Gauss–Seidel of its own, which the other second programs use, too.
"""

from typing import NamedTuple

import numba
import numpy as np

SWEEPS = 5000  # at most


class Wall(NamedTuple):
    """Bumps on the ring, clearance, friction."""

    n_bumps: int = 4
    height: float = 1.25e-3
    clearance: float = 0.25e-3
    friction: float = 0.15
    ramp_time: float = 0.01


def wall_of(scene):
    """The Wall of a Scene."""
    return Wall(*scene.casing[:2], scene.clearance, scene.friction, scene.ramp_time)


class Run(NamedTuple):
    """Motion after every step."""

    disk: np.ndarray  # modal coordinates (n, K)
    ring: np.ndarray  # c and s of every pair (n, 2J)
    force: np.ndarray  # normal forces (n, C) [N]


def recurrence(omega, damping_ratio, h):
    """Factors of q, of q before and of a force, (K,) each."""
    e = np.exp(-damping_ratio * omega * h)
    cosine = np.cos(omega * np.sqrt(1.0 - damping_ratio**2) * h)
    return 2.0 * e * cosine, -(e**2), (1.0 - 2.0 * e * cosine + e**2) / omega**2


@numba.njit
def bump(wall, theta, t):
    """Height of the bumps at angles of the casing [m]."""
    pitch = 2.0 * np.pi / wall.n_bumps
    phi = (theta + pitch / 2.0) % pitch - pitch / 2.0
    x = 5.0 * min(t / wall.ramp_time, 1.0) if wall.ramp_time else 5.0
    grown = (1.0 - np.exp(-x)) / (1.0 - np.exp(-5.0))
    return grown * wall.height * np.exp(-((phi / (0.1 * pitch)) ** 2))


@numba.njit
def forces(W, p):
    """λ ≥ 0, p − Wλ ≤ 0, λ·(p − Wλ) = 0 (n_c,), to rounding. Raises RuntimeError."""
    found, last = np.zeros(len(p)), np.inf
    for _ in range(SWEEPS):
        change = 0.0
        for i in range(len(p)):
            new = max(0.0, found[i] + (p[i] - W[i] @ found) / W[i, i])
            change, found[i] = max(change, abs(new - found[i]) * W[i, i]), new
        if change <= 1e-16 + 1e-14 * p.max() or change >= last < 1e-13 * p.max():
            return found
        last = change
    raise RuntimeError("Gauss-Seidel did not converge")


def integrate(omega, damping_ratio, normal, tangential, angle, ring, wall, speed_hz, steps, n):
    """The Run of n steps of a disk of modes (K,), (C, K) [1/√kg] at rest; steps: of a turn.

    ring: n, ω, ξ, A and B of J pairs: w = A (c cos nθ + s sin nθ), v = B (c sin nθ − s cos nθ).
    """
    waves, ring_omega, ring_ratio, A, B = ring
    h = 1.0 / (speed_hz * steps)
    all_omega = np.concatenate([omega, np.repeat(ring_omega, 2)])
    ratio = np.concatenate([np.full(len(omega), damping_ratio), np.repeat(ring_ratio, 2)])
    keep, before, gain = recurrence(all_omega, ratio, h)
    K, (q, old) = len(omega), np.zeros((2, len(all_omega)))
    found = Run(*(np.zeros((n, m)) for m in (K, 2 * len(waves), len(angle))))

    def seen(step):
        """Normal and tangential rows (C, K + 2J) of the points after so many steps."""
        phase = (angle + 2.0 * np.pi * step / steps)[:, None] * waves
        cosine, sine = np.cos(phase), np.sin(phase)
        w = np.stack([A * cosine, A * sine], -1).reshape(len(angle), -1)
        v = np.stack([B * sine, -B * cosine], -1).reshape(len(angle), -1)
        return np.hstack([normal, -w]), np.hstack([tangential, -v])

    for step in range(n):
        (R0, T0), (R, _) = seen(step), seen(step + 1)
        new = keep * q + before * old
        theta = angle + 2.0 * np.pi * (step + 1) / steps
        p = R @ new + bump(wall, theta, (step + 1) * h) - wall.clearance
        push = np.zeros(len(angle))
        if p.max() > 0.0:
            G = R0 + wall.friction * T0
            push = forces((R * gain) @ G.T, p)
            new = new - gain * (G.T @ push)
        old, q = q, new
        found.disk[step], found.ring[step], found.force[step] = q[:K], q[K:], push
    return found
