"""Time-integration schemes: what a kernel lane needs to march one speed of one sample."""

import numpy as np

from hpcrub.kernel import TILE, Scheme, State
from hpcrub.lanes import aligned_zeros


def coefficients(scheme, omega, damping_ratio, h):
    """Modal coefficients of a time step.

    Args:
        scheme: ``central_difference`` or ``exact_modal``.
        omega: angular eigenfrequencies (K,) [rad/s].
        damping_ratio: modal damping ratio ξ [-].
        h: time step [s].

    Returns:
        keep, pull [-] and push [s²], each (K,), in d ← keep·d − pull·q + push·(force).

    Source: Joachim, Nyssen, Batailly (2020), section 2.2.2; ``docs/theory.md`` for exact_modal.
    """
    c = damping_ratio * omega * h
    if scheme == "central_difference":
        push = h * h / (1.0 + c)
        return (1.0 - c) / (1.0 + c), omega**2 * push, push
    theta = omega * h * np.emath.sqrt(1.0 - damping_ratio**2)
    keep = np.exp(-2.0 * c)
    # 1 − 2e^{−c}cos θ + e^{−2c} without the cancellation at small steps
    pull = np.real(np.expm1(-c) ** 2 + 4.0 * np.exp(-c) * np.sin(theta / 2.0) ** 2)
    rigid = omega * h < 1e-8
    push = np.where(rigid, h * h, pull / np.where(rigid, 1.0, omega) ** 2)
    return keep, pull, push


def delassus(radial, load, push):
    """W_ij: how far unit force at contact point j moves point i outwards in one step, negated.

    Args:
        radial: R (K, C) [1/√kg].
        load: G = −(R + μT)ᵀ (K, C).
        push: (K,) [s²].

    Returns:
        W (C, C) [m/N], without symmetry where there is friction.
    """
    return -(radial * push[:, None]).T @ load


def allocate(modes, scene, bump, width):
    """Idle lanes for one sample.

    Args:
        modes: Modes of the sample.
        scene: sweep.Scene.
        bump: bump heights (P, n_c) [m].
        width: number of lanes.

    Returns:
        kernel.Scheme and kernel.State.
    """
    n_modes, n_points = len(modes.omega), -(-len(modes.radial) // TILE) * TILE
    padding = ((0, 0), (0, n_points - len(modes.radial)))
    radial = np.pad(modes.radial.T, padding)
    tangential = np.pad(modes.tangential.T, padding)
    load = -(radial + scene.friction * tangential)
    scheme = Scheme(
        radial=_aligned(radial),
        tangential=_aligned(tangential),
        load=_aligned(np.pad(load, ((0, 0), (0, 1)))),
        keep=aligned_zeros((n_modes, width)),
        pull=aligned_zeros((n_modes, width)),
        push=aligned_zeros((n_modes, width)),
        coupling=aligned_zeros((n_points**2, width)),
        stiffness=aligned_zeros((n_points, width)),
        reach=aligned_zeros((1, width)),
        clearance=aligned_zeros((1, width)),
        step=np.zeros(width),
        bump=_aligned(np.pad(bump, padding)),
        growth_time=scene.growth_time,
    )
    state = State(
        position=aligned_zeros((n_modes, width)),
        increment=aligned_zeros((n_modes, width)),
        penetration=aligned_zeros((n_points, width)),
        multiplier=aligned_zeros((n_points + 1, width)),
        active=np.full(n_points + TILE, n_points),
        growth=aligned_zeros((1, width)),
        n_steps=np.zeros(width, dtype=np.int64),
        unsolved=aligned_zeros((1, width)),
    )
    return scheme, state


def empty_lane(scheme, state, lane):
    """Put a lane at rest, far from the casing (both are modified)."""
    for array in (scheme.keep, scheme.pull, scheme.push, scheme.reach):
        array[:, lane] = 0.0
    scheme.clearance[:, lane] = np.inf
    for array in (state.position, state.increment, state.multiplier, state.unsolved):
        array[:, lane] = 0.0
    state.n_steps[lane] = 0


def fill_lane(scheme, lane, modes, scene, h):
    """Give an empty lane the coefficients of one speed (scheme is modified).

    Args:
        scheme: kernel.Scheme.
        lane: index.
        modes: Modes of the sample.
        scene: sweep.Scene.
        h: time step [s].
    """
    n_points = scheme.stiffness.shape[0]
    n_real = len(modes.radial)
    keep, pull, push = coefficients(scene.scheme, modes.omega, scene.damping_ratio, h)
    scheme.keep[:, lane], scheme.pull[:, lane], scheme.push[:, lane] = keep, pull, push
    W = delassus(scheme.radial[:, :n_real], scheme.load[:, :n_real], push)
    diagonal = np.diag(W)
    coupling = W / diagonal
    np.fill_diagonal(coupling, 0.0)
    table = scheme.coupling[:, lane].reshape(n_points, n_points)
    table[:n_real, :n_real] = coupling
    scheme.coupling[:, lane] = table.ravel()
    scheme.stiffness[:n_real, lane] = 1.0 / diagonal
    rho = np.abs(coupling).sum(axis=1).max()
    scheme.reach[0, lane] = rho / (1.0 - rho) if rho < 1.0 else np.inf
    scheme.clearance[0, lane] = scene.clearance
    scheme.step[lane] = h


def _aligned(values):
    array = aligned_zeros(values.shape)
    array[...] = values
    return array
