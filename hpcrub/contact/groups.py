"""The multipliers of one group of blades, whose problem is solved exactly.

The set of points that carry a force is guessed, the linear equations of the set are solved, and
points of the wrong sign change sides: principal pivoting (Júdice and Pires 1994), in all lanes at
once.
"""

import numpy as np

from hpcrub.contact.arrays import Contact, Scheme, Spatial, State
from hpcrub.contact.friction import turn
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import (
    any_lane,
    below,
    fma,
    inverse,
    load,
    positive_part,
    select,
    splat,
    store,
)

MOST_TRIALS = 60  # guesses of the points of a group that carry a force; two or so are usual
ALL_AT_ONCE = 12  # of these, those after which all points of the wrong sign change sides


@compiled(allocates=False)
def choose(
    lanes: tuple,
    scheme: Scheme,
    contact: Contact,
    state: State,
    spatial: Spatial,
    n_groups: int,
    group: int,
    solving: np.ndarray,
) -> int:
    """Points of a group that touch in the guess of any lane (contact, spatial are modified).

    Parameters
    ----------
    lanes, scheme, contact, state, spatial
        As in `kernel.integrate`.
    n_groups : int
        Groups with listed points.
    group : int
        One of them.
    solving : ndarray (L,) bool
        Lanes that count.

    Returns
    -------
    int
        Points whose places ``spatial.chosen`` holds, in order.
    """
    zero, n, n_fresh = splat(lanes, 0.0), 0, 0
    for a in range(spatial.groups[group], spatial.groups[group + 1]):
        touches = select(solving, load(lanes, spatial.touching, state.active[a]), zero)
        if any_lane(below(zero, touches)):
            spatial.chosen[n] = a
            n += 1
            if not spatial.turned[a]:
                spatial.fresh[n_fresh] = a
                n_fresh += 1
    if n_fresh > 0:
        turn(lanes, scheme, contact, state, spatial, n_fresh, spatial.groups[n_groups])
    return n


@compiled(allocates=False)
def solve_set(lanes: tuple, contact: Contact, state: State, spatial: Spatial, n: int) -> None:
    """Forces of the chosen points that leave no gap at those that touch (spatial.right, modified).

    Parameters
    ----------
    lanes, contact, state, spatial
        As in `kernel.integrate`.
    n : int
        Chosen points, the first of ``spatial.chosen``.

    Notes
    -----
    Gaussian elimination; in a lane whose guess lacks a chosen point, its row is that of the unit
    matrix, and its force 0.
    """
    n_rows, zero, one = state.penetration.shape[0], splat(lanes, 0.0), splat(lanes, 1.0)
    for r in range(n):
        a = spatial.chosen[r]
        touches = positive_part(load(lanes, spatial.touching, state.active[a]))
        store(spatial.right, r, touches * load(lanes, state.depth, a))
        for c in range(n):
            b = spatial.chosen[c]
            both = touches * positive_part(load(lanes, spatial.touching, state.active[b]))
            value = both * load(lanes, contact.coupling, b * n_rows + a)
            if r == c:
                value = value + (one - touches)
            store(spatial.factor, r * n + c, value)
    for p in range(n):
        scale = inverse(load(lanes, spatial.factor, p * n + p))
        store(spatial.factor, p * n + p, scale)
        known = load(lanes, spatial.right, p)
        for r in range(p + 1, n):
            less = zero - load(lanes, spatial.factor, r * n + p) * scale
            store(spatial.right, r, fma(less, known, load(lanes, spatial.right, r)))
            for c in range(p + 1, n):
                at = r * n + c
                pivot = load(lanes, spatial.factor, p * n + c)
                store(spatial.factor, at, fma(less, pivot, load(lanes, spatial.factor, at)))
    for back in range(n):
        p = n - 1 - back
        less = zero
        for c in range(p + 1, n):
            factor = load(lanes, spatial.factor, p * n + c)
            less = fma(factor, load(lanes, spatial.right, c), less)
        x = load(lanes, spatial.right, p) - less
        store(spatial.right, p, x * load(lanes, spatial.factor, p * n + p))


