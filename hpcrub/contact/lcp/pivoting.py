"""The linear complementarity problem of the contact forces: λ ≥ 0, w = Wλ − p ≥ 0, λ·w = 0.

It has exactly one solution for every p if and only if W is a P-matrix: all its principal minors
are positive. Without friction W is positive definite. Friction on a leaned blade reduces the
diagonal: once W_jj ≤ 0, a force on blade j no longer pushes it out (jamming), and before that
other minors may have changed sign.
Source: Cottle, Pang, Stone, The Linear Complementarity Problem (1992), chapters 3 and 4.

Lemke's method works on a ``tableau`` (n, 2n + 2), columns of w, x, the artificial variable and the
right-hand side, and on a ``basis`` (n,) int, the column that is basic in each row.
"""

from typing import Any

import numpy as np

from hpcrub.contact.arrays import STUCK, UNSOLVED, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.status import JAMMING, NONE, NOT_FINITE, NOT_UNIQUE, UNPROVEN

MOST_MINORS = 14  # points up to which all principal minors are tested: 2^14 minors
PIVOTS = 20  # calls of `pivot` allowed per row; one or two are usual
SLACK = 1e-9  # accepted violation of a solution by pivoting, over the deepest penetration


def flaw(W: np.ndarray) -> int:
    """Return why the contact forces may not be unique, as a code of ``status``.

    W: (n, n) Delassus operator [m/N].
    The code is NONE, JAMMING, NOT_UNIQUE, NOT_FINITE, or UNPROVEN when there are too many points
    to decide.
    """
    if not np.isfinite(W).all():
        return NOT_FINITE
    diagonal = np.diag(W)
    if not (diagonal > 0.0).all():
        return JAMMING
    coupling = np.abs(W / diagonal)
    np.fill_diagonal(coupling, 0.0)
    if coupling.sum(axis=1).max() < 1.0:
        return NONE  # diagonally dominant
    if np.linalg.eigvalsh(W + W.T)[0] > 0.0:
        return NONE  # positive definite
    if len(W) > MOST_MINORS:
        return UNPROVEN
    return NONE if is_p_matrix(W) else NOT_UNIQUE


def is_p_matrix(W: np.ndarray) -> bool:
    """Whether all principal minors of a square matrix (n, n) are positive.

    This is the recursion of Tsatsomeros and Li (2000): W is a P-matrix if and only if W_00 > 0 and
    both W without row and column 0, and the Schur complement of W_00, are P-matrices.
    """
    stack = np.asarray(W, dtype=float)[None]
    while stack.shape[-1] > 0:
        pivot = stack[:, 0, 0]
        if not (pivot > 0.0).all():
            return False
        rest = stack[:, 1:, 1:]
        schur = rest - stack[:, 1:, :1] * stack[:, :1, 1:] / pivot[:, None, None]
        stack = np.concatenate([rest, schur])
    return True


@compiled(inner=True)
def pivot(tableau: np.ndarray, basis: np.ndarray, row: int, column: int) -> None:
    """Bring a column into the basis in place of a row's present one (tableau, basis modified).

    row: row whose variable leaves the basis; column: column that enters the basis.
    """
    n, scale = tableau.shape[1], tableau[row, column]
    for k in range(n):
        tableau[row, k] /= scale
    for i in range(len(basis)):
        factor = tableau[i, column]
        if i != row:
            for k in range(n):
                tableau[i, k] -= factor * tableau[row, k]
    basis[row] = column


@compiled(inner=True)
def leaving_row(tableau: np.ndarray, basis: np.ndarray, column: int) -> int:
    """Row of the smallest ratio; of equal ratios, the row of the artificial variable.

    column: column that enters the basis.
    Returns −1 for an unbounded ray.

    Equal ratios, which equal penetrations give, are compared as if the right-hand sides differed
    by ever smaller amounts (lexicographically); otherwise the method could run in circles.
    """
    n = len(basis)
    best, row, largest = np.inf, -1, 0.0
    for i in range(n):
        size = abs(tableau[i, column])
        if size > largest or size != size:  # a NaN stays
            largest = size
    smallest = 1e-11 * largest
    for i in range(n):
        if tableau[i, column] > smallest:
            ratio = tableau[i, 2 * n + 1] / tableau[i, column]
            if ratio < best or (ratio == best and comes_first(tableau, basis, column, i, row)):
                best, row = ratio, i
    return row


