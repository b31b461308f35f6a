"""The multipliers: contact forces of all contact points at once, λ ≥ 0, p − Wλ ≤ 0, λ·(p − Wλ) = 0.

Projected Gauss–Seidel in registers; what does not converge is solved by pivoting. A lane that has
converged is frozen, sums run in the order of the contact points, and points that are active in
another lane only add exact zeros: no lane sees another.
"""

import numpy as np

from hpcrub.contact.arrays import Contact, State
from hpcrub.contact.complementarity import STUCK, SWEEPS, UNSOLVED, solve_by_pivoting
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import (
    TILE,
    any_lane,
    below,
    fma,
    indices,
    larger,
    load,
    positive_part,
    select,
    splat,
    store,
    tile_gather,
    tile_relax,
    tile_scatter,
    tile_splat,
)

# Contacts whose forces are found or applied in one pass: the fewer, the faster.
FEW_CONTACTS = (0,) * 4
SOME_CONTACTS = (0,) * 8
MANY_CONTACTS = (0,) * 12
MAX_SWEEPS = 200  # before pivoting; five or so are usual
# What has once changed by so many tolerances has not converged, however it looks: numbers that
# overflow end as NaN, which changes no more.
RUNAWAY = 1e112
TOLERANCE = 1e-12  # of the multipliers, relative to the largest penetration


@compiled(inline=True)
def candidates(
    lanes: tuple, contact: Contact, state: State, deepest: np.ndarray, shortcut: bool
) -> int:
    """List the points that may carry a force in any lane (state.active, modified).

    Parameters
    ----------
    lanes, contact, state
        As in `kernel.integrate`.
    deepest : ndarray (L,)
        Deepest penetration of the step [m].
    shortcut : bool
        Leave out the points that cannot; otherwise all are listed.

    Returns
    -------
    int
        Points in the list.

    Notes
    -----
    Others can gain a point in by at most ``reach`` times the deepest penetration: with ρ < 1 the
    largest row sum of |coupling|, every iterate of `solve` stays below 1/(1 − ρ) times it, so reach
    = ρ/(1 − ρ). A point farther away stays free whatever the rest does, and leaving it out changes
    no bit.
    """
    last = state.penetration.shape[0] - 1
    threshold = splat(lanes, 0.0) - positive_part(deepest) * load(lanes, contact.reach, 0)
    n = 0
    for i in range(last):
        if not shortcut or any_lane(below(threshold, load(lanes, state.penetration, i))):
            state.active[n] = i
            n += 1
    for i in range(n, n + TILE):
        state.active[i] = last
    return n


@compiled(inline=True)
def unsettled(
    lanes: tuple, limit: np.ndarray, change: np.ndarray, largest: np.ndarray
) -> np.ndarray:
    """Lanes (L,) that did not converge, by the change of the last sweep and the largest [m]."""
    # the tolerance of a denormal penetration is 0
    far = larger(splat(lanes, RUNAWAY) * limit, splat(lanes, RUNAWAY * TOLERANCE))
    ran_away = below(far, largest)
    return below(limit, select(ran_away, largest, change))


