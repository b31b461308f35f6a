"""The multipliers of blades with several contact points: from blade to blade, each solved exactly.

The contact points of one blade are coupled so stiffly that Gauss–Seidel from point to point takes
up to hundreds of sweeps at small steps. Blades act on one another much less. So the sweeps go from
blade to blade, and the problem of one blade is solved exactly: the set of its points that carry a
force is guessed (those of the step before), the linear equations of the set are solved, and points
of the wrong sign change sides (principal pivoting; Júdice and Pires 1994). All lanes do so at once.
A lane is never changed by what the other lanes need. What does not converge goes to Lemke's method.
"""

import numpy as np

from hpcrub.contact.arrays import Contact, Spatial, State
from hpcrub.contact.complementarity import SWEEPS, UNSOLVED, solve_by_pivoting
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import (
    any_lane,
    below,
    fma,
    inverse,
    larger,
    load,
    positive_part,
    select,
    splat,
    store,
)
from hpcrub.contact.multipliers import TOLERANCE

MOST_TRIALS = 60  # guesses of the points of a blade that carry a force; one or two are usual
ALL_AT_ONCE = 12  # of these, those after which all points of the wrong sign change sides
MOST_SWEEPS = 100  # from blade to blade; three or so are usual


@compiled
def nearness(lanes: tuple, contact: Contact, deepest: np.ndarray) -> np.ndarray:
    """Penetration (L,) from which on a point may be pushed in by forces on other blades [m]."""
    return splat(lanes, 0.0) - positive_part(deepest) * load(lanes, contact.reach, 0)


@compiled
def solve_blades(
    lanes: tuple,
    contact: Contact,
    state: State,
    spatial: Spatial,
    deepest: np.ndarray,
    n_blades: int,
) -> None:
    """Multipliers of all active points, blade by blade (state and spatial are modified).

    Works on x_j = λ_j W_jj, the depth that contact j alone would undo; `turned_forces` scales it.

    Parameters
    ----------
    lanes, contact, state, spatial
        As in `kernel.integrate`.
    deepest : ndarray (L,)
        Deepest penetration of the step [m].
    n_blades : int
        Active blades.
    """
    zero, one = splat(lanes, 0.0), splat(lanes, 1.0)
    limit = positive_part(deepest) * splat(lanes, TOLERANCE)
    threshold = nearness(lanes, contact, deepest)
    for a in range(spatial.blades[n_blades]):
        store(state.multiplier, state.active[a], zero)
    changing, trials, stuck = below(zero, deepest), zero, zero
    for _ in range(MOST_SWEEPS):
        change, most, stuck = zero, zero, zero
        for b in range(n_blades):
            start, end = spatial.blades[b], spatial.blades[b + 1]
            largest = splat(lanes, -np.inf)
            for a in range(start, end):
                i = state.active[a]
                largest = larger(load(lanes, state.penetration, i), largest)
                depth = left_by_others(lanes, contact, state, spatial, n_blades, b, i)
                store(state.depth, i, depth)
            solving = below(select(changing, threshold, splat(lanes, np.inf)), largest)
            tried, unfinished = solve_blade(
                lanes, contact, state, spatial, start, end, limit, solving
            )
            most, stuck = larger(tried, most), larger(unfinished, stuck)
            for a in range(start, end):
                moved = load(lanes, state.multiplier, state.active[a])
                moved = moved - load(lanes, spatial.wrong, a - start)
                change = larger(larger(moved, zero - moved), change)
        trials = trials + select(below(limit, change), most, zero)
        changing = below(limit, select(changing, change, zero))
        if n_blades == 1 or not any_lane(changing):
            break
    if n_blades > 1:
        stuck = larger(stuck, select(changing, one, zero))
    store(state.report, SWEEPS, larger(trials, load(lanes, state.report, SWEEPS)))
    if any_lane(below(zero, stuck)):
        store(spatial.right, 0, stuck)
        store(spatial.right, 1, threshold)
        solve_stuck(lanes, contact, state, spatial, n_blades)


