"""A disk that rubs while its rotor gains or loses speed: a second program with its own time steps.

The step is constant in time, not in angle. Central differences read q⁺ = q + d⁺,
d⁺ = keep d − pull q + gain f, f the force at the begin of the step. Forces that hold tips before
the rigid casing are those at the end of a step, as forward increments, so that the error is of
first order. The bumps and the solver of the forces are those of `ring`; nothing is shared with the
product.
"""

from typing import NamedTuple

import numpy as np

from evidence.truth import ring


class Structure(NamedTuple):
    """K modes of mass one, and C tips."""

    omega: np.ndarray  # (K,) [rad/s]
    damping: np.ndarray  # ξ (K,)
    normal: np.ndarray  # outward motion of the tips (C, K) [1/√kg]
    tangential: np.ndarray  # towards +θ (C, K) [1/√kg]
    angle: np.ndarray  # of the tips (C,) [rad]


def rubbing_run(structure, wall, angle, h, n, observed):
    """n steps of h [s] from rest of a disk before a `ring.Wall`; angle: function θ(t) [rad].

    observed: rows (O, K) [1/√kg]. Returns their displacements (n + 1, O) [m] at the times 0, h, ...
    n h, and the normal forces of the steps (n, C) [N].
    """
    c = structure.damping * structure.omega * h
    keep, gain = (1.0 - c) / (1.0 + c), h * h / (1.0 + c)
    answer = gain[:, None] * (structure.normal + wall.friction * structure.tangential).T
    delassus = structure.normal @ answer
    q, d = np.zeros((2, len(gain)))
    moved, pushed = np.zeros((n + 1, len(observed))), np.zeros((n, len(answer.T)))
    for k in range(n):
        d = keep * d - structure.omega**2 * gain * q
        t = (k + 1) * h
        bump = ring.bump(wall, angle(t) + structure.angle, t)
        depth = bump - wall.clearance + structure.normal @ (q + d)
        if depth.max() > 0.0:
            pushed[k] = ring.forces(delassus, depth)
            d = d - answer @ pushed[k]
        q = q + d
        moved[k + 1] = observed @ q
    return moved, pushed
