"""Exact solution for the multipliers of the listed points, by an active-set method.

A trial guesses the active set, the points that carry a force, and the line of the surface for each
point. It solves the linear equations of the set; then points that turn out not to be on their line
change it: principal pivoting (Júdice and Pires 1994), in all lanes at once.
"""

import numpy as np

from hpcrub.contact import lanes as v
from hpcrub.contact.arrays import State
from hpcrub.contact.jit import compiled
from hpcrub.contact.laws.friction import turn
from hpcrub.contact.laws.solid_arrays import SolidArrays

MOST_TRIALS = 60  # active sets to try; about two are usual
ALL_AT_ONCE = 12  # number of first trials in which all wrong points change; later one does


@compiled(inner=True)
def choose(lanes: tuple, state: State, law: SolidArrays, n_listed: int, trying: np.ndarray) -> int:
    """List in ``law.chosen`` the places of listed points that are active in any lane.

    trying: (L,) bool, lanes that count; ``law.undone`` becomes zero in them.
    Returns the number of chosen points. Also fills their columns of W (law is modified).
    """
    n, n_fresh = 0, 0
    idle = v.select(trying, 0.0, np.inf)
    for a in range(n_listed):
        active = int(v.any_lane(idle < v.load(lanes, law.touching, state.active[a])))
        old = v.load(lanes, law.undone, a)
        v.store(law.undone, a, v.select(idle > 0.0, old, 0.0))
        law.chosen[n] = law.fresh[n_fresh] = a
        n_fresh += active & (1 - law.turned[a])
        n += active
    turn(lanes, state, law, n_fresh, n_listed)
    return n


@compiled(inner=True)
def set_equations(lanes: tuple, state: State, law: SolidArrays, n: int) -> None:
    """Equations of the n chosen points, in ``law.equations`` (modified): n rows of n + 1.

    On its line a point has x = slope·d + start, where d is the depth that the other forces leave.
    Where a chosen point is not active in a lane, its row is a row of the unit matrix, and its x is
    0. The right side of a row stands at its end.
    """
    n_rows, equations = state.penetration.shape[0], law.equations
    for r in range(n):
        a, first = law.chosen[r], r * (n + 1)
        i = state.active[a]
        code = v.load(lanes, law.touching, i)
        slope, start = law.surface.linear_branch(lanes, law.surface, i, code)
        for c in range(n):
            value = slope * v.load(lanes, law.coupling, law.chosen[c] * n_rows + a)
            if r == c:
                value = value + (1.0 - slope)
            v.store(equations, first + c, value)
        v.store(equations, first + n, v.fma(slope, v.load(lanes, state.depth, a), start))


@compiled(inner=True)
def eliminate(lanes: tuple, A: np.ndarray, n: int) -> None:
    """Make n equations triangular (A, (n·(n + 1), L), is modified).

    The reciprocals of the pivots end on the diagonal.
    """
    for p in range(n):
        pivot = p * (n + 1)
        scale = v.inverse(v.load(lanes, A, pivot + p))
        v.store(A, pivot + p, scale)
        for row in range(pivot + n + 1, n * (n + 1), n + 1):
            less = 0.0 - v.load(lanes, A, row + p) * scale
            for c in range(p + 1, n + 1):
                value = v.fma(less, v.load(lanes, A, pivot + c), v.load(lanes, A, row + c))
                v.store(A, row + c, value)


@compiled(inner=True)
def solve_set(lanes: tuple, law: SolidArrays, n: int, trying: np.ndarray) -> None:
    """Solve the equations of n chosen points for the depths x, ``law.depths`` (modified).

    trying: (L,) bool, lanes whose ``law.undone`` becomes x.
    """
    idle = v.select(trying, 0.0, 1.0)
    eliminate(lanes, law.equations, n)
    for back in range(n):
        p = n - 1 - back
        row = p * (n + 1)
        less = v.splat(lanes, 0.0)
        for c in range(p + 1, n):
            factor = v.load(lanes, law.equations, row + c)
            less = v.fma(factor, v.load(lanes, law.depths, c), less)
        x = v.load(lanes, law.equations, row + n) - less
        x = x * v.load(lanes, law.equations, row + p)
        v.store(law.depths, p, x)
        at = law.chosen[p]
        v.store(law.undone, at, v.select(idle > 0.0, v.load(lanes, law.undone, at), x))


