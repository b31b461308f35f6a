"""Contact of blades that move in three dimensions: what the kernel calls.

`friction` turns the friction with the slip velocity, and `blades` finds the multipliers. Disks
without axial motion use none of this: in the kernel it is left out when it is compiled.
"""

import numpy as np
from numba.core.extending import overload

from hpcrub.contact.arrays import Contact, Scheme, Spatial, State
from hpcrub.contact.blades import solve_blades
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import TILE, any_lane, below, larger, load, select, splat, store


def remember(spatial: Spatial | tuple[()], k: int, increment: np.ndarray) -> None:
    """Keep the increment of a mode at the end of a step (spatial is modified).

    Parameters
    ----------
    spatial : Spatial or ()
        Empty for disks without axial motion: nothing to keep.
    k : int
        Mode.
    increment : ndarray (L,)
        d [m·√kg].
    """
    if len(spatial) > 0:
        store(spatial.before, k, increment)


@overload(remember)
def _remember(spatial, k, increment):
    if len(spatial) == 0:
        return lambda spatial, k, increment: None
    return lambda spatial, k, increment: store(spatial.before, k, increment)


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


@compiled
def _find_forces(lanes, scheme, contact, state, spatial, deepest):
    n_active = solve_blades(lanes, scheme, contact, state, spatial, deepest)
    count_contacts(lanes, state, spatial, n_active)
    return turned_forces(lanes, contact, state, spatial, n_active)


@compiled
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


@compiled
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
