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
- friction −μp along +t, as the tips of a planar disk always slide; projected Gauss–Seidel on the
  impulses of all contact points.

The clock is the time, not the angle, so all speeds share every step. θ = 1/2 would leave modes far
above 1/h undamped, which every impact excites: θ = 0.51 takes 4 % of them a step and adds
(θ − 1/2)ωh, 4·10⁻⁵ at 138 Hz and h = 5 µs, to the damping ratio.
"""

from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve, eigh

from evidence.truth.ring import bump, forces
from hpcrub.model.interface import planar_interface

THETA = 0.51


def unreduced(disk):
    """A planar Disk with all its dof as the model of the scheme; a ReducedModel is one, too."""
    rows = np.eye(len(disk.mass))[disk.contact_dof.T]
    face = planar_interface(disk.contact_angle, disk.contact_radius, *rows)
    return SimpleNamespace(mass=disk.mass, stiffness=disk.stiffness, interface=face)


class _Operators(NamedTuple):
    move: np.ndarray  # (n, 2n) velocity change of a step without contact from (u, v)
    normal: np.ndarray  # (C, n) displacements of the points
    answer: np.ndarray  # (n, C) velocity change per unit impulse against each, with friction
    delassus: np.ndarray  # (C, C) normal approach that it takes
    observed: np.ndarray  # (n_o, n)


def _operators(model, damping_ratio, friction, h):
    M, K, face = model.mass, model.stiffness, model.interface
    eigenvalues, Phi = eigh(K, M)
    MPhi = M @ Phi
    C = MPhi @ (2.0 * damping_ratio * np.sqrt(eigenvalues)[:, None] * MPhi.T)
    A = cho_factor(M + h * THETA * C + (h * THETA) ** 2 * K)
    move = -h * cho_solve(A, np.hstack([K, C + h * THETA * K]))
    answer = -cho_solve(A, (face.normal + friction * face.tangential).T)
    return _Operators(move, face.normal, answer, -face.normal @ answer, face.observed)


def _integrate(operators, casing, angle, speeds_hz, h, n_steps, y, peaks):
    """Integrate from y = (u, v) (2n, S) at the time 0 (y, peaks are modified)."""
    n, omega, normal = len(y) // 2, 2.0 * np.pi * speeds_hz, operators.normal
    before, place = np.empty((2, len(angle), len(omega)))
    u, v = y[:n], y[n:]
    for k in range(-1, n_steps):
        t = (k + 1) * h
        before, place = place, before
        for s in range(len(omega)):
            place[:, s] = casing.clearance - bump(casing, angle + omega[s] * t, t)
        if k >= 0:
            change = np.dot(operators.move, y)
            open_by = np.maximum(before - np.dot(normal, u), 0.0)
            approach = np.dot(normal, v + change) - (open_by + place - before) / h
            for s in range(len(omega)):
                if approach[:, s].max() > 0.0:
                    p = forces(operators.delassus, approach[:, s])
                    change[:, s] += np.dot(operators.answer, p)
            u += h * (v + THETA * change)
            v += change
            depth = np.dot(normal, u) - place
            for s in range(len(omega)):
                if depth[:, s].max() > 0.0:
                    u[:, s] += np.dot(operators.answer, forces(operators.delassus, depth[:, s]))
                left = (n_steps - k - 1) * h * speeds_hz[s]  # revolutions
                if left < 6.0:
                    seen = np.abs(np.dot(operators.observed, u[:, s]))
                    peaks[int(left < 3.0), s] = max(peaks[int(left < 3.0), s], seen.max())


def amplitudes(model, damping_ratio, casing, speeds_hz, h, duration):
    """Largest observed displacement over three revolutions, from rest.

    model: of `unreduced`, or a ReducedModel, mistuned or not; casing: `ring.Wall`; speeds_hz (S,);
    h, duration [s]. Returns amplitudes (2, S) [m] over the three revolutions before the last three
    and over the last three.
    """
    speeds_hz, face = np.asarray(speeds_hz, dtype=float), model.interface
    y, peaks = np.zeros((2 * len(model.mass), len(speeds_hz))), np.zeros((2, len(speeds_hz)))
    operators = _operators(model, damping_ratio, casing.friction, h)
    _integrate(operators, casing, face.angle, speeds_hz, h, round(duration / h), y, peaks)
    return peaks
