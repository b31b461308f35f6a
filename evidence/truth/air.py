"""A disk in air in contact, as one first-order system: the twin of the complex modes of the kernel.

Positions and velocities of all real modes are one state; its matrix, with the dense damping and the
unsymmetric stiffness of the air, is advanced by the matrix exponential. A contact force is an
impulse at the beginning of a step. Plain NumPy and SciPy, and the wall of `evidence.truth.ring`.
"""

import numpy as np
from scipy.linalg import expm

from evidence.truth.ring import bump, forces


def integrate(D, K, normal, tangential, angle, wall, speed_hz, steps, n):
    """Modal coordinates (n, m) after n steps from rest, and normal forces (n, C) [N].

    D, K: (m, m) of x'' + D x' + K x = f; normal, tangential: (C, m); steps: of a revolution.
    """
    m, h = len(D), 1.0 / (speed_hz * steps)
    advance = expm(h * np.block([[np.zeros((m, m)), np.eye(m)], [-K, -D]]))
    kick = h * advance[:, m:]  # state by a modal force at the beginning of the step
    G = normal + wall.friction * tangential
    W = normal @ kick[:m] @ G.T
    state, found = np.zeros(2 * m), (np.zeros((n, m)), np.zeros((n, len(angle))))
    for step in range(n):
        state = advance @ state
        theta = angle + 2.0 * np.pi * (step + 1) / steps
        p = normal @ state[:m] + bump(wall, theta, (step + 1) * h) - wall.clearance
        if p.max() > 0.0:
            push = forces(W, p)
            state = state - kick @ (G.T @ push)
            found[1][step] = push
        found[0][step] = state[:m]
    return found
