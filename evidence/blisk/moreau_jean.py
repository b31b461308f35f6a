"""A second program for rubbing: Moreau-Jean time stepping on the reduced matrices.

Velocity-impulse formulation with theta = 1/2 on physical coordinates, no modes; Newton's impact
law without restitution; Coulomb friction that always slides, against the slip velocity of the step
before; complementarity by projected Gauss-Seidel with its own stopping rule. It shares with hpcrub
only the matrices and the interface.
Source: Acary, Brogliato (2008), Numerical methods for nonsmooth dynamical systems, section 10.1.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.linalg import eigh

TOLERANCE = 1e-10  # of an impulse, as a share of the largest
MOST_SWEEPS = 5000


class Case(NamedTuple):
    """Casing and speed."""

    speed_hz: float
    n_bumps: int
    height: float  # of the bumps [m]
    clearance: float  # [m]
    ramp_time: float  # [s]
    friction: float
    damping_ratio: float


def integrate(model, case, step, duration):
    """Observed displacements after every step (n_steps, O) [m], from rest.

    model: ReducedModel at the case's speed.
    """
    face, M, K = model.interface, model.mass, model.stiffness
    values, modes = eigh(K, M)
    momentum = M @ modes
    C = momentum @ np.diag(2 * case.damping_ratio * np.sqrt(values)) @ momentum.T
    inverse = np.linalg.inv(M + step / 2 * C + step**2 / 4 * K)
    axial = face.axial if len(face.axial) else np.zeros_like(face.normal)
    free = -step * inverse @ K, -step * inverse @ (C + step / 2 * K)
    rows = [np.ascontiguousarray(row) for row in (face.normal, face.tangential, axial)]
    inverse_rows = [np.ascontiguousarray((inverse @ row.T).T) for row in rows]
    return _steps(
        *map(np.ascontiguousarray, free),
        np.stack(rows),
        np.stack(inverse_rows),
        np.ascontiguousarray(face.observed),
        2 * np.pi * case.speed_hz * face.radius,
        case.clearance + face.clearance,
        face.angle,
        np.array(case[:3] + case[4:6]),
        step,
        round(duration / step),
    )


@njit
def bumps(angle, case, t):
    """Height of the casing over a point [m], and its rate [m/s]."""
    speed_hz, n_bumps, height, ramp_time, _ = case
    omega, pitch = 2 * np.pi * speed_hz, 2 * np.pi / n_bumps
    phi = (angle + omega * t + pitch / 2) % pitch - pitch / 2
    width = 0.1 * pitch
    shape = height * np.exp(-((phi / width) ** 2))
    rate = -2 * phi / width**2 * shape * omega
    if t >= ramp_time:
        return shape, rate
    rising = np.exp(-5 * t / ramp_time) / (1 - np.exp(-5.0))
    ramp = 1 / (1 - np.exp(-5.0)) - rising
    return ramp * shape, ramp * rate + 5 / ramp_time * rising * shape


@njit
def _steps(free_u, free_v, rows, inverse_rows, observed, slide, clearance, angle, case, step, n):
    n_points, m = rows.shape[1:]
    friction = case[-1]
    u, v, t = np.zeros(m), np.zeros(m), 0.0
    seen = np.empty((n, len(observed)))
    impulse, closing = np.zeros(n_points), np.zeros(n_points)
    for k in range(n):
        t += step
        free = v + free_u @ u + free_v @ v
        normal_gap = rows[0] @ (u + step * v)
        near = []
        for i in range(n_points):
            height, rate = bumps(angle[i], case, t)
            if clearance[i] - height - normal_gap[i] <= 0:
                near.append(i)
                closing[i] = rows[0, i] @ free + rate
            else:
                impulse[i] = 0.0
        if len(near) > 0:
            c = len(near)
            response, W = np.empty((c, m)), np.empty((c, c))
            for a, i in enumerate(near):
                along, across = slide[i] + rows[1, i] @ v, rows[2, i] @ v
                speed = np.hypot(along, across)
                response[a] = inverse_rows[0, i] + friction / speed * (
                    along * inverse_rows[1, i] + across * inverse_rows[2, i]
                )
            for a, i in enumerate(near):
                for b in range(c):
                    W[a, b] = rows[0, i] @ response[b]
            _complementarity(W, closing, impulse, near)
            for a, i in enumerate(near):
                free -= response[a] * impulse[i]
        u = u + step / 2 * (v + free)
        v = free
        seen[k] = observed @ u
    return seen


@njit
def _complementarity(W, closing, impulse, near):
    """P >= 0, W P - closing >= 0, no impulse where it opens (impulse [N s], modified)."""
    for _ in range(MOST_SWEEPS):
        largest, size = 0.0, 0.0
        for a, i in enumerate(near):
            left = -closing[i]
            for b, j in enumerate(near):
                left += W[a, b] * impulse[j]
            new = max(0.0, impulse[i] - left / W[a, a])
            largest = max(largest, abs(new - impulse[i]))
            size = max(size, new)
            impulse[i] = new
        if largest <= TOLERANCE * size:
            return
    raise RuntimeError("Gauss-Seidel did not converge")
