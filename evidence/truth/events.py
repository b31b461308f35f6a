"""Exact motion from event to event, which are located to rounding; a structure before a wall.

Between two events a motion is linear, y' = A y, so that a matrix exponential solves it: `follow`
does so for any system of regimes. One of them is the continuous problem whose limit h → 0 the
kernel computes for a fixed set of modes,

    q̈ + 2ξω q̇ + ω² q = −(R + μT)ᵀλ,   g = w(t) − R q ≥ 0,   λ ≥ 0,   λ g = 0.

As modes carry mass, it needs an impact law besides. The kernel ends the step of an impact on the
wall and the next one with the wall's velocity: Newton's law with restitution e = 0,

    p = (R q̇ − ẇ)/S ≥ 0,   q̇ ← q̇ − (R + μT)ᵀp,   S = R (R + μT)ᵀ.

While contact lasts, R q̈ = ẅ gives λ = −(R(2ξω q̇ + ω² q) + ẅ)/S, a linear motion of one
degree of freedom less; it ends where λ turns negative. Only NumPy and SciPy: nothing is shared with
the kernel.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

SEARCHED = np.linspace(0.0, 0.98, 50)  # shares of a step at which a guard may have become positive


def follow(system, y, regime, dt, n_steps):
    """States (n + 1, m) at the times 0, dt, ... from y (m,), and events (time, regime that ends).

    system: has `matrix`, A of a regime; `guards` of a regime and a state, which yields what is
    positive as long as the regime holds, and the regime that follows it; `after`, the state and the
    regime after an event. Two events of the same kind must not share a step dt [s].
    """
    out, events, flows = [y], [], {}
    for n in range(n_steps):
        t, end = n * dt, (n + 1) * dt
        while t < end:
            left = dt if t == n * dt else end - t
            if (regime, left) not in flows:
                flows[regime, left] = expm(system.matrix(regime) * left)
            new, at = flows[regime, left] @ y, {}
            both = zip(system.guards(regime, new), system.guards(regime, y), strict=True)
            for (value, follower), (before, _) in both:
                if value < 0.0 and (before > 0.0 or value < before):
                    at[follower] = _first_zero(system, regime, y, left, follower)
            if not at:
                y, t = new, end
                continue
            follower = min(at, key=at.get)
            y, t = expm(system.matrix(regime) * at[follower]) @ y, t + at[follower]
            events.append((t, regime))
            y, regime = system.after(y, follower)
        out.append(y)
    return np.array(out), events


def _first_zero(system, regime, y, left, follower):
    """Time from now at which the guard before a follower, negative at the end, turns negative."""

    def value(s):
        there = expm(system.matrix(regime) * s) @ y
        return next(g for g, after in system.guards(regime, there) if after == follower)

    # zero at rest since the last event: look for where it left
    start = next((s for s in left * SEARCHED if value(s) > 0.0), None)
    return 0.0 if start is None else brentq(value, start, left, xtol=1e-18, rtol=8.9e-16)


class Wall(NamedTuple):
    """A wall that moves as mean + amplitude cos(nu t) [m], [rad/s]."""

    mean: float
    amplitude: float
    nu: float

    def place(self, t):
        """Where it is at times [m]."""
        return self.mean + self.amplitude * np.cos(self.nu * t)


class Motion(NamedTuple):
    """Exact motion at the times 0, dt, 2 dt, ..."""

    position: np.ndarray  # q (n + 1, K)
    impulse: np.ndarray  # of the contact force since t = 0 (n + 1,) [N s]
    impacts: list  # times [s]


class Reference:
    """One structure (`motion.Structure`) and one wall: y = (q, q̇, impulse, wall's cos, sin, 1)."""

    def __init__(self, structure, wall):
        """The regimes are whether the structure stays on the wall."""
        self.wall, R, self.K = wall, structure.radial, len(structure.radial)
        q, v = np.split(np.arange(2 * self.K), 2)
        A = np.zeros((2 * self.K + 4, 2 * self.K + 4))
        A[q, v], A[v, q] = 1.0, -(structure.omega**2)
        A[v, v] = -2.0 * structure.damping_ratio * structure.omega
        A[-3, -2], A[-2, -3] = -wall.nu, wall.nu
        self.gap = np.zeros(len(A))
        self.gap[q], self.gap[-3], self.gap[-1] = -R, 1.0, wall.mean
        self.kick = np.zeros(len(A))  # of a unit of impulse
        self.kick[v] = -(R + structure.friction * structure.tangential)
        self.kick[2 * self.K] = 1.0
        S = -(R @ self.kick[v])
        self.approach, self.force = -(self.gap @ A) / S, -(self.gap @ A @ A) / S
        self.matrices = A, A + np.outer(self.kick, self.force)

    def matrix(self, stays):
        """A of a regime."""
        return self.matrices[stays]

    def guards(self, stays, y):
        """The gap, or the force."""
        yield (self.force if stays else self.gap) @ y, not stays

    def after(self, y, touches):
        """State after an impact or a release, and whether the structure stays."""
        if touches:
            y = y + self.kick * (self.approach @ y)
        return y, bool(touches and self.force @ y > 0.0)

    def run(self, q, v, dt, n_steps):
        """Motion from q, v (K,) without contact at t = 0; dt: step between outputs [s]."""
        begin = np.concatenate([q, v, [0.0, self.wall.amplitude, 0.0, 1.0]])
        y, events = follow(self, begin, False, dt, n_steps)
        impacts = [t for t, stayed in events if not stayed]
        return Motion(y[:, : self.K], y[:, 2 * self.K], impacts)