@compiled(allocates=False)
def find_wrong(
    lanes: tuple,
    contact: Contact,
    state: State,
    spatial: Spatial,
    start: int,
    end: int,
    n: int,
    threshold: np.ndarray,
    limit: np.ndarray,
    trying: np.ndarray,
) -> np.ndarray:
    """Mark the points whose force pulls, or that penetrate without one (spatial.wrong, modified).

    Parameters
    ----------
    lanes, contact, state, spatial
        As in `kernel.integrate`.
    start, end : int
        Places in `State.active` of the first point of the group and after the last.
    n : int
        Chosen points, the first of ``spatial.chosen``.
    threshold : ndarray (L,)
        Penetration from which on a blade counts in a lane [m].
    limit : ndarray (L,)
        Tolerance of a multiplier or penetration [m].
    trying : ndarray (L,) bool
        Lanes whose set is not found yet; the others have no wrong points.

    Returns
    -------
    ndarray (L,)
        How many there are in each lane.
    """
    n_rows = state.penetration.shape[0]
    zero, one = splat(lanes, 0.0), splat(lanes, 1.0)
    count, own = zero, 0
    for a in range(start, end):
        i = state.active[a]
        less, force = zero, zero
        for r in range(n):
            effect = load(lanes, contact.coupling, spatial.chosen[r] * n_rows + a)
            less = fma(effect, load(lanes, spatial.right, r), less)
        depth = load(lanes, state.depth, a) - less
        if own < n and spatial.chosen[own] == a:
            force = load(lanes, spatial.right, own)
            own += 1
        near = below(threshold, load(lanes, spatial.deepest, spatial.blade[i]))
        pulls = select(below(force, zero), one, zero)
        penetrates = select(below(limit, depth), select(near, one, zero), zero)
        touches = below(zero, load(lanes, spatial.touching, i))
        wrong = select(trying, select(touches, pulls, penetrates), zero)
        store(spatial.wrong, a - start, wrong)
        count = count + wrong
    return count


@compiled(allocates=False)
def change_sides(
    lanes: tuple, state: State, spatial: Spatial, start: int, end: int, all_at_once: bool
) -> None:
    """Let points of the wrong sign change sides (spatial.touching, modified).

    Parameters
    ----------
    lanes, state, spatial
        As in `kernel.integrate`.
    start, end : int
        Places in `State.active` of the first point of the group and after the last.
    all_at_once : bool
        Whether all change sides, or only the last.
    """
    one, free = splat(lanes, 1.0), splat(lanes, 1.0)
    for back in range(end - start):
        a = end - 1 - back
        i = state.active[a]
        wrong = load(lanes, spatial.wrong, a - start)
        if not all_at_once:
            wrong, free = wrong * free, free * (one - wrong)
        touches = load(lanes, spatial.touching, i)
        store(spatial.touching, i, touches + wrong * (one - touches - touches))


@compiled(allocates=False)
def solve_group(
    lanes: tuple,
    scheme: Scheme,
    contact: Contact,
    state: State,
    spatial: Spatial,
    n_groups: int,
    group: int,
    threshold: np.ndarray,
    limit: np.ndarray,
    solving: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Multipliers of one group (contact, state.multiplier, spatial are modified).

    Parameters
    ----------
    lanes, scheme, contact, spatial
        As in `kernel.integrate`.
    state : State
        On entry ``depth`` holds what the other groups leave of the penetrations [m].
    n_groups : int
        Groups with listed points.
    group : int
        One of them.
    threshold : ndarray (L,)
        Penetration from which on a blade counts in a lane [m].
    limit : ndarray (L,)
        Tolerance of a multiplier or penetration [m].
    solving : ndarray (L,) bool
        Lanes to solve; the others keep their multipliers.

    Returns
    -------
    tried : ndarray (L,)
        Sets that were tried.
    unfinished : ndarray (L,)
        1 for lanes in which none was right, else 0.

    Notes
    -----
    On return ``spatial.wrong`` holds the multipliers from before.
    """
    zero, one = splat(lanes, 0.0), splat(lanes, 1.0)
    start, end = spatial.groups[group], spatial.groups[group + 1]
    n, trying, tried = 0, solving, zero
    for trial in range(MOST_TRIALS):
        n = choose(lanes, scheme, contact, state, spatial, n_groups, group, solving)
        solve_set(lanes, contact, state, spatial, n)
        count = find_wrong(lanes, contact, state, spatial, start, end, n, threshold, limit, trying)
        tried = tried + select(trying, one, zero)
        trying = below(zero, count)
        if not any_lane(trying):
            break
        change_sides(lanes, state, spatial, start, end, trial < ALL_AT_ONCE)
    own = 0
    for a in range(start, end):
        i = state.active[a]
        old, force = load(lanes, state.multiplier, i), zero
        if own < n and spatial.chosen[own] == a:
            force = positive_part(load(lanes, spatial.right, own))
            own += 1
        store(spatial.wrong, a - start, old)
        store(state.multiplier, i, select(solving, force, old))
    return tried, select(trying, one, zero)
