"""Contact of blades that move in three dimensions: what the kernel calls.

`friction` turns the friction with the slip velocity, and `blades` finds the multipliers. Disks
without axial motion use none of this: in the kernel it is left out when it is compiled.
"""

import numpy as np
from numba.core.extending import overload

from hpcrub.contact.arrays import Contact, Scheme, Spatial, State
from hpcrub.contact.blades import solve_blades
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import (
    TILE,
    TIPS,
    any_lane,
    below,
    indices,
    larger,
    load,
    per_lane,
    select,
    splat,
    store,
    tile_add,
    tile_dot,
    tile_gather,
    tile_largest,
    tile_splat,
    tile_store,
)
from hpcrub.contact.multipliers import FEW_CONTACTS, MANY_CONTACTS, SOME_CONTACTS

BLOCK = 32  # modes whose motion, coefficients and projections the first-level cache holds


def predict_all(
    lanes: tuple,
    scheme: Scheme,
    state: State,
    spatial: Spatial | tuple[()],
    step: int,
    n_active: int,
) -> np.ndarray:
    """Corrector of the step before, predictor and penetrations of this one (state is modified).

    Block by block of modes, so that all points see a mode while it is in the cache.

    Parameters
    ----------
    lanes, scheme, state, spatial
        As in `kernel.integrate`.
    step : int
        Row of the bump table.
    n_active : int
        Entries of `State.active` that count.

    Returns
    -------
    ndarray (L,)
        Deepest penetration of all contact points [m].
    """
    if len(spatial) == 0:
        return splat(lanes, 0.0)
    return _predict_all(lanes, scheme, state, spatial, step, n_active)


@overload(predict_all)
def _predict(lanes, scheme, state, spatial, step, n_active):
    if len(spatial) == 0:
        return lambda lanes, scheme, state, spatial, step, n_active: splat(lanes, 0.0)
    return lambda lanes, scheme, state, spatial, step, n_active: _predict_all(
        lanes, scheme, state, spatial, step, n_active
    )


@compiled(allocates=False)
def _predict_all(lanes, scheme, state, spatial, step, n_active):
    n_modes, n_points = scheme.normal.shape
    ramp, deepest = load(lanes, state.ramp, 0), splat(lanes, -np.inf)
    for first in range(0, n_points, TILE):
        depth = tile_splat(TIPS, splat(lanes, 0.0))
        depth = tile_add(depth, scheme.clearance, 0, first, splat(lanes, -1.0))
        tile_store(state.penetration, first, tile_add(depth, scheme.bump, step, first, ramp))
    for begin in range(0, n_modes, BLOCK):
        end = min(begin + BLOCK, n_modes)
        for first in range(0, n_active, TILE):
            if n_active - first <= len(FEW_CONTACTS):
                add_forces(lanes, FEW_CONTACTS, scheme, state, spatial, first, begin, end)
            elif n_active - first <= len(SOME_CONTACTS):
                add_forces(lanes, SOME_CONTACTS, scheme, state, spatial, first, begin, end)
            else:
                add_forces(lanes, MANY_CONTACTS, scheme, state, spatial, first, begin, end)
        advance_modes(lanes, scheme, state, spatial, step, n_active, begin, end)
        for first in range(0, n_points, TILE):
            depth = tile_gather(lanes, state.penetration, rows_from(first))
            for k in range(begin, end):
                depth = tile_add(depth, scheme.normal, k, first, load(lanes, state.position, k))
            tile_store(state.penetration, first, depth)
            if end == n_modes:
                deepest = larger(tile_largest(depth), deepest)
    return deepest


@compiled(inline=True, allocates=False)
def rows_from(first: int) -> tuple:
    """Numbers of TILE consecutive rows."""
    return (
        first, first + 1, first + 2, first + 3, first + 4, first + 5,
        first + 6, first + 7, first + 8, first + 9, first + 10, first + 11,
    )  # fmt: skip


@compiled(allocates=False)
def add_forces(
    lanes: tuple,
    slots: tuple,
    scheme: Scheme,
    state: State,
    spatial: Spatial,
    first: int,
    begin: int,
    end: int,
) -> None:
    """Modal forces of some active points (spatial.before, modified).

    Parameters
    ----------
    lanes, scheme, state, spatial
        As in `kernel.integrate`.
    slots : tuple
        As many zeros as there are points.
    first : int
        Place of the first of them in `State.active`; 0 to begin the sum.
    begin, end : int
        First mode, and the one after the last.
    """
    columns = indices(slots, state.active, first)
    forces = tile_gather(lanes, state.multiplier, columns)
    for k in range(begin, end):
        total = splat(lanes, 0.0)
        if first > 0:
            total = load(lanes, spatial.before, k)
        store(spatial.before, k, tile_dot(scheme.load, k, columns, forces, total))


