"""Projected Gauss–Seidel for the contact forces: λ ≥ 0, p − Wλ ≤ 0, λ·(p − Wλ) = 0.

Sweeps over a few points keep all unknowns in registers; lanes that do not converge are solved by
pivoting. All lanes take the first `FREE` sweeps, and then a lane that has converged keeps its
unknowns. Sums run around the contact points, from a point's successor to its predecessor, and
points that are active only in other lanes add exact zeros: no lane depends on another.
"""

from typing import Any, NamedTuple

import numpy as np

from hpcrub.contact import lanes as v
from hpcrub.contact.arrays import STUCK, SWEEPS, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.lcp.pivoting import solve_lane

ROOM = 12
FOUR, FIVE, SIX, SEVEN, EIGHT, TWELVE = ((0,) * n for n in (4, 5, 6, 7, 8, ROOM))
MAX_SWEEPS = 200  # sweeps before pivoting; about five are usual
# Sweeps that no lane leaves out. Nothing waits for a question of convergence in them, and most
# steps of the reference disk need no others.
FREE = 5
# A lane that once changed by so many tolerances has not converged, even if its last change is
# small: depths that overflow stay infinite, and their change is no number.
BLOWN_UP = 1e112
TOLERANCE = 1e-12  # tolerance of the depths x, over the deepest penetration


class Coupled(NamedTuple):
    """Delassus operator of C contact points (padded) in L lanes."""

    coupling: np.ndarray  # W_ij / W_jj ((C + 1)², L), row i·(C + 1) + j; zero where i = j or last
    stiffness: np.ndarray  # 1 / W_jj (C, L) [N/m]
    bound: np.ndarray  # see `tables.row_bound` (1, L) [-]
    surface: Any  # what the points meet, a `surfaces.Surface`


@compiled(inner=True)
def candidates(lanes: tuple, law: Coupled, state: State, deepest: np.ndarray) -> int:
    """List the points that may carry a force in any lane (state.active, modified).

    Returns the number of points in the list.

    Other forces can push a point in by at most ``bound`` times the deepest penetration. Let ρ be
    the largest row sum of |coupling|, below 1: every iterate of `solve` stays below 1/(1 − ρ) times
    the deepest penetration, so that the bound is ρ/(1 − ρ). A point farther away stays free in any
    case, and leaving it out changes no bit.
    """
    last = state.penetration.shape[0] - 1
    threshold = 0.0 - v.larger(deepest, 0.0) * v.load(lanes, law.bound, 0)
    n = 0
    for i in range(last):
        if v.any_lane(threshold < v.load(lanes, state.penetration, i)):
            state.active[n] = i
            n += 1
    for i in range(n, n + ROOM):
        state.active[i] = last
    return n


@compiled(inner=True)
def unsettled(
    lanes: tuple, limit: np.ndarray, change: np.ndarray, largest: np.ndarray
) -> np.ndarray:
    """Lanes (L,) that did not converge, by the change of the last sweep and the largest one [m]."""
    # a denormal penetration has the tolerance 0
    far = v.larger(BLOWN_UP * limit, BLOWN_UP * TOLERANCE)
    return limit < v.select(far < largest, largest, change)