@compiled
def left_by_others(
    lanes: tuple,
    contact: Contact,
    state: State,
    spatial: Spatial,
    n_blades: int,
    blade: int,
    i: int,
) -> np.ndarray:
    """Penetration (L,) of a point that the forces on the other active blades leave [m].

    Parameters
    ----------
    lanes, contact, state, spatial
        As in `kernel.integrate`.
    n_blades : int
        Active blades.
    blade : int
        Place among the active blades of that of the point.
    i : int
        Contact point.
    """
    n_rows = state.penetration.shape[0]
    depth = load(lanes, state.penetration, i)
    for b in range(n_blades):
        if b != blade:
            for a in range(spatial.blades[b], spatial.blades[b + 1]):
                j = state.active[a]
                effect = load(lanes, contact.coupling, i * n_rows + j)
                depth = depth - effect * load(lanes, state.multiplier, j)
    return depth


@compiled
def choose(lanes: tuple, state: State, spatial: Spatial, start: int, end: int) -> int:
    """Points of a blade that touch in the guess of any lane (spatial.chosen, modified).

    Parameters
    ----------
    lanes, state, spatial
        As in `kernel.integrate`.
    start, end : int
        Places in `State.active` of the first point of the blade and after the last.

    Returns
    -------
    int
        Points chosen.
    """
    n = 0
    for a in range(start, end):
        i = state.active[a]
        if any_lane(below(splat(lanes, 0.0), load(lanes, spatial.touching, i))):
            spatial.chosen[n] = i
            n += 1
    return n


@compiled
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
    n_rows, width = state.penetration.shape[0], len(spatial.right)
    for r in range(n):
        i = spatial.chosen[r]
        touches = load(lanes, spatial.touching, i)
        store(spatial.right, r, touches * load(lanes, state.depth, i))
        for c in range(n):
            j = spatial.chosen[c]
            both = touches * load(lanes, spatial.touching, j)
            value = both * load(lanes, contact.coupling, i * n_rows + j)
            if r == c:
                value = value + (splat(lanes, 1.0) - touches)
            store(spatial.factor, r * width + c, value)
    for p in range(n):
        scale = inverse(load(lanes, spatial.factor, p * width + p))
        store(spatial.factor, p * width + p, scale)
        known = load(lanes, spatial.right, p)
        for r in range(p + 1, n):
            less = splat(lanes, 0.0) - load(lanes, spatial.factor, r * width + p) * scale
            store(spatial.right, r, fma(less, known, load(lanes, spatial.right, r)))
            for c in range(p + 1, n):
                at = r * width + c
                pivot = load(lanes, spatial.factor, p * width + c)
                store(spatial.factor, at, fma(less, pivot, load(lanes, spatial.factor, at)))
    for back in range(n):
        p = n - 1 - back
        x = load(lanes, spatial.right, p)
        for c in range(p + 1, n):
            x = x - load(lanes, spatial.factor, p * width + c) * load(lanes, spatial.right, c)
        store(spatial.right, p, x * load(lanes, spatial.factor, p * width + p))


@compiled
def find_wrong(
    lanes: tuple,
    contact: Contact,
    state: State,
    spatial: Spatial,
    start: int,
    end: int,
    n: int,
    limit: np.ndarray,
    trying: np.ndarray,
) -> np.ndarray:
    """Mark the points whose force pulls, or that penetrate without one (spatial.wrong, modified).

    Parameters
    ----------
    lanes, contact, state, spatial
        As in `kernel.integrate`.
    start, end : int
        Places in `State.active` of the first point of the blade and after the last.
    n : int
        Chosen points, the first of ``spatial.chosen``.
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
    count = zero
    for a in range(start, end):
        i = state.active[a]
        depth, force = load(lanes, state.depth, i), zero
        for r in range(n):
            x = load(lanes, spatial.right, r)
            depth = depth - load(lanes, contact.coupling, i * n_rows + spatial.chosen[r]) * x
            if spatial.chosen[r] == i:
                force = x
        touches = below(zero, load(lanes, spatial.touching, i))
        pulls = select(below(force, zero), one, zero)
        penetrates = select(below(limit, depth), one, zero)
        wrong = select(trying, select(touches, pulls, penetrates), zero)
        store(spatial.wrong, a - start, wrong)
        count = count + wrong
    return count


@compiled
def change_sides(
    lanes: tuple, state: State, spatial: Spatial, start: int, end: int, all_at_once: bool
) -> None:
    """Let points of the wrong sign change sides (spatial.touching, modified).

    Parameters
    ----------
    lanes, state, spatial
        As in `kernel.integrate`.
    start, end : int
        Places in `State.active` of the first point of the blade and after the last.
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


