"""The multipliers of blades with several contact points: the problem of a group is solved exactly.

The contact points of one blade are coupled so stiffly that Gauss–Seidel from point to point takes
up to hundreds of sweeps at small steps. So blades form groups of at most `bank.GROUP` points,
whose problem `groups` solves exactly, from the points that carried a force in the step before.
Sweeps go from group to group where there are several. What does not converge goes to Lemke's
method.

Only blades that penetrate are looked at, or nearly do. The forces found bound what they can push
others in, and blades that this bound reaches join. A lane is never changed by what the other lanes
need.
"""

import numpy as np

from hpcrub.contact.arrays import Contact, Scheme, Spatial, State
from hpcrub.contact.complementarity import SWEEPS, UNSOLVED, solve_by_pivoting
from hpcrub.contact.friction import turn, turn_penetrating
from hpcrub.contact.groups import solve_group
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import (
    any_lane,
    below,
    fma,
    larger,
    load,
    positive_part,
    select,
    splat,
    store,
)
from hpcrub.contact.multipliers import TOLERANCE

MOST_SWEEPS = 100  # from group to group; three or so are usual
NEAR = 0.5  # distance at which blades are looked at from the begin, of the deepest penetration


@compiled(allocates=False)
def list_near(lanes: tuple, state: State, spatial: Spatial, threshold: np.ndarray) -> int:
    """List the points of blades that penetrate more than a threshold in any lane (state.active).

    Parameters
    ----------
    lanes, spatial
        As in `kernel.integrate`; ``groups`` and ``deepest`` are modified.
    state : State
        Modified.
    threshold : ndarray (L,)
        Negative for blades that are near [m].

    Returns
    -------
    int
        Groups with points in the list; ``spatial.groups`` says where each begins.
    """
    n_groups = n_active = 0
    spatial.groups[0] = 0
    for group in range(len(spatial.starts) - 1):
        first = spatial.starts[group]
        while first < spatial.starts[group + 1]:
            blade, end = spatial.blade[spatial.points[first]], first
            deepest = splat(lanes, -np.inf)
            while end < len(spatial.points) and spatial.blade[spatial.points[end]] == blade:
                deepest = larger(load(lanes, state.penetration, spatial.points[end]), deepest)
                end += 1
            store(spatial.deepest, blade, deepest)
            if any_lane(below(threshold, deepest)):
                for place in range(first, end):
                    state.active[n_active] = spatial.points[place]
                    n_active += 1
            first = end
        if n_active > spatial.groups[n_groups]:
            n_groups += 1
            spatial.groups[n_groups] = n_active
    return n_groups


@compiled(allocates=False)
def guess(lanes: tuple, state: State, spatial: Spatial, deepest: np.ndarray) -> None:
    """Points that carry a force, from those of the step before (state, spatial are modified).

    A point that penetrates does, unless others have held it out in the step before.

    Parameters
    ----------
    lanes, state, spatial
        As in `kernel.integrate`.
    deepest : ndarray (L,)
        Deepest penetration of the step [m]; lanes without contact keep their guess.
    """
    zero, one = splat(lanes, 0.0), splat(lanes, 1.0)
    contact = below(zero, deepest)
    for i in spatial.points:
        before = load(lanes, spatial.touching, i)
        penetrates = below(zero, load(lanes, state.penetration, i))
        new = select(penetrates, select(below(before, zero), zero, one), zero)
        store(spatial.touching, i, select(contact, new, before))
        store(state.multiplier, i, zero)


@compiled(allocates=False)
def solve_blades(
    lanes: tuple,
    scheme: Scheme,
    contact: Contact,
    state: State,
    spatial: Spatial,
    deepest: np.ndarray,
) -> int:
    """Multipliers of all points that may carry a force (contact, state, spatial are modified).

    Works on x_j = λ_j W_jj, the depth that contact j alone would undo; `turned_forces` scales it.

    Parameters
    ----------
    lanes, scheme, contact, state, spatial
        As in `kernel.integrate`.
    deepest : ndarray (L,)
        Deepest penetration of the step [m].

    Returns
    -------
    int
        Entries of `State.active` that count.
    """
    zero, one = splat(lanes, 0.0), splat(lanes, 1.0)
    limit = positive_part(deepest) * splat(lanes, TOLERANCE)
    threshold = zero - positive_part(deepest) * splat(lanes, NEAR)
    n_groups = list_near(lanes, state, spatial, threshold)
    guess(lanes, state, spatial, deepest)
    turn_penetrating(lanes, scheme, contact, state, spatial, spatial.groups[n_groups])
    changing, trials, stuck = below(zero, deepest), zero, zero
    for _ in range(MOST_SWEEPS):
        change, most, stuck = zero, zero, zero
        for g in range(n_groups):
            left_by_others(lanes, contact, state, spatial, n_groups, g)
            tried, unfinished = solve_group(
                lanes, scheme, contact, state, spatial, n_groups, g, threshold, limit, changing
            )
            most, stuck = larger(tried, most), larger(unfinished, stuck)
            for a in range(spatial.groups[g], spatial.groups[g + 1]):
                moved = load(lanes, state.multiplier, state.active[a])
                moved = moved - load(lanes, spatial.wrong, a - spatial.groups[g])
                change = larger(larger(moved, zero - moved), change)
        trials = trials + select(below(limit, change), most, zero)
        unsettled = select(below(limit, select(changing, change, zero)), one, zero)
        if n_groups == 1:
            unsettled = zero
        felt = reach_of_forces(lanes, contact, state, spatial, spatial.groups[n_groups])
        if any_lane(below(felt, threshold)):
            more = count_between(lanes, spatial, felt, threshold)
            threshold = select(below(felt, threshold), felt, threshold)
            if any_lane(below(zero, more)):
                n_groups = list_near(lanes, state, spatial, threshold)
                turn_penetrating(lanes, scheme, contact, state, spatial, spatial.groups[n_groups])
                unsettled = larger(more, unsettled)
        changing = below(zero, unsettled)
        if not any_lane(changing):
            break
    stuck = larger(stuck, select(changing, one, zero))
    store(state.report, SWEEPS, larger(trials, load(lanes, state.report, SWEEPS)))
    if any_lane(below(zero, stuck)):
        n_groups = list_near(lanes, state, spatial, splat(lanes, -np.inf))
        turn_all(lanes, scheme, contact, state, spatial, spatial.groups[n_groups])
        store(spatial.right, 0, stuck)
        solve_stuck(contact, state, spatial, spatial.groups[n_groups])
    return spatial.groups[n_groups]