@compiled(inner=True)
def comes_first(tableau: np.ndarray, basis: np.ndarray, column: int, i: int, j: int) -> bool:
    """Whether row i goes before row j at equal ratios; other parameters as in `leaving_row`."""
    n = len(basis)
    if basis[i] == 2 * n or basis[j] == 2 * n:
        return basis[i] == 2 * n
    for k in range(n):
        own, other = tableau[i, k] / tableau[i, column], tableau[j, k] / tableau[j, column]
        if own != other:
            return own < other
    return False


@compiled(inner=True)
def begin(tableau: np.ndarray, basis: np.ndarray, M: np.ndarray, p: np.ndarray) -> int:
    """Fill the tableau, with w as basis, from M and p of `solve_by_pivoting`.

    Returns the row of the largest penetration, the last row if several are equal.
    """
    n, row = len(p), 0
    for i in range(n):
        basis[i] = i
        for j in range(n):
            tableau[i, j] = 0.0
            tableau[i, n + j] = -M[i, j]
        tableau[i, i] = 1.0
        tableau[i, 2 * n] = -1.0
        tableau[i, 2 * n + 1] = -p[i]
        row = i if p[i] >= p[row] else row
    return row


@compiled
def solve_by_pivoting(M: np.ndarray, p: np.ndarray, x: np.ndarray) -> bool:
    """Solve x ≥ 0, w = Mx − p ≥ 0, x·w = 0 with some p > 0 by Lemke's method (x is modified).

    M: (n, n) Delassus operator, its columns scaled at will.
    p: (n,) penetrations [m].
    x: (n,) result, in the unit of p over that of M; zero if the method fails.
    Returns whether the problem is solved. Lemke's method solves every problem with a P-matrix.

    Cottle, Pang, Stone (1992), chapter 4.
    """
    n = len(p)
    if n == 0:  # with penetrations that are not finite no point is listed
        return False
    tableau, basis = np.empty((n, 2 * n + 2)), np.empty(n, np.int64)
    row, column = begin(tableau, basis, M, p), 2 * n
    for _ in range(PIVOTS * n):
        left = basis[row]
        pivot(tableau, basis, row, column)
        if left == 2 * n:
            break
        column = left + n if left < n else left - n
        row = leaving_row(tableau, basis, column)
        if row < 0:
            break
    worst = 0.0
    for i in range(n):
        x[i] = 0.0
        worst = max(worst, SLACK * p[i])
    for i in range(n):
        if n <= basis[i] < 2 * n:
            x[basis[i] - n] = max(tableau[i, 2 * n + 1], 0.0)
    for i in range(n):
        w = -p[i]
        for j in range(n):
            w += M[i, j] * x[j]
        if not (w >= -worst and (x[i] <= 0.0 or w <= worst)):
            for j in range(n):
                x[j] = 0.0
            return False
    return True


@compiled
def solve_lane(state: State, lane: int, rows: np.ndarray, M: np.ndarray) -> None:
    """Depths x of listed points of one lane, or a report that there are none (state is modified).

    rows: (n,) int, the points; M: (n, n), the Delassus operator with its columns over W_jj [-].
    """
    x, p = np.zeros(len(rows)), np.empty(len(rows))
    for a, i in enumerate(rows):
        p[a] = state.penetration[i, lane]
    if not solve_by_pivoting(M, p, x):
        state.report[UNSOLVED, lane] = 1.0
    for a, i in enumerate(rows):
        state.multiplier[i, lane] = x[a]


@compiled
def solve_stuck(state: State, law: Any, n_active: int) -> None:
    """Solve the lanes that `State.report` marks as stuck (state is modified).

    law: has the operator of listed points in `coupling`, as `solid_arrays.SolidArrays`.
    n_active: number of points; all are listed and have their columns.
    """
    rows, n_rows = state.active[:n_active].copy(), state.penetration.shape[0]
    M = np.empty((n_active, n_active))
    for lane in range(state.report.shape[1]):
        if state.report[STUCK, lane] != 0.0:
            for b in range(n_active):
                for a in range(n_active):
                    M[a, b] = law.coupling[b * n_rows + a, lane]
            solve_lane(state, lane, rows, M)