@compiled(inline=True)
def solve_few(
    lanes: tuple,
    slots: tuple,
    contact: Contact,
    state: State,
    limit: np.ndarray,
    changing: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Multipliers of a few active points, all in registers; see `solve`.

    Parameters
    ----------
    lanes, contact, state
        As in `kernel.integrate`.
    slots : tuple
        As many zeros as there is room for points, no fewer than are active.
    limit : ndarray (L,)
        Tolerance of a multiplier or penetration [m].
    changing : ndarray (L,) bool
        Lanes in which anything penetrates.

    Returns
    -------
    unsettled : ndarray (L,) bool
        Lanes that did not converge.
    sweeps : ndarray (L,)
        Sweeps that each lane took.
    """
    sweeps, change, largest = splat(lanes, 0.0), splat(lanes, 0.0), splat(lanes, 0.0)
    rows = indices(slots, state.active, 0)
    depth = tile_gather(lanes, state.penetration, rows)
    x = tile_splat(slots, splat(lanes, 0.0))
    n_rows = state.penetration.shape[0]
    for _ in range(MAX_SWEEPS):
        depth, x, change = tile_relax(contact.coupling, n_rows, rows, depth, x, changing)
        sweeps = select(changing, sweeps + splat(lanes, 1.0), sweeps)
        changing, largest = below(limit, change), larger(change, largest)
        if not any_lane(changing):
            break
    tile_scatter(state.multiplier, rows, x)
    return unsettled(lanes, limit, change, largest), sweeps


@compiled
def solve_many(
    lanes: tuple,
    contact: Contact,
    state: State,
    n_active: int,
    limit: np.ndarray,
    changing: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Multipliers of any number of active points, bit for bit as `solve_few`.

    Parameters
    ----------
    lanes, contact, state
        As in `kernel.integrate`.
    n_active : int
        Entries of `State.active` that count.
    limit : ndarray (L,)
        Tolerance of a multiplier or penetration [m].
    changing : ndarray (L,) bool
        Lanes in which anything penetrates.

    Returns
    -------
    unsettled : ndarray (L,) bool
        Lanes that did not converge.
    sweeps : ndarray (L,)
        Sweeps that each lane took.
    """
    n_rows = state.penetration.shape[0]
    sweeps, change, largest = splat(lanes, 0.0), splat(lanes, 0.0), splat(lanes, 0.0)
    for a in range(n_active):
        i = state.active[a]
        store(state.depth, i, load(lanes, state.penetration, i))
        store(state.multiplier, i, splat(lanes, 0.0))
    for _ in range(MAX_SWEEPS):
        change = splat(lanes, 0.0)
        for a in range(n_active):
            j = state.active[a]
            old = load(lanes, state.multiplier, j)
            new = select(changing, positive_part(load(lanes, state.depth, j)), old)
            less = old - new
            change = larger(larger(new - old, less), change)
            store(state.multiplier, j, new)
            for b in range(n_active):
                i = state.active[b]
                effect = load(lanes, contact.coupling, i * n_rows + j)
                if i != j:
                    store(state.depth, i, fma(effect, less, load(lanes, state.depth, i)))
        sweeps = select(changing, sweeps + splat(lanes, 1.0), sweeps)
        changing, largest = below(limit, change), larger(change, largest)
        if not any_lane(changing):
            break
    return unsettled(lanes, limit, change, largest), sweeps


@compiled
def solve_stuck(lanes: tuple, contact: Contact, state: State, n_active: int) -> None:
    """Multipliers of the lanes in ``state.report`` by pivoting, lane by lane (state is modified).

    Only points within the lane's own reach take part: others' would change its rounding.

    Parameters
    ----------
    lanes, contact, state
        As in `kernel.integrate`.
    n_active : int
        Entries of `State.active` that count.
    """
    n_rows = state.penetration.shape[0]
    for lane in range(len(lanes)):
        if state.report[STUCK, lane] == 0.0:
            continue
        depth = state.penetration[:, lane]
        nearest = -contact.reach[0, lane] * depth.max()
        rows = np.array([i for i in state.active[:n_active] if depth[i] > nearest])
        M = np.eye(len(rows))
        for a, i in enumerate(rows):
            for b, j in enumerate(rows):
                M[a, b] += contact.coupling[i * n_rows + j, lane]
        x = np.zeros(len(rows))
        if not solve_by_pivoting(M, depth[rows], x):
            state.report[UNSOLVED, lane] = 1.0
        for i in state.active[:n_active]:
            state.multiplier[i, lane] = 0.0
        for a, i in enumerate(rows):
            state.multiplier[i, lane] = x[a]


@compiled(inline=True)
def solve(lanes: tuple, contact: Contact, state: State, deepest: np.ndarray, n_active: int) -> None:
    """Contact forces of the active points by projected Gauss–Seidel (state is modified).

    Parameters
    ----------
    lanes, contact, state
        As in `kernel.integrate`.
    deepest : ndarray (L,)
        Deepest penetration of the step [m].
    n_active : int
        Entries of `State.active` that count.

    Notes
    -----
    Works on x_j = λ_j W_jj, the depth that contact j alone would undo. A lane that has converged is
    frozen, so that its result does not depend on how long the others take; one that has not after
    MAX_SWEEPS is solved by pivoting.
    """
    limit = positive_part(deepest) * splat(lanes, TOLERANCE)
    changing = below(splat(lanes, 0.0), deepest)
    if n_active <= len(FEW_CONTACTS):
        stuck, sweeps = solve_few(lanes, FEW_CONTACTS, contact, state, limit, changing)
    elif n_active <= len(SOME_CONTACTS):
        stuck, sweeps = solve_few(lanes, SOME_CONTACTS, contact, state, limit, changing)
    elif n_active <= len(MANY_CONTACTS):
        stuck, sweeps = solve_few(lanes, MANY_CONTACTS, contact, state, limit, changing)
    else:
        stuck, sweeps = solve_many(lanes, contact, state, n_active, limit, changing)
    store(state.report, SWEEPS, larger(sweeps, load(lanes, state.report, SWEEPS)))
    if any_lane(stuck):
        store(state.report, STUCK, select(stuck, splat(lanes, 1.0), splat(lanes, 0.0)))
        solve_stuck(lanes, contact, state, n_active)
    for a in range(n_active):
        i = state.active[a]
        force = load(lanes, state.multiplier, i) * load(lanes, contact.stiffness, i)
        store(state.multiplier, i, force)
