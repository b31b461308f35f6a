"""Event-driven reference: exact motion between impacts and releases that are located to rounding.

The continuous problem whose limit h → 0 the kernel computes for a fixed set of modes is

    q̈ + 2ξω q̇ + ω² q = −(R + μT)ᵀλ,   g = w(t) − R q ≥ 0,   λ ≥ 0,   λ g = 0

and, as modes carry mass, it needs an impact law besides. The kernel ends the step of an impact on
the wall and the next one with the wall's velocity: Newton's law with restitution e = 0,

    p = (R q̇ − ẇ)/S ≥ 0,   q̇ ← q̇ − (R + μT)ᵀp,   S = R (R + μT)ᵀ.

While contact lasts, R q̈ = ẅ gives λ = −(R(2ξω q̇ + ω² q) + ẅ)/S, a linear motion of one
degree of freedom less; it ends where λ turns negative. Both motions are y' = A y + b ẅ(t) for
y = (q, q̇, impulse), propagated by matrix exponentials and, for the wall, by Gauss–Legendre
quadrature of the variation of constants. Only NumPy and SciPy: nothing is shared with the kernel.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


class Wall(NamedTuple):
    """Place of a moving wall and its derivatives, functions of time."""

    place: callable
    velocity: callable
    acceleration: callable


class Motion(NamedTuple):
    """Exact motion at the times 0, dt, 2 dt, ..."""

    position: np.ndarray  # q (n + 1, K)
    velocity: np.ndarray  # q̇ (n + 1, K)
    impulse: np.ndarray  # of the contact force since t = 0 (n + 1,) [N s]
    impacts: list  # times [s]
    lost: float  # kinetic energy lost in impacts [J]


class _Flow:
    """y' = A y + b ẅ(t) over steps of any length."""

    def __init__(self, A, b, wall, dt):
        self.A, self.b, self.wall, self.dt = A, b, wall, dt
        self.whole = self._operators(dt)

    def _operators(self, s):
        at = s * (_NODES + 1.0) / 2.0
        pushes = [
            weight * s / 2.0 * expm(self.A * (s - a)) @ self.b
            for a, weight in zip(at, _WEIGHTS, strict=True)
            if self.b.any()
        ]
        return expm(self.A * s), np.array(pushes), at

    def __call__(self, y, t, s):
        propagator, pushes, at = self.whole if s == self.dt else self._operators(s)
        y = propagator @ y
        if len(pushes):
            y = y + np.array([self.wall.acceleration(t + a) for a in at]) @ pushes
        return y


class Reference:
    """One structure (`motion.Structure`) and one wall."""

    def __init__(self, structure, wall, dt):
        """dt: step between outputs [s]; two events of the same kind must not share a step."""
        self.wall, self.dt = wall, dt
        self.R = structure.radial
        self.push = structure.radial + structure.friction * structure.tangential
        self.S = self.R @ self.push
        self.K = K = len(self.R)
        spring = structure.omega**2
        damper = 2.0 * structure.damping_ratio * structure.omega
        A = np.zeros((2 * K + 1, 2 * K + 1))
        A[:K, K : 2 * K] = np.eye(K)
        A[K : 2 * K, :K], A[K : 2 * K, K : 2 * K] = -np.diag(spring), -np.diag(damper)
        self.row = -np.concatenate([self.R * spring, self.R * damper, [0.0]]) / self.S
        act = np.concatenate([np.zeros(K), -self.push, [1.0]])  # of λ on y'
        still = np.zeros(2 * K + 1)
        self.free = _Flow(A, still, wall, dt)
        self.stuck = _Flow(A + np.outer(act, self.row), -act / self.S, wall, dt)

    def _gap(self, y, t):
        return self.wall.place(t) - self.R @ y[: self.K]

    def _force(self, y, t):
        return self.row @ y - self.wall.acceleration(t) / self.S

    def _impact(self, y, t):
        """State after an impact, and the kinetic energy lost relative to the wall."""
        K = self.K
        approach = self.R @ y[K : 2 * K] - self.wall.velocity(t)
        p = approach / self.S
        y = y.copy()
        y[K : 2 * K] -= self.push * p
        y[-1] += p
        return y, p * approach / 2.0

    def run(self, q, v, n_steps):
        """Motion from q, v (K,) without contact at t = 0."""
        y, stuck = np.concatenate([q, v, [0.0]]), False
        out, impacts, lost = [y], [], 0.0
        for n in range(n_steps):
            t, end = n * self.dt, (n + 1) * self.dt
            while t < end:
                left = self.dt if t == n * self.dt else end - t
                flow, watch = (self.stuck, self._force) if stuck else (self.free, self._gap)
                new = flow(y, t, left)
                if watch(new, t + left) >= 0.0:
                    y, t = new, end
                    continue
                s = _first_zero(flow, watch, y, t, left)
                y, t = flow(y, t, s), t + s
                if not stuck:
                    y, loss = self._impact(y, t)
                    impacts.append(t)
                    lost += loss
                stuck = not stuck and self._force(y, t) > 0.0
            out.append(y)
        out = np.array(out)
        return Motion(out[:, : self.K], out[:, self.K : -1], out[:, -1], impacts, lost)


def _first_zero(flow, watch, y, t, left):
    """Time from t at which the watched quantity, negative at the end, turns negative."""

    def value(s):
        return watch(flow(y, t, s), t + s)

    start = 0.0
    if value(start) <= 0.0:  # on the wall at rest since the last event: look for where it left
        start = next((s for s in left * np.linspace(0.02, 0.98, 49) if value(s) > 0.0), None)
        if start is None:
            return 0.0
    return brentq(value, start, left, xtol=1e-15, rtol=8.9e-16)
