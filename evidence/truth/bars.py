"""Event-driven reference of one mass against a wall that gives: exact motion from event to event.

    m ü + c u̇ + s u = −N,   N = K p + D ṗ − C,   p = u − gap

with K, D, C of the line of forces that holds between two events: the coating untouched (p < w), its
elastic line, its plastic line, each with the casing behind it or without. Every piece is linear in
u, u̇ and the worn depth w, so that `events.follow` solves it. Nothing is shared with the kernel.
"""

from typing import NamedTuple

import numpy as np

from evidence.truth.events import follow

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
    velocity: np.ndarray  # u̇ (n + 1,) [m/s]
    worn: np.ndarray  # w (n + 1,) [m]
    events: list  # times, and regimes that end there


class Reference:
    """One mass, one wall: y = (u, u̇, w, 1)."""

    def __init__(self, mass, bar, gap, stiffness=0.0, damping=0.0):
        """bar: thickness, E, σ_Y, H and area of a coating, zeros without one; stiffness, damping:
        of the casing behind it."""
        self.mass, self.gap, self.k, self.d = mass, gap, stiffness, damping
        self.thickness, E, yields, H, area = bar
        self.k1 = E * area / self.thickness if E else 0.0
        self.k2 = self.k1 * H / (E + H) if E else 0.0
        self.c0 = area * E * yields / (E + H) if E else 0.0

    def matrix(self, regime):
        """A of a regime, coating and casing."""
        coat, casing = regime
        K, C, worn = ((0.0, 0.0, 0.0), (self.k1, 0.0, self.k1), (self.k2, -self.c0, 0.0))[coat]
        D = 0.0
        if casing != AWAY:  # the bar is used up, and keeps its force
            K, C = 0.0, C - K * self.thickness
        if casing == PRESSED:
            K, D, C = self.k, self.d, C + self.k * self.thickness
        m, c, s = self.mass
        A = np.zeros((4, 4))
        A[0, 1] = 1.0
        A[1] = np.array([-(s + K), -(c + D), worn, K * self.gap + C]) / m
        if coat == PLASTIC and casing == AWAY:  # w is where the elastic line meets the plastic one
            A[2, 1] = 1.0 - self.k2 / self.k1
        return A

    def guards(self, regime, y):
        """What is positive as long as a regime holds, and the regime that follows each."""
        (coat, casing), (u, v, w, _) = regime, y
        p, t = u - self.gap, self.thickness
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

    def after(self, y, regime):
        """Nothing jumps at an event."""
        return y, regime

    def run(self, velocity, dt, n_steps):
        """Motion from u = 0 with a velocity; two events must be further apart than dt."""
        begin = np.array([0.0, velocity, 0.0, 1.0])
        y, events = follow(self, begin, (UNTOUCHED, AWAY), dt, n_steps)
        return Motion(*y.T[:3], events)
