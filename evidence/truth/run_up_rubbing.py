"""A disk that rubs while its rotor gains or loses speed: a second program with its own time steps.

The step is constant in time, not in angle. Central differences read q⁺ = q + d⁺,
d⁺ = keep d − pull q + gain f, f the force at the begin of the step. Forces that hold tips before
the rigid casing are those at the end of a step, as forward increments, so that the error is of
first order. The bumps and the solver of the forces are those of `ring`; nothing is shared with the
product.
"""

import numpy as np

from evidence.truth import ring


def rubbing_run(modes, damping_ratio, tips, wall, angle, h, n):
    """n steps of h [s] from rest of a disk before a `ring.Wall`; angle: function θ(t) [rad].

    modes: ω, and rows of the contact points and of what is observed; tips: angles of the points
    (C,) [rad]. Returns the displacements (n + 1, O) [m] at the times 0, h, ... n h, and the normal
    forces of the steps (n, C) [N].
    """
    c = damping_ratio * modes.omega * h
    keep, gain = (1.0 - c) / (1.0 + c), h * h / (1.0 + c)
    answer = gain[:, None] * (modes.normal + wall.friction * modes.tangential).T
    delassus = modes.normal @ answer
    q, d = np.zeros((2, len(gain)))
    moved, pushed = np.zeros((n + 1, len(modes.observed))), np.zeros((n, len(answer.T)))
    for k in range(n):
        d = keep * d - modes.omega**2 * gain * q
        t = (k + 1) * h
        bump = ring.bump(wall, angle(t) + tips, t)
        depth = bump - wall.clearance + modes.normal @ (q + d)
        if depth.max() > 0.0:
            pushed[k] = ring.forces(delassus, depth)
            d = d - answer @ pushed[k]
        q = q + d
        moved[k + 1] = modes.observed @ q
    return moved, pushed
