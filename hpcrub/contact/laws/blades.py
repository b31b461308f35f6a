"""Multipliers of blades with several contact points, by exact solutions.

The contact points of one blade are coupled so stiffly that Gauss–Seidel from point to point takes
up to hundreds of sweeps at small steps. So `active_set` solves the problem of all points that may
touch exactly, with a warm start from the active set of the step before. Lanes in which it does not
end go to Lemke's method.

At first only blades that penetrate, or nearly do, take part. Their forces bound the depth that they
can push other blades in, and blades within this bound join. A lane never depends on other lanes.
"""

import numpy as np

from hpcrub.contact import lanes as v
from hpcrub.contact.arrays import STUCK, SWEEPS, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.laws.active_set import solve_points
from hpcrub.contact.laws.friction import fill_column, turn
from hpcrub.contact.laws.solid_arrays import SolidArrays
from hpcrub.contact.lcp.gauss_seidel import TOLERANCE

MOST_ROUNDS = 100  # in which further blades join; hardly ever more than two
NEAR_AT_FIRST = 0.5  # distance of blades that take part at first, over the deepest penetration


@compiled(inner=True)
def list_near(lanes: tuple, state: State, law: SolidArrays, threshold: np.ndarray) -> int:
    """List the points of blades that penetrate more than a threshold in any lane.

    threshold: negative, so that blades close to the casing are listed, too.
    Returns their number; ``law.deepest`` holds the depth of each blade (state, law are modified).
    """
    n_listed = 0
    for blade in range(len(law.first) - 1):
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
                state.active[n_listed] = law.points[place]
                law.kinematics.see(lanes, law, law.points[place])
                n_listed += 1
    return n_listed


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
def list_pushing(lanes: tuple, state: State, law: SolidArrays, n_listed: int) -> int:
    """List in ``law.fresh`` the points with a force of this step or earlier ones.

    Also lists points that penetrate and could jam, which nobody would see where other points hold
    them out. Forgets all columns (law is modified). Returns the number of these points.
    """
    n, jams = 0, v.load(lanes, law.jams, 0)
    for a in range(n_listed):
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
    n = list_near(lanes, state, law, threshold)
    guess(lanes, state, law, deepest)
    turn(lanes, state, law, list_pushing(lanes, state, law, n), n)
    solving, trials, stuck = deepest > 0.0, zero, zero
    for _ in range(MOST_ROUNDS):
        for a in range(n):
            v.store(state.depth, a, v.load(lanes, state.penetration, state.active[a]))
        law.surface.subtract_earlier(lanes, law.surface, state, law, n)
        tried, unfinished = solve_points(lanes, state, law, n, threshold, limit, solving)
        trials, stuck = trials + tried, v.select(solving, unfinished, stuck)
        felt, more = reach_of_forces(lanes, state, law, n), zero
        if v.any_lane(felt < threshold):
            more = count_between(lanes, law, felt, threshold)
            threshold = v.select(felt < threshold, felt, threshold)
        solving = more > 0.0
        if not v.any_lane(solving):
            break
        n = list_near(lanes, state, law, threshold)
        for b in range(list_pushing(lanes, state, law, n)):
            fill_column(lanes, state, law, law.fresh[b], n)
    stuck = v.larger(stuck, v.select(solving, 1.0, 0.0))
    v.store(state.report, SWEEPS, v.larger(trials, v.load(lanes, state.report, SWEEPS)))
    if v.any_lane(stuck > 0.0):
        n = list_near(lanes, state, law, v.splat(lanes, -np.inf))
        for a in range(n):
            law.fresh[a] = a
        turn(lanes, state, law, n, n)
        v.store(state.report, STUCK, stuck)
        law.surface.give_up(state, law, n)
    return n


@compiled(inner=True)
def reach_of_forces(lanes: tuple, state: State, law: SolidArrays, n_listed: int) -> np.ndarray:
    """Minus a bound (L,) [m] on the depth that the forces can push points of other blades in."""
    total = v.splat(lanes, 0.0)
    for a in range(n_listed):
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