@compiled
def solve_blade(
    lanes: tuple,
    contact: Contact,
    state: State,
    spatial: Spatial,
    start: int,
    end: int,
    limit: np.ndarray,
    solving: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Multipliers of one blade (state.multiplier, spatial are modified).

    Parameters
    ----------
    lanes, contact, spatial
        As in `kernel.integrate`.
    state : State
        On entry ``depth`` holds what the other blades leave of the penetrations [m].
    start, end : int
        Places in `State.active` of the first point of the blade and after the last.
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
    On return ``spatial.wrong`` holds the multipliers from before. Principal pivoting: Júdice and
    Pires (1994).
    """
    zero, one = splat(lanes, 0.0), splat(lanes, 1.0)
    n, trying, tried = 0, solving, zero
    for trial in range(MOST_TRIALS):
        n = choose(lanes, state, spatial, start, end)
        solve_set(lanes, contact, state, spatial, n)
        count = find_wrong(lanes, contact, state, spatial, start, end, n, limit, trying)
        tried = tried + select(trying, one, zero)
        trying = below(zero, count)
        if not any_lane(trying):
            break
        change_sides(lanes, state, spatial, start, end, trial < ALL_AT_ONCE)
    for a in range(start, end):
        i = state.active[a]
        old, force = load(lanes, state.multiplier, i), zero
        for r in range(n):
            if spatial.chosen[r] == i:
                force = positive_part(load(lanes, spatial.right, r))
        store(spatial.wrong, a - start, old)
        store(state.multiplier, i, select(solving, force, old))
    return tried, select(trying, one, zero)


@compiled
def solve_stuck(
    lanes: tuple, contact: Contact, state: State, spatial: Spatial, n_blades: int
) -> None:
    """Multipliers of the lanes marked in ``spatial.right`` by pivoting (state is modified).

    Only blades near the casing in the lane itself take part: others' would change its rounding.

    Parameters
    ----------
    lanes, contact, state, spatial
        As in `kernel.integrate`.
    n_blades : int
        Active blades.
    """
    n_rows = state.penetration.shape[0]
    n_active = spatial.blades[n_blades]
    for lane in range(len(lanes)):
        if spatial.right[0, lane] == 0.0:
            continue
        near = np.zeros(n_active, dtype=np.bool_)
        for b in range(n_blades):
            part = slice(spatial.blades[b], spatial.blades[b + 1])
            depth = state.penetration[:, lane][state.active[part]]
            near[part] = depth.max() > spatial.right[1, lane]
        rows = state.active[:n_active][near]
        M = np.empty((len(rows), len(rows)))
        p = np.empty(len(rows))
        for a, i in enumerate(rows):
            p[a] = state.penetration[i, lane]
            for b, j in enumerate(rows):
                M[a, b] = contact.coupling[i * n_rows + j, lane]
        x = np.zeros(len(rows))
        if not solve_by_pivoting(M, p, x):
            state.report[UNSOLVED, lane] = 1.0
        for i in state.active[:n_active]:
            state.multiplier[i, lane] = 0.0
        for a, i in enumerate(rows):
            state.multiplier[i, lane] = x[a]