@compiled(allocates=False)
def advance_modes(
    lanes: tuple,
    scheme: Scheme,
    state: State,
    spatial: Spatial,
    step: int,
    n_active: int,
    begin: int,
    end: int,
) -> None:
    """Corrector and predictor of some modes (state, spatial.before are modified).

    Parameters
    ----------
    lanes, scheme, state, spatial
        As in `kernel.integrate`; ``before`` holds the modal forces on entry, if there are any, and
        the increments of the step before on return.
    step : int
        Row of the bump table.
    n_active : int
        Zero where there are no forces.
    begin, end : int
        First mode, and the one after the last.
    """
    loaded = scheme.external.shape[0] > 0
    for k in range(begin, end):
        gain = load(lanes, scheme.gain, k)
        q, d = load(lanes, state.position, k), load(lanes, state.increment, k)
        if n_active > 0:
            kick = load(lanes, spatial.before, k) * gain
            q, d = q + kick, d + kick
        store(spatial.before, k, d)
        d = load(lanes, scheme.decay, k) * d - (gain * per_lane(lanes, scheme.squared, k)) * q
        if loaded:
            d = d + splat(lanes, scheme.external[step, k]) * gain
        store(state.increment, k, d)
        store(state.position, k, q + d)


def find_forces(
    lanes: tuple,
    scheme: Scheme,
    contact: Contact,
    state: State,
    spatial: Spatial | tuple[()],
    deepest: np.ndarray,
) -> int:
    """Contact forces of a step (contact, state and spatial are modified).

    Parameters
    ----------
    lanes, scheme, contact, state, spatial
        As in `kernel.integrate`.
    deepest : ndarray (L,)
        Deepest penetration of the step [m].

    Returns
    -------
    int
        Rows of ``state.multiplier`` that count.
    """
    if len(spatial) == 0:
        return 0
    return _find_forces(lanes, scheme, contact, state, spatial, deepest)


@overload(find_forces)
def _find(lanes, scheme, contact, state, spatial, deepest):
    if len(spatial) == 0:
        return lambda lanes, scheme, contact, state, spatial, deepest: 0
    return lambda lanes, scheme, contact, state, spatial, deepest: _find_forces(
        lanes, scheme, contact, state, spatial, deepest
    )


@compiled(allocates=False)
def _find_forces(lanes, scheme, contact, state, spatial, deepest):
    n_active = solve_blades(lanes, scheme, contact, state, spatial, deepest)
    count_contacts(lanes, state, spatial, n_active)
    return turned_forces(lanes, contact, state, spatial, n_active)


@compiled(allocates=False)
def count_contacts(lanes: tuple, state: State, spatial: Spatial, n_active: int) -> None:
    """Count this step for the blades that carry a force (spatial.steps_touched, modified).

    Parameters
    ----------
    lanes, state, spatial
        As in `kernel.integrate`.
    n_active : int
        Entries of `State.active` that count, blade by blade.
    """
    zero, one = splat(lanes, 0.0), splat(lanes, 1.0)
    force = zero
    for a in range(n_active):
        force = larger(force, load(lanes, state.multiplier, state.active[a]))
        blade = spatial.blade[state.active[a]]
        if a + 1 == n_active or spatial.blade[state.active[a + 1]] != blade:
            touched = select(below(zero, force), one, zero)
            touched = touched + load(lanes, spatial.steps_touched, blade)
            store(spatial.steps_touched, blade, touched)
            force = zero


@compiled(allocates=False)
def turned_forces(
    lanes: tuple, contact: Contact, state: State, spatial: Spatial, n_active: int
) -> int:
    """Normal, circumferential and axial forces of the multipliers (state, spatial are modified).

    Parameters
    ----------
    lanes, state, spatial
        As in `kernel.integrate`.
    n_active : int
        Entries of `State.active` that count.

    Returns
    -------
    int
        Rows of ``state.multiplier`` that count, without those of no force in any lane.
    """
    n_points = state.penetration.shape[0] - 1
    zero, mu, n = splat(lanes, 0.0), splat(lanes, spatial.friction), 0
    for a in range(n_active):
        i = state.active[a]
        force = load(lanes, state.multiplier, i)
        touches = load(lanes, spatial.touching, i)
        held = select(below(zero, load(lanes, state.penetration, i)), splat(lanes, -1.0), zero)
        store(spatial.touching, i, select(below(zero, touches), touches, held))
        if any_lane(below(zero, force)):
            force = force * load(lanes, contact.stiffness, i)
            store(state.multiplier, i, force)
            friction = mu * force
            store(state.multiplier, n_points + i, friction * load(lanes, spatial.cosine, i))
            store(state.multiplier, 2 * n_points + i, friction * load(lanes, spatial.sine, i))
            state.active[n] = i
            n += 1
    for a in range(n):
        state.active[n + a] = n_points + state.active[a]
        state.active[2 * n + a] = 2 * n_points + state.active[a]
    for a in range(3 * n, 3 * n + TILE):
        state.active[a] = 3 * n_points
    return 3 * n