@compiled(allocates=False)
def reach_of_forces(
    lanes: tuple, contact: Contact, state: State, spatial: Spatial, n_active: int
) -> np.ndarray:
    """Minus the depth (L,) that the forces can push points of other blades in, a bound [m].

    Parameters
    ----------
    lanes, contact, state, spatial
        As in `kernel.integrate`.
    n_active : int
        Entries of `State.active` that count.
    """
    total = splat(lanes, 0.0)
    for a in range(n_active):
        if spatial.turned[a]:
            i = state.active[a]
            total = fma(load(lanes, state.multiplier, i), load(lanes, contact.stiffness, i), total)
    return splat(lanes, 0.0) - total * load(lanes, contact.reach, 0)


@compiled(allocates=False)
def count_between(lanes: tuple, spatial: Spatial, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Blades (L,) that penetrate by more than ``low`` and no more than ``high`` [m]."""
    zero, one, count = splat(lanes, 0.0), splat(lanes, 1.0), splat(lanes, 0.0)
    for blade in range(spatial.deepest.shape[0]):
        depth = load(lanes, spatial.deepest, blade)
        count = count + select(below(high, depth), zero, select(below(low, depth), one, zero))
    return count


@compiled(allocates=False)
def turn_all(
    lanes: tuple, scheme: Scheme, contact: Contact, state: State, spatial: Spatial, n_active: int
) -> None:
    """Columns of all listed points; as `turn_penetrating`."""
    for a in range(n_active):
        spatial.fresh[a] = a
    turn(lanes, scheme, contact, state, spatial, n_active, n_active)


@compiled(allocates=False)
def left_by_others(
    lanes: tuple, contact: Contact, state: State, spatial: Spatial, n_groups: int, group: int
) -> None:
    """Penetrations of a group that the forces on the other groups leave (state.depth, modified).

    Parameters
    ----------
    lanes, contact, state, spatial
        As in `kernel.integrate`.
    n_groups : int
        Groups with listed points.
    group : int
        One of them.
    """
    n_rows = state.penetration.shape[0]
    start, end = spatial.groups[group], spatial.groups[group + 1]
    for a in range(start, end):
        store(state.depth, a, load(lanes, state.penetration, state.active[a]))
    for b in range(spatial.groups[n_groups]):
        if spatial.turned[b] and not start <= b < end:
            less = splat(lanes, 0.0) - load(lanes, state.multiplier, state.active[b])
            for a in range(start, end):
                effect = load(lanes, contact.coupling, b * n_rows + a)
                store(state.depth, a, fma(effect, less, load(lanes, state.depth, a)))


@compiled
def solve_stuck(contact: Contact, state: State, spatial: Spatial, n_active: int) -> None:
    """Multipliers of the lanes marked in ``spatial.right`` by pivoting (state is modified).

    Parameters
    ----------
    contact, state, spatial
        As in `kernel.integrate`.
    n_active : int
        Entries of `State.active`: all points, with their columns.
    """
    n_rows = state.penetration.shape[0]
    rows = state.active[:n_active].copy()
    M = np.empty((n_active, n_active))
    x = np.zeros(n_active)
    for lane in range(state.report.shape[1]):
        if spatial.right[0, lane] == 0.0:
            continue
        for b in range(n_active):
            for a in range(n_active):
                M[a, b] = contact.coupling[b * n_rows + a, lane]
        x[:] = 0.0
        if not solve_by_pivoting(M, state.penetration[:, lane][rows], x):
            state.report[UNSOLVED, lane] = 1.0
        for a, i in enumerate(rows):
            state.multiplier[i, lane] = x[a]