@compiled(inner=True)
def find_wrong(
    lanes: tuple, state: State, law: SolidArrays, n_listed: int, n: int,
    threshold: np.ndarray, limit: np.ndarray, trying: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """Mark points off the guessed line in ``law.wrong``, by 1 + the code of the right line.

    A point that other forces push in needs its column of W, without which `verify_branch` has no
    gains.

    n: number of chosen points.
    trying: (L,) bool, lanes without a solution so far; the others have no wrong points.
    Returns (L,); zero in lanes without wrong points.
    """
    n_rows, zero = state.penetration.shape[0], v.splat(lanes, 0.0)
    count, n_fresh = zero, 0
    # numbers, because a mask that is made before a loop is no register inside
    far = v.select(trying, threshold, np.inf)
    most = v.select(trying, limit, np.inf)
    for a in range(n_listed):
        less = zero
        for r in range(n):
            effect = v.load(lanes, law.coupling, law.chosen[r] * n_rows + a)
            less = v.fma(effect, v.load(lanes, law.depths, r), less)
        depth = v.load(lanes, state.depth, a) - less
        v.store(law.wrong, a, depth)
        if not law.turned[a] and v.any_lane(most < depth):
            law.fresh[n_fresh] = a
            n_fresh += 1
    turn(lanes, state, law, n_fresh, n_listed)
    for a in range(n_listed):
        i, x = state.active[a], v.load(lanes, law.undone, a)
        depth = v.load(lanes, law.wrong, a)
        near = far < v.load(lanes, law.deepest, law.blade[i])
        code = v.load(lanes, law.touching, i)
        wrong = law.surface.verify_branch(lanes, law.surface, i, depth, x, code, limit, trying)
        wrong = v.select(near, wrong, 0.0)
        v.store(law.wrong, a, wrong)
        count = count + wrong
    return count


@compiled(inner=True)
def change_sides(
    lanes: tuple, state: State, law: SolidArrays, n_listed: int, all_at_once: bool
) -> None:
    """Move wrong points to their right line (law.touching, modified).

    all_at_once: whether all wrong points change, or only the last.
    """
    free = v.splat(lanes, 1.0)
    for back in range(n_listed):
        a = n_listed - 1 - back
        i = state.active[a]
        wrong = v.load(lanes, law.wrong, a)
        if not all_at_once:
            is_wrong = wrong > 0.0
            wrong, free = v.select(free > 0.0, wrong, 0.0), v.select(is_wrong, 0.0, free)
        code = v.load(lanes, law.touching, i)
        v.store(law.touching, i, v.select(wrong > 0.0, wrong - 1.0, code))


@compiled(inner=True)
def solve_points(
    lanes: tuple, state: State, law: SolidArrays, n_listed: int,
    threshold: np.ndarray, limit: np.ndarray, solving: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Multipliers of the listed points (state.multiplier, law are modified).

    state: on entry ``depth`` holds the penetrations without these multipliers [m].
    solving: (L,) bool, lanes to solve; the others keep their multipliers.
    Returns tried (L,), number of active sets tried; unfinished (L,), 1 for lanes without a
    solution, else 0.

    Once a lane has its solution, trials go on with the points of the other lanes alone.
    """
    n, trying, tried = 0, solving, v.splat(lanes, 0.0)
    for trial in range(MOST_TRIALS):
        n = choose(lanes, state, law, n_listed, trying)
        set_equations(lanes, state, law, n)
        solve_set(lanes, law, n, trying)
        count = find_wrong(lanes, state, law, n_listed, n, threshold, limit, trying)
        tried = tried + v.select(trying, 1.0, 0.0)
        trying = count > 0.0
        if not v.any_lane(trying):
            break
        change_sides(lanes, state, law, n_listed, trial < ALL_AT_ONCE)
    for a in range(n_listed):
        old = v.load(lanes, state.multiplier, state.active[a])
        new = v.larger(v.load(lanes, law.undone, a), 0.0)
        v.store(state.multiplier, state.active[a], v.select(solving, new, old))
    return tried, v.select(trying, 1.0, 0.0)
