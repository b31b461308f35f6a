"""Multipliers of blades with several contact points, by exact solutions for groups of blades.

The contact points of one blade are coupled so stiffly that Gauss–Seidel from point to point takes
up to hundreds of sweeps at small steps. So blades form groups of at most `solid.GROUP` points, and
`groups` solves the problem of a group exactly, with a warm start from the active set of the step
before. Where there are several groups, sweeps go from group to group. Lanes that do not converge
go to Lemke's method.

At first only blades that penetrate, or nearly do, take part. Their forces bound the depth that they
can push other blades in, and blades within this bound join. A lane never depends on other lanes.
"""

import numpy as np

from hpcrub.contact import lanes as v
from hpcrub.contact.arrays import STUCK, SWEEPS, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.laws.friction import fill_column, turn
from hpcrub.contact.laws.groups import solve_group
from hpcrub.contact.laws.solid_arrays import SolidArrays
from hpcrub.contact.lcp.gauss_seidel import TOLERANCE

MOST_SWEEPS = 100  # sweeps from group to group; about three are usual
NEAR_AT_FIRST = 0.5  # distance of blades that take part at first, over the deepest penetration


@compiled(inner=True)
def list_near(lanes: tuple, state: State, law: SolidArrays, threshold: np.ndarray) -> int:
    """List the points of blades that penetrate more than a threshold in any lane.

    threshold: negative, so that blades close to the casing are listed, too.
    Returns the number of groups with points in the list. ``law.groups`` holds the place in
    ``state.active`` where each begins, ``law.deepest`` the depth of each blade (all modified).
    """
    n_groups = n_active = 0
    law.groups[0] = 0
    for group in range(len(law.starts) - 1):
        for blade in range(law.starts[group], law.starts[group + 1]):
            places = range(law.first[blade], law.first[blade + 1])
            deepest = v.splat(lanes, -np.inf)
            for place in places:
                i = law.points[place]
                depth = v.load(lanes, state.penetration, i)
                depth = law.surface.effective_depth(lanes, law.surface, i, depth)
                deepest = v.larger(depth, deepest)
            v.store(law.deepest, blade, deepest)
            if v.any_lane(threshold < deepest):
                for place in places:
                    state.active[n_active] = law.points[place]
                    law.kinematics.see(lanes, law, law.points[place])
                    n_active += 1
        if n_active > law.groups[n_groups]:
            n_groups += 1
            law.groups[n_groups] = n_active
    return n_groups


@compiled(inner=True)
def guess(lanes: tuple, state: State, law: SolidArrays, deepest: np.ndarray) -> None:
    """Guess the active set, by a warm start from the step before (state, law are modified).

    A point that penetrates carries a force, unless the forces on other points held it out in the
    step before. The guess takes the line of the step before, or the first line of the surface.

    deepest: (L,) deepest penetration of the step [m]; lanes without contact keep their guess.
    """
    for i in law.points:
        before = v.load(lanes, law.touching, i)
        penetrates = v.load(lanes, state.penetration, i) > 0.0
        new = v.select(penetrates, v.select(before < 0.0, 0.0, v.larger(1.0, before)), 0.0)
        v.store(law.touching, i, v.select(deepest > 0.0, new, before))
        v.store(state.multiplier, i, v.splat(lanes, 0.0))


@compiled(inner=True)
def list_pushing(lanes: tuple, state: State, law: SolidArrays, n_active: int) -> int:
    """List in ``law.fresh`` the points with a force of this step or earlier ones.

    Also lists points that penetrate and could jam, which nobody would see where other points hold
    them out. Forgets all columns (law is modified). Returns the number of listed points.
    """
    n, jams = 0, v.load(lanes, law.jams, 0)
    for a in range(n_active):
        i = state.active[a]
        law.turned[a] = 0
        law.fresh[n] = a
        pushes = v.load(lanes, state.multiplier, i)
        pushes = v.larger(jams * v.load(lanes, state.penetration, i), pushes)
        pushes = law.surface.total_force(lanes, law.surface, i, pushes)
        n += int(v.any_lane(pushes > 0.0))
    return n


