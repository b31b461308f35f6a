"""Contact of blades that move in three dimensions: friction that turns with the slip velocity.

Friction opposes the slip velocity of a contact point, which has a part along the casing's
circumference, RΩ + u̇_t, and an axial part u̇_a. Its direction (cos β, sin β) is that of the step
before, so the multipliers of a step still solve a linear problem, whose operator changes with β:

    W = N·gain·[N + μ (T cos β + A sin β)]ᵀ.

`blades` finds the multipliers. Disks without axial motion use none of this: in the kernel it is
left out when it is compiled.
"""

import numpy as np
from numba.core.extending import overload

from hpcrub.contact.arrays import Contact, Scheme, Spatial, State
from hpcrub.contact.blades import nearness, solve_blades
from hpcrub.contact.complementarity import FLAW
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import (
    TILE,
    any_lane,
    below,
    fma,
    indices,
    inverse,
    larger,
    length,
    load,
    select,
    splat,
    store,
    tile_add_at,
    tile_scatter,
    tile_splat,
)
from hpcrub.contact.multipliers import MANY_CONTACTS
from hpcrub.contact.status import JAMMING


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
    n_blades, n_active = active_blades(lanes, contact, state, spatial, deepest)
    turn_friction(lanes, scheme, state, spatial, n_active)
    turned_delassus(lanes, contact, state, spatial, deepest, n_active)
    solve_blades(lanes, contact, state, spatial, deepest, n_blades)
    count_contacts(lanes, state, spatial, n_blades)
    return turned_forces(lanes, contact, state, spatial, n_active)


@compiled
def active_blades(
    lanes: tuple, contact: Contact, state: State, spatial: Spatial, deepest: np.ndarray
) -> tuple[int, int]:
    """List the points of all blades that may carry a force in any lane (state.active, modified).

    Parameters
    ----------
    lanes, contact, state, spatial
        As in `kernel.integrate`.
    deepest : ndarray (L,)
        Deepest penetration of the step [m].

    Returns
    -------
    n_blades : int
        Active blades.
    n_active : int
        Their points. The list goes on with points that are in it, so that tiles have something
        to read.
    """
    threshold = nearness(lanes, contact, deepest)
    n_blades = n_active = 0
    for blade in range(len(spatial.starts) - 1):
        first, end = spatial.starts[blade], spatial.starts[blade + 1]
        near = False
        for point in spatial.points[first:end]:
            near = near or any_lane(below(threshold, load(lanes, state.penetration, point)))
        if near:
            spatial.blades[n_blades] = n_active
            n_blades += 1
            for point in spatial.points[first:end]:
                state.active[n_active] = point
                n_active += 1
    spatial.blades[n_blades] = n_active
    for a in range(n_active, n_active + TILE):
        state.active[a] = state.active[0]
    return n_blades, n_active


@compiled
def turn_friction(
    lanes: tuple, scheme: Scheme, state: State, spatial: Spatial, n_active: int
) -> None:
    """Directions of slip of the active points in the step before (spatial is modified).

    Parameters
    ----------
    lanes, scheme, state, spatial
        As in `kernel.integrate`.
    n_active : int
        Entries of `State.active` that count.
    """
    for first in range(0, n_active, TILE):
        points = indices(MANY_CONTACTS, state.active, first)
        way = tile_splat(MANY_CONTACTS, splat(lanes, 0.0))
        for k in range(spatial.before.shape[0]):
            d = load(lanes, spatial.before, k)
            way = tile_add_at(way, scheme.tangential, k, points, d)
        tile_scatter(spatial.cosine, points, way)
        way = tile_splat(MANY_CONTACTS, splat(lanes, 0.0))
        for k in range(spatial.before.shape[0]):
            way = tile_add_at(way, spatial.axial, k, points, load(lanes, spatial.before, k))
        tile_scatter(spatial.sine, points, way)
    for a in range(n_active):
        i = state.active[a]
        along = splat(lanes, spatial.way[i]) + load(lanes, spatial.cosine, i)
        across = load(lanes, spatial.sine, i)
        unit = inverse(length(along, across))
        store(spatial.cosine, i, along * unit)
        store(spatial.sine, i, across * unit)


@compiled
def turned_delassus(
    lanes: tuple,
    contact: Contact,
    state: State,
    spatial: Spatial,
    deepest: np.ndarray,
    n_active: int,
) -> None:
    """Delassus operator of the active points for their friction (contact, state modified).

    Parameters
    ----------
    lanes, contact, state, spatial
        As in `kernel.integrate`.
    deepest : ndarray (L,)
        Deepest penetration of the step [m].
    n_active : int
        Entries of `State.active` that count.
    """
    n_rows = state.penetration.shape[0]
    n_points = n_rows - 1
    n_pairs = n_points * n_points
    zero, tiny, mu = splat(lanes, 0.0), splat(lanes, 1e-300), splat(lanes, spatial.friction)
    threshold = nearness(lanes, contact, deepest)
    for b in range(n_active):
        j = state.active[b]
        along = mu * load(lanes, spatial.cosine, j)
        across = mu * load(lanes, spatial.sine, j)
        at = j * n_points + j
        own = load(lanes, spatial.compliance, at)
        own = fma(along, load(lanes, spatial.compliance, n_pairs + at), own)
        own = fma(across, load(lanes, spatial.compliance, 2 * n_pairs + at), own)
        # where the point is near: a force there would pull its blade further in
        depth = select(below(zero, deepest), load(lanes, state.penetration, j), threshold)
        jamming = below(select(below(threshold, depth), own, splat(lanes, 1.0)), tiny)
        code = select(jamming, splat(lanes, float(JAMMING)), load(lanes, state.report, FLAW))
        store(state.report, FLAW, code)
        scale = inverse(own)
        store(contact.stiffness, j, scale)
        for a in range(n_active):
            i = state.active[a]
            at = i * n_points + j
            w = load(lanes, spatial.compliance, at)
            w = fma(along, load(lanes, spatial.compliance, n_pairs + at), w)
            w = fma(across, load(lanes, spatial.compliance, 2 * n_pairs + at), w)
            store(contact.coupling, i * n_rows + j, w * scale)


@compiled
def count_contacts(lanes: tuple, state: State, spatial: Spatial, n_blades: int) -> None:
    """Count this step for the blades that carry a force (spatial.steps_touched, modified).

    Parameters
    ----------
    lanes, state, spatial
        As in `kernel.integrate`.
    n_blades : int
        Active blades.
    """
    zero, one = splat(lanes, 0.0), splat(lanes, 1.0)
    for b in range(n_blades):
        force = zero
        for a in range(spatial.blades[b], spatial.blades[b + 1]):
            force = larger(force, load(lanes, state.multiplier, state.active[a]))
        blade = spatial.blade[state.active[spatial.blades[b]]]
        touched = load(lanes, spatial.steps_touched, blade) + select(below(zero, force), one, zero)
        store(spatial.steps_touched, blade, touched)


@compiled
def turned_forces(
    lanes: tuple, contact: Contact, state: State, spatial: Spatial, n_active: int
) -> int:
    """Normal, circumferential and axial forces of the multipliers (state is modified).

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
    mu, n = splat(lanes, spatial.friction), 0
    for a in range(n_active):
        i = state.active[a]
        force = load(lanes, state.multiplier, i)
        if any_lane(below(splat(lanes, 0.0), force)):
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