@compiled(inner=True)
def solve_few(
    lanes: tuple, slots: tuple, law: Coupled, state: State, limit: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Depths x of a few active points, all in registers; see `solve`.

    slots: zeros, one per place for a point, at least as many as there are active points.
    limit: (L,) tolerance [m].
    Returns unsettled (L,) bool, lanes that did not converge; sweeps (L,), number of sweeps.
    """
    rows, n_rows = v.indices(slots, state.active, 0), state.penetration.shape[0]
    zero, change = v.splat(lanes, 0.0), v.splat(lanes, np.inf)
    sweeps, largest, x = zero, zero, v.tile_splat(slots, zero)
    for sweep in range(1, MAX_SWEEPS + 1):
        before = x
        x = v.tile_relax(law.coupling, n_rows, rows, state.penetration, x)
        if sweep >= FREE:
            changing = limit < change
            kept = v.load(lanes, state.multiplier, rows)
            v.store(state.multiplier, rows, v.select(changing, x, kept))
            change = v.tile_largest(v.magnitude(v.fma(before, -1.0, x)))
            change = v.select(changing, change, 0.0)
            sweeps = v.select(changing, float(sweep), sweeps)
            largest = v.larger(change, largest)
            if not v.any_lane(limit < change):
                break
    return unsettled(lanes, limit, change, largest), sweeps


@compiled(inner=True)
def relax(
    lanes: tuple, law: Coupled, state: State, n_active: int, changing: np.ndarray
) -> np.ndarray:
    """One sweep over the active points (state is modified).

    changing: (L,) bool, lanes to relax; the others stay as they are.
    Returns the largest change of any x (L,) [m].
    """
    n_rows, change = state.penetration.shape[0], v.splat(lanes, 0.0)
    for a in range(n_active):
        j = state.active[a]
        depth = v.load(lanes, state.penetration, j)
        for after in range(a + 1, a + n_active):
            i = state.active[after - n_active if after >= n_active else after]
            less = 0.0 - v.load(lanes, law.coupling, j * n_rows + i)
            depth = v.fma(less, v.load(lanes, state.multiplier, i), depth)
        old = v.load(lanes, state.multiplier, j)
        new = law.surface.depth_undone(lanes, law.surface, j, depth)[0]
        new = v.select(changing, new, old)
        change = v.larger(v.larger(new - old, old - new), change)
        v.store(state.multiplier, j, new)
        v.store(state.depth, j, v.select(changing, depth, v.load(lanes, state.depth, j)))
    return change


@compiled(inner=True)
def solve_many(
    lanes: tuple, law: Coupled, state: State, n_active: int, n_free: int, limit: np.ndarray,
    deepest: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Depths x of any number of active points; on a rigid casing with the bits of `solve_few`.

    The surface gives the depth x that the force on a point undoes, from the depth that the other
    forces leave, which ``state.depth`` holds on return.

    n_free: number of sweeps of all lanes that penetrate, before lanes that converge leave.
    deepest: (L,) deepest penetration [m]. Returns as `solve_few`.
    """
    zero, changing = v.splat(lanes, 0.0), deepest > 0.0
    sweeps, change, largest = zero, zero, zero
    for a in range(n_active):
        i = state.active[a]
        v.store(state.depth, i, v.load(lanes, state.penetration, i))
        v.store(state.multiplier, i, zero)
    for sweep in range(1, MAX_SWEEPS + 1):
        change = relax(lanes, law, state, n_active, changing)
        if sweep >= n_free:
            sweeps = v.select(changing, float(sweep), sweeps)
            changing, largest = limit < change, v.larger(change, largest)
            if not v.any_lane(changing):
                break
    return unsettled(lanes, limit, change, largest), sweeps


@compiled
def solve_stuck(law: Coupled, state: State, n_active: int) -> None:
    """Solve the lanes that ``state.report`` marks as stuck, by pivoting (state is modified).

    Only points within the lane's own bound take part: points of other lanes would change rounding.
    """
    n_rows = state.penetration.shape[0]
    for lane in range(state.report.shape[1]):
        if state.report[STUCK, lane] == 0.0:
            continue
        depth = state.penetration[:, lane]
        nearest = -law.bound[0, lane] * depth.max()  # a number that is none stays
        rows, n = np.empty(n_active, np.int64), 0
        for i in state.active[:n_active]:
            state.multiplier[i, lane] = 0.0
            if depth[i] > nearest:
                rows[n] = i
                n += 1
        M = np.eye(n)
        for a in range(n):
            for b in range(n):
                M[a, b] += law.coupling[rows[a] * n_rows + rows[b], lane]
        solve_lane(state, lane, rows[:n], M)


@compiled(inner=True)
def solve(lanes: tuple, law: Coupled, state: State, deepest: np.ndarray, n_active: int) -> None:
    """Contact forces of the active points by projected Gauss–Seidel (state is modified).

    The unknowns are x_j = λ_j W_jj, the depths that each contact alone would undo. A lane that has
    converged is frozen, so that its result does not depend on the number of sweeps of other lanes;
    a lane that has not converged after MAX_SWEEPS is solved by pivoting.
    """
    limit = v.larger(deepest, 0.0) * TOLERANCE
    if n_active <= len(FOUR):
        stuck, sweeps = solve_few(lanes, FOUR, law, state, limit)
    elif n_active <= len(FIVE):
        stuck, sweeps = solve_few(lanes, FIVE, law, state, limit)
    elif n_active <= len(SIX):
        stuck, sweeps = solve_few(lanes, SIX, law, state, limit)
    elif n_active <= len(SEVEN):
        stuck, sweeps = solve_few(lanes, SEVEN, law, state, limit)
    elif n_active <= len(EIGHT):
        stuck, sweeps = solve_few(lanes, EIGHT, law, state, limit)
    elif n_active <= ROOM:
        stuck, sweeps = solve_few(lanes, TWELVE, law, state, limit)
    else:
        stuck, sweeps = solve_many(lanes, law, state, n_active, FREE, limit, deepest)
    sweeps = v.select(deepest > 0.0, sweeps, 0.0)
    v.store(state.report, SWEEPS, v.larger(sweeps, v.load(lanes, state.report, SWEEPS)))
    if v.any_lane(stuck):
        v.store(state.report, STUCK, v.select(stuck, 1.0, 0.0))
        solve_stuck(law, state, n_active)
    for a in range(n_active):
        i = state.active[a]
        force = v.load(lanes, state.multiplier, i) * v.load(lanes, law.stiffness, i)
        v.store(state.multiplier, i, force)
