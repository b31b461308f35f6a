"""A second program for rubbing: Moreau–Jean time stepping on matrices, without modal coordinates.

Same matrices, casing law and physics as the studies, everything else different:

- the modal damping is a full matrix C = M Φ diag(2ξω) Φᵀ M;
- the θ-method in displacement and velocity,
  (M + hθC + h²θ²K)(v_{k+1} − v_k) = −h C v_k − h K (u_k + hθ v_k) + Jᵀp,
  u_{k+1} = u_k + h [θ v_{k+1} + (1 − θ) v_k];
- contact on the level of velocities and impulses, with w the place of the casing and e = 0:
  0 ≤ max(g_k, 0) + (w_{k+1} − w_k) − h u̇_{r,k+1} ⊥ p ≥ 0, and then a projection of the positions on
  g_{k+1} ≥ 0 that leaves the velocities (Acary 2013). With g_k in place of max(g_k, 0) the velocity
  would take back what a tip has sunk in, which is restitution of up to 1/2 after each impact.
  The kernel corrects positions by forces that act one step earlier;
- friction −μp along the slip of the step before, which always slides: along +t on a planar disk;
  projected Gauss–Seidel on the impulses of all contact points.

The clock is the time, not the angle, so all speeds share every step. θ = 1/2 would leave modes far
above 1/h undamped, which every impact excites: θ = 0.51 takes 4 % of them a step and adds
(θ − 1/2)ωh, 4·10⁻⁵ at 138 Hz and h = 5 µs, to the damping ratio.
"""

from typing import NamedTuple

import numba
import numpy as np
from scipy.linalg import cho_factor, cho_solve, eigh

from evidence.truth.ring import bump, forces
from hpcrub.model.interface import Interface, planar_interface

THETA = 0.51


class Model(NamedTuple):
    """What the scheme needs of a structure; a ReducedModel has the same members."""

    mass: np.ndarray  # (n, n)
    stiffness: np.ndarray  # (n, n)
    interface: Interface


def unreduced(disk):
    """The Model of a planar Disk with all its dof."""
    rows = np.eye(len(disk.mass))[disk.contact_dof.T]
    face = planar_interface(disk.contact_angle, disk.contact_radius, *rows)
    return Model(disk.mass, disk.stiffness, face)


class _Operators(NamedTuple):
    move: np.ndarray  # (n, 2n) velocity change of a step without contact from (u, v)
    rows: np.ndarray  # (3 n_c, n) displacements of the points: normal, tangential, axial
    answer: np.ndarray  # (n, 3 n_c) velocity change per unit impulse against each of these
    delassus: np.ndarray  # (3, n_c, n_c) normal approach that it takes
    observed: np.ndarray  # (n_o, n)


def _operators(model, damping_ratio, h, theta):
    M, K, face = model.mass, model.stiffness, model.interface
    eigenvalues, Phi = eigh(K, M)
    MPhi = M @ Phi
    C = MPhi @ (2.0 * damping_ratio * np.sqrt(eigenvalues)[:, None] * MPhi.T)
    A = cho_factor(M + h * theta * C + (h * theta) ** 2 * K)
    move = -h * cho_solve(A, np.hstack([K, C + h * theta * K]))
    axial = face.axial if len(face.axial) else np.zeros_like(face.normal)
    rows = np.concatenate([face.normal, face.tangential, axial])
    answer = -cho_solve(A, rows.T)
    delassus = -np.stack(np.hsplit(face.normal @ answer, 3))
    return _Operators(*map(np.ascontiguousarray, (move, rows, answer, delassus, face.observed)))


@numba.njit
def _pushed(operators, approach, slip, friction):
    """Velocity change (n,) by impulses that end the approach (n_c,); slip: of the step before."""
    along, across = slip[: len(approach)], slip[len(approach) :]
    speed = np.hypot(along, across) / friction
    W = operators.delassus[0] + operators.delassus[1] * (along / speed)
    p = forces(W + operators.delassus[2] * (across / speed), approach)
    return np.dot(operators.answer, np.concatenate((p, along / speed * p, across / speed * p)))


@numba.njit
def _integrate(operators, casing, face, speeds_hz, h, theta, n_steps, y, start, peaks):
    """Integrate from y = (u, v) (2n, S) at the times start (S,) (y, peaks are modified)."""
    angle, turning, clearance = face  # turning: slip by rotation (2 n_c, S)
    n, n_c, omega = len(y) // 2, len(angle), 2.0 * np.pi * speeds_hz
    normal, along = operators.rows[:n_c], operators.rows[n_c:]
    before, place = np.empty((2, n_c, len(omega)))
    u, v = y[:n], y[n:]
    for k in range(-1, n_steps):
        t = start + (k + 1) * h
        before, place = place, before
        for s in range(len(omega)):
            np.subtract(clearance, bump(casing, angle + omega[s] * t[s], t[s]), place[:, s])
        if k >= 0:
            slip, change = np.dot(along, v) + turning, np.dot(operators.move, y)
            open_by = np.maximum(before - np.dot(normal, u), 0.0)
            approach = np.dot(normal, v + change) - (open_by + place - before) / h
            for s in range(len(omega)):
                if approach[:, s].max() > 0.0:
                    kick = change[:, s]
                    kick += _pushed(operators, approach[:, s], slip[:, s], casing.friction)
            u += h * (v + theta * change)
            v += change
            depth = np.dot(normal, u) - place
            for s in range(len(omega)):
                at = u[:, s]
                if depth[:, s].max() > 0.0:
                    at += _pushed(operators, depth[:, s], slip[:, s], casing.friction)
                left = (n_steps - k - 1) * h * speeds_hz[s]  # revolutions
                if left < 6.0:
                    seen = np.abs(np.dot(operators.observed, np.ascontiguousarray(at)))
                    peaks[int(left < 3.0), s] = max(peaks[int(left < 3.0), s], seen.max())


def amplitudes(model, damping_ratio, casing, speeds_hz, h, duration, theta=THETA, start=None):
    """Largest observed displacement over three revolutions.

    model: Model or ReducedModel, mistuned or not; casing: `ring.Wall`; speeds_hz (S,);
    h, duration [s]; start: u, v (n, S) and the time (S,) that they belong to, rest by default.
    Returns amplitudes (2, S) [m] over the three revolutions before the last three and over the
    last three.
    """
    speeds_hz, face = np.asarray(speeds_hz, dtype=float), model.interface
    n, n_speeds = len(model.mass), len(speeds_hz)
    u, v, since = start or (*np.zeros((2, n, n_speeds)), np.zeros(n_speeds))
    y, peaks = np.ascontiguousarray(np.concatenate([u, v])), np.zeros((2, n_speeds))
    operators = _operators(model, damping_ratio, h, theta)
    turning = np.outer(np.append(face.radius, np.zeros_like(face.radius)), 2 * np.pi * speeds_hz)
    points = face.angle, turning, casing.clearance + face.clearance
    _integrate(operators, casing, points, speeds_hz, h, theta, round(duration / h), y, since, peaks)
    return peaks