@compiled(inner=True)
def solve_blades(lanes: tuple, state: State, law: SolidArrays, deepest: np.ndarray) -> int:
    """Multipliers of all points that may carry a force (state, law are modified).

    The unknowns are x_j = λ_j W_jj, the depths that each contact alone would undo, which
    `solid.turned_forces` scales to forces. Returns the number of entries in `State.active`.
    """
    zero = v.splat(lanes, 0.0)
    limit = v.larger(deepest, 0.0) * TOLERANCE
    threshold = 0.0 - v.larger(deepest, 0.0) * NEAR_AT_FIRST
    n_groups = list_near(lanes, state, law, threshold)
    guess(lanes, state, law, deepest)
    n_fresh = list_pushing(lanes, state, law, law.groups[n_groups])
    turn(lanes, state, law, n_fresh, law.groups[n_groups])
    changing, trials, stuck = deepest > 0.0, zero, zero
    for _ in range(MOST_SWEEPS):
        change, most, stuck = zero, zero, zero
        for g in range(n_groups):
            left_by_others(lanes, state, law, n_groups, g)
            moved, tried, unfinished = solve_group(
                lanes, state, law, n_groups, g, threshold, limit, changing
            )
            most, stuck = v.larger(tried, most), v.larger(unfinished, stuck)
            change = v.larger(moved, change)
        trials = trials + v.select(limit < change, most, 0.0)
        unsettled = v.select(limit < v.select(changing, change, 0.0), 1.0, 0.0)
        if n_groups == 1:
            unsettled = zero
        felt = reach_of_forces(lanes, state, law, law.groups[n_groups])
        if v.any_lane(felt < threshold):
            more = count_between(lanes, law, felt, threshold)
            threshold = v.select(felt < threshold, felt, threshold)
            if v.any_lane(more > 0.0):
                n_groups = list_near(lanes, state, law, threshold)
                for b in range(list_pushing(lanes, state, law, law.groups[n_groups])):
                    fill_column(lanes, state, law, law.fresh[b], law.groups[n_groups])
                unsettled = v.larger(more, unsettled)
        changing = unsettled > 0.0
        if not v.any_lane(changing):
            break
    stuck = v.larger(stuck, v.select(changing, 1.0, 0.0))
    v.store(state.report, SWEEPS, v.larger(trials, v.load(lanes, state.report, SWEEPS)))
    if v.any_lane(stuck > 0.0):
        n_groups = list_near(lanes, state, law, v.splat(lanes, -np.inf))
        for a in range(law.groups[n_groups]):
            law.fresh[a] = a
        turn(lanes, state, law, law.groups[n_groups], law.groups[n_groups])
        v.store(state.report, STUCK, stuck)
        law.surface.give_up(state, law, law.groups[n_groups])
    return law.groups[n_groups]


@compiled(inner=True)
def reach_of_forces(lanes: tuple, state: State, law: SolidArrays, n_active: int) -> np.ndarray:
    """Minus a bound (L,) [m] on the depth that the forces can push points of other blades in."""
    total = v.splat(lanes, 0.0)
    for a in range(n_active):
        if law.turned[a]:
            i = state.active[a]
            force = v.load(lanes, state.multiplier, i) * v.load(lanes, law.stiffness, i)
            force = law.surface.total_force(lanes, law.surface, i, force)
            total = v.fma(force, v.load(lanes, law.across, i), total)
    return 0.0 - total


@compiled(inner=True)
def count_between(lanes: tuple, law: SolidArrays, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Number of blades (L,) that penetrate by more than ``low`` and at most ``high`` [m]."""
    count = v.splat(lanes, 0.0)
    for blade in range(law.deepest.shape[0]):
        depth = v.load(lanes, law.deepest, blade)
        count = count + v.select(high < depth, 0.0, v.select(low < depth, 1.0, 0.0))
    return count


@compiled(inner=True)
def left_by_others(lanes: tuple, state: State, law: SolidArrays, n_groups: int, group: int) -> None:
    """Set ``state.depth`` to the penetrations of a group that forces on other groups leave."""
    n_rows = state.penetration.shape[0]
    start, end = law.groups[group], law.groups[group + 1]
    for a in range(start, end):
        v.store(state.depth, a, v.load(lanes, state.penetration, state.active[a]))
    law.surface.subtract_earlier(lanes, law.surface, state, law, start, end, law.groups[n_groups])
    for b in range(law.groups[n_groups]):
        if law.turned[b] and not start <= b < end:
            less = 0.0 - v.load(lanes, state.multiplier, state.active[b])
            for a in range(start, end):
                effect = v.load(lanes, law.coupling, b * n_rows + a)
                v.store(state.depth, a, v.fma(effect, less, v.load(lanes, state.depth, a)))
