"""Event-driven reference of one mass against a wall that gives: exact motion from event to event.

    m ü + c u̇ + s u = −N,   N = K p + D ṗ − C,   p = u − gap

with K, D, C of the line of forces that holds between two events: the coating untouched (p < w), its
elastic line, its plastic line, each with the casing behind it or without. Every piece is linear, so
a matrix exponential solves it; events are located to rounding. Only NumPy and SciPy: nothing is
shared with the kernel.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

UNTOUCHED, ELASTIC, PLASTIC = range(3)  # coating
AWAY, PRESSED, DETACHED = range(3)  # casing: DETACHED pulls off a damper that would pull it


class Mass(NamedTuple):
    """A mass on a spring and a damper."""

    mass: float
    damper: float
    spring: float


class Motion(NamedTuple):
    """State at the times 0, dt, 2 dt, ..."""

    place: np.ndarray  # u (n + 1,) [m]
    worn: np.ndarray  # w (n + 1,) [m]
    highest: float  # largest u, between these times, too [m]
    events: list  # times [s]


class Reference:
    """One mass, one wall."""

    def __init__(self, mass, bar, gap, stiffness=0.0, damping=0.0):
        """bar: thickness, E, σ_Y, H and area of a coating, zeros without one; stiffness, damping:
        of the casing behind it."""
        self.mass, self.gap, self.k, self.d = mass, gap, stiffness, damping
        self.thickness, E, yields, H, area = bar
        self.k1 = E * area / self.thickness if E else 0.0
        self.k2 = self.k1 * H / (E + H) if E else 0.0
        self.c0 = area * E * yields / (E + H) if E else 0.0

    def _flow(self, regime, w, dt):
        """Matrix that takes (u, u̇, 1) a time dt further."""
        coat, casing = regime
        K = (0.0, self.k1, self.k2)[coat]
        C = (0.0, self.k1 * w, -self.c0)[coat]
        D = 0.0
        if casing != AWAY:  # the bar is used up, and keeps its force
            K, C = 0.0, C - K * self.thickness
        if casing == PRESSED:
            K, D, C = self.k, self.d, C + self.k * self.thickness
        m, c, s = self.mass
        A = np.zeros((3, 3))
        A[0, 1] = 1.0
        A[1] = np.array([-(s + K), -(c + D), K * self.gap + C]) / m
        return expm(A * dt)

    def _guards(self, regime, y, w):
        """What is positive as long as a regime holds, and the regime that follows each."""
        (coat, casing), p, v = regime, y[0] - self.gap, y[1]
        t = self.thickness
        if casing != AWAY:
            pass  # no strain changes
        elif self.k1 and coat == UNTOUCHED:
            yield w - p, (ELASTIC, casing)
        elif coat == ELASTIC:
            yield p - w, (UNTOUCHED, casing)
            yield self.k2 * p + self.c0 - self.k1 * (p - w), (PLASTIC, casing)
        elif coat == PLASTIC:
            yield v, (ELASTIC, casing)
        push = self.k * (p - t) + self.d * v
        if self.k and casing == AWAY:
            yield t - p, (coat, PRESSED)
        elif casing == PRESSED:
            yield push, (coat, DETACHED if self.d else AWAY)
        elif casing == DETACHED:
            yield -push, (coat, PRESSED)
            yield p - t, (coat, AWAY)

    def _worn(self, y, w, regime):
        """Worn depth at a state: on the plastic line, where the elastic one meets it."""
        if regime[0] != PLASTIC:
            return w
        p = min(y[0] - self.gap, self.thickness)
        return max(w, p - (self.k2 * p + self.c0) / self.k1)

    def run(self, velocity, dt, n_steps):
        """Motion from u = 0 with a velocity; two events must be further apart than dt."""
        y, w, regime = np.array([0.0, velocity, 1.0]), 0.0, (UNTOUCHED, AWAY)
        out, worn, events, highest = [y], [w], [], 0.0
        whole = self._flow(regime, w, dt)
        for n in range(n_steps):
            t, end = n * dt, (n + 1) * dt
            while t < end:
                matrix = whole if t == n * dt else self._flow(regime, w, end - t)
                new = matrix @ y
                turned = y[1] > 0.0 >= new[1]
                broken = [
                    after
                    for (value, after), (before, _) in zip(
                        self._guards(regime, new, w), self._guards(regime, y, w), strict=True
                    )
                    if value < 0.0 and (before > 0.0 or value < before)
                ]
                s, after = end - t, None
                for follower in broken:
                    at = self._root(regime, y, w, end - t, follower)
                    if at < s or after is None:
                        s, after = at, follower
                if turned:
                    rest, there = self._rest(regime, y, w, end - t)
                    highest = max(highest, there) if rest <= s else highest
                if after is None:
                    y, t = new, end
                    w = self._worn(y, w, regime)
                    continue
                y, t = self._flow(regime, w, s) @ y, t + s
                w = self._worn(y, w, regime)
                regime = after
                events.append(t)
                whole = self._flow(regime, w, dt)
            out.append(y)
            worn.append(w)
        return Motion(np.array(out)[:, 0], np.array(worn), highest, events)

    def _rest(self, regime, y, w, left):
        """Time at which the mass turns round, and its place then."""
        rest = brentq(lambda s: (self._flow(regime, w, s) @ y)[1], 0.0, left, xtol=1e-18)
        return rest, (self._flow(regime, w, rest) @ y)[0]

    def _root(self, regime, y, w, left, follower):
        """Time at which the guard of a following regime turns negative."""

        def value(s):
            there = self._flow(regime, w, s) @ y
            return next(g for g, after in self._guards(regime, there, w) if after == follower)

        if value(0.0) <= 0.0:
            return 0.0
        return brentq(value, 0.0, left, xtol=1e-18, rtol=8.9e-16)
