"""Passes over the modes: corrector, predictor, penetrations and recorded displacements.

With d = q_n − q_{n−1} all schemes are the same lines (``docs/theory.md`` derives them):

    corrector   d ← d + gain·Gλ,  q ← q + gain·Gλ        forces of the step before
    predictor   d ← decay·d − ω² gain·q,  q ← q + d      no contact force
    gap         p = R q + s b − clearance                penetrations, positive inside

decay and gain are numbers per mode and lane (`recurrence.coefficients`); R holds the normal
displacement of every contact point per unit modal coordinate, G the modal forces of multipliers.
The corrector of a step is applied on the way through the next predictor, so that each step reads
and writes the modal state once. The last rows are pairs of modes of a casing that vibrates
(`model.casing_modes`): ordinary modes whose coordinates turn at the end of a step.

Of disks with many modes and points (`predict_blocks`) all points see a block of modes while its
motion, coefficients and projections are in the first-level cache. The increments of the step before
are kept, because friction follows the slip velocity.
"""

import numpy as np

from hpcrub.contact import lanes as v
from hpcrub.contact.arrays import Bank, Scheme, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import TILE, TIPS

# Points whose forces are found or applied in one pass: the fewer, the faster.
NONE = ()
FEW = (0,) * 4
SOME = (0,) * 8
MANY = (0,) * TILE
BLOCK = 32  # modes whose motion, coefficients and projections the first-level cache holds


@compiled(inline=True, inner=True)
def first_pair(scheme: Scheme) -> int:
    """Row of the first pair of the casing: the number of modes of the disk."""
    return scheme.normal.shape[0] - 2 * scheme.turn.shape[0]


@compiled(inline=True, inner=True)
def open_gap(lanes: tuple, scheme: Scheme, state: State, step: int, first: int) -> tuple:
    """Penetrations of TILE contact points of a disk that does not move, s b − clearance [m].

    first: first contact point.
    """
    depth = v.tile_splat(TIPS, 0.0 - v.load(lanes, scheme.clearance, 0))
    points = v.consecutive(TIPS, first)
    depth = v.tile_add(depth, scheme.own, 0, points, v.splat(lanes, -1.0))
    return v.tile_add(depth, scheme.bump, step, points, v.load(lanes, state.ramp, 0))


@compiled(inline=True, inner=True)
def advanced(
    lanes: tuple, contacts: tuple, scheme: Scheme, state: State, step: int, k: int, columns: tuple,
    forces: tuple,
) -> tuple:  # fmt: skip
    """Corrector of the step before and predictor of this one, for mode k.

    contacts, columns, forces: of the active points to correct.
    Returns position and increment (L,) at the end of this step.
    """
    gain = v.load(lanes, scheme.gain, k)
    q = v.load(lanes, state.position, k)
    d = v.load(lanes, state.increment, k)
    if len(contacts) > 0:
        kick = v.tile_dot(scheme.load, k, columns, forces, v.splat(lanes, 0.0)) * gain
        q = q + kick
        d = d + kick
    d = v.load(lanes, scheme.decay, k) * d - (gain * v.load(lanes, scheme.squared, k)) * q
    if scheme.external.shape[0] > 0:
        d = d + scheme.external[step, k] * gain
    return q + d, d


@compiled(inline=True, inner=True)
def turn_pair(
    lanes: tuple, scheme: Scheme, values: np.ndarray, j: int, c: np.ndarray, s: np.ndarray
) -> tuple:
    """Turn a pair c, s of the casing by the angle of a step, and keep it (values are modified)."""
    cosine, sine = v.splat(lanes, scheme.turn[j, 0]), v.splat(lanes, scheme.turn[j, 1])
    c, s = c * cosine + s * sine, s * cosine - c * sine
    k = first_pair(scheme) + 2 * j
    v.store(values, k, c)
    v.store(values, k + 1, s)
    return c, s


@compiled(inline=True, inner=True)
def predict(lanes: tuple, contacts: tuple, scheme: Scheme, state: State, step: int) -> np.ndarray:
    """Corrector of the step before, predictor of this one (state is modified).

    contacts: as many zeros as there are first active points to correct.
    Returns (L,); deepest penetration of the first TILE contact points [m].
    """
    columns = v.indices(contacts, state.active, 0)
    forces = v.tile_gather(lanes, state.multiplier, columns)
    depth, points = open_gap(lanes, scheme, state, step, 0), v.consecutive(TIPS, 0)
    for k in range(first_pair(scheme)):
        q, d = advanced(lanes, contacts, scheme, state, step, k, columns, forces)
        v.store(state.increment, k, d)
        v.store(state.position, k, q)
        depth = v.tile_add(depth, scheme.normal, k, points, q)
    for j in range(scheme.turn.shape[0]):
        k = first_pair(scheme) + 2 * j
        c, dc = advanced(lanes, contacts, scheme, state, step, k, columns, forces)
        s, ds = advanced(lanes, contacts, scheme, state, step, k + 1, columns, forces)
        c, s = turn_pair(lanes, scheme, state.position, j, c, s)
        turn_pair(lanes, scheme, state.increment, j, dc, ds)
        depth = v.tile_add(depth, scheme.normal, k, points, c)
        depth = v.tile_add(depth, scheme.normal, k + 1, points, s)
    v.tile_store(state.penetration, points, depth)
    return v.tile_largest(depth)


@compiled(inner=True)
def predict_more(lanes: tuple, first: int, scheme: Scheme, state: State, step: int) -> np.ndarray:
    """Penetrations of one more tile of contact points (state is modified).

    first: first contact point of the tile.
    Returns (L,); deepest of these penetrations [m].
    """
    depth, points = open_gap(lanes, scheme, state, step, first), v.consecutive(TIPS, first)
    for k in range(state.position.shape[0]):
        depth = v.tile_add(depth, scheme.normal, k, points, v.load(lanes, state.position, k))
    v.tile_store(state.penetration, points, depth)
    return v.tile_largest(depth)


@compiled(inline=True, inner=True)
def penetrate(
    lanes: tuple, scheme: Scheme, state: State, first: int, begin: int, end: int
) -> tuple:
    """Add what some rows of the modes do to a tile of penetrations (state is modified).

    first: first contact point of the tile.
    begin, end: the rows.
    Returns the penetrations (TILE, L) [m].
    """
    points = v.consecutive(TIPS, first)
    depth = v.tile_gather(lanes, state.penetration, points)
    for k in range(begin, end):
        depth = v.tile_add(depth, scheme.normal, k, points, v.load(lanes, state.position, k))
    v.tile_store(state.penetration, points, depth)
    return depth


@compiled(inner=True)
def correct(lanes: tuple, scheme: Scheme, state: State, n_active: int) -> None:
    """Corrector by itself, for any number of active points (state is modified)."""
    if n_active == 0:
        return
    for k in range(state.position.shape[0]):
        kick = v.splat(lanes, 0.0)
        for first in range(0, n_active, TILE):
            columns = v.indices(MANY, state.active, first)
            forces = v.tile_gather(lanes, state.multiplier, columns)
            kick = v.tile_dot(scheme.load, k, columns, forces, kick)
        kick = kick * v.load(lanes, scheme.gain, k)
        v.store(state.position, k, v.load(lanes, state.position, k) + kick)
        v.store(state.increment, k, v.load(lanes, state.increment, k) + kick)


@compiled(inline=True, inner=True)
def settle(lanes: tuple, contacts: tuple, scheme: Scheme, state: State) -> tuple:
    """Corrector by itself, for a few active points (state is modified).

    contacts: as many zeros as there are first active points to correct.
    Returns (L,); first TILE observed displacements [m].
    """
    columns = v.indices(contacts, state.active, 0)
    forces = v.tile_gather(lanes, state.multiplier, columns)
    seen, points = v.tile_splat(TIPS, v.splat(lanes, 0.0)), v.consecutive(TIPS, 0)
    for k in range(state.position.shape[0]):
        q = v.load(lanes, state.position, k)
        if len(contacts) > 0:
            kick = v.tile_dot(scheme.load, k, columns, forces, v.splat(lanes, 0.0))
            kick = kick * v.load(lanes, scheme.gain, k)
            q = q + kick
            v.store(state.position, k, q)
            v.store(state.increment, k, v.load(lanes, state.increment, k) + kick)
        seen = v.tile_add(seen, scheme.observed, k, points, q)
    return seen


@compiled(inner=True)
def add_forces(lanes: tuple, slots: tuple, bank: Bank, first: int, begin: int, end: int) -> None:
    """Modal forces of some active points (state.before, modified).

    slots: as many zeros as there are points.
    first: place of the first of them in `State.active`; 0 to begin the sum.
    """
    scheme, state = bank.scheme, bank.state
    columns = v.indices(slots, state.active, first)
    forces = v.tile_gather(lanes, state.multiplier, columns)
    for k in range(begin, end):
        total = v.splat(lanes, 0.0)
        if first > 0:
            total = v.load(lanes, state.before, k)
        v.store(state.before, k, v.tile_dot(scheme.load, k, columns, forces, total))


@compiled(inner=True)
def advance_modes(lanes: tuple, bank: Bank, step: int, n_active: int, begin: int, end: int) -> None:
    """Corrector and predictor of some modes (state is modified).

    On entry ``state.before`` holds the modal forces, if there are any (n_active), on return the
    increments of the step before.
    """
    scheme, state = bank.scheme, bank.state
    loaded = scheme.external.shape[0] > 0
    for k in range(begin, end):
        gain = v.load(lanes, scheme.gain, k)
        q, d = v.load(lanes, state.position, k), v.load(lanes, state.increment, k)
        if n_active > 0:
            kick = v.load(lanes, state.before, k) * gain
            q, d = q + kick, d + kick
        v.store(state.before, k, d)
        d = v.load(lanes, scheme.decay, k) * d - (gain * v.load(lanes, scheme.squared, k)) * q
        if loaded:
            d = d + scheme.external[step, k] * gain
        v.store(state.increment, k, d)
        v.store(state.position, k, q + d)


@compiled(inline=True, inner=True)
def advance(lanes: tuple, bank: Bank, step: int, n_active: int, begin: int, end: int) -> None:
    """Corrector and predictor of some modes, for any number of active points (bank is modified)."""
    for first in range(0, n_active, TILE):
        if n_active - first <= len(FEW):
            add_forces(lanes, FEW, bank, first, begin, end)
        elif n_active - first <= len(SOME):
            add_forces(lanes, SOME, bank, first, begin, end)
        else:
            add_forces(lanes, MANY, bank, first, begin, end)
    advance_modes(lanes, bank, step, n_active, begin, end)


@compiled(inner=True)
def advance_pairs(lanes: tuple, bank: Bank, step: int, n_active: int) -> None:
    """Corrector and predictor of the casing, whose coordinates then turn (bank is modified)."""
    scheme, state = bank.scheme, bank.state
    begin, end = first_pair(scheme), scheme.normal.shape[0]
    advance(lanes, bank, step, n_active, begin, end)
    for j in range(scheme.turn.shape[0]):
        for values in (state.position, state.increment):
            c = v.load(lanes, values, begin + 2 * j)
            turn_pair(lanes, scheme, values, j, c, v.load(lanes, values, begin + 2 * j + 1))


@compiled(inline=True, inner=True)
def predict_all(lanes: tuple, bank: Bank, step: int, n_active: int) -> np.ndarray:
    """The narrowest pass that holds the active points, then the other tiles (state is modified).

    Returns (L,); deepest penetration of all contact points [m].
    """
    scheme, state = bank.scheme, bank.state
    if n_active > len(MANY):
        correct(lanes, scheme, state, n_active)
        n_active = 0
    if n_active == 0:
        deepest = predict(lanes, NONE, scheme, state, step)
    elif n_active <= len(FEW):
        deepest = predict(lanes, FEW, scheme, state, step)
    elif n_active <= len(SOME):
        deepest = predict(lanes, SOME, scheme, state, step)
    else:
        deepest = predict(lanes, MANY, scheme, state, step)
    for first in range(TILE, state.penetration.shape[0] - 1, TILE):
        deepest = v.larger(predict_more(lanes, first, scheme, state, step), deepest)
    return deepest


@compiled(inner=True)
def predict_blocks(lanes: tuple, bank: Bank, step: int, n_active: int) -> np.ndarray:
    """Corrector of the step before, predictor and penetrations of this one (bank is modified).

    Returns (L,); deepest penetration of all contact points [m].
    """
    scheme, state = bank.scheme, bank.state
    n_modes, n_points = scheme.normal.shape
    n_disk = first_pair(scheme)
    deepest = v.splat(lanes, -np.inf)
    for first in range(0, n_points, TILE):
        points = v.consecutive(TIPS, first)
        v.tile_store(state.penetration, points, open_gap(lanes, scheme, state, step, first))
    for begin in range(0, n_disk, BLOCK):
        end = min(begin + BLOCK, n_disk)
        advance(lanes, bank, step, n_active, begin, end)
        for first in range(0, n_points, TILE):
            depth = penetrate(lanes, scheme, state, first, begin, end)
            if end == n_modes:
                deepest = v.larger(v.tile_largest(depth), deepest)
    if n_disk < n_modes:
        advance_pairs(lanes, bank, step, n_active)
        for first in range(0, n_points, TILE):
            depth = penetrate(lanes, scheme, state, first, n_disk, n_modes)
            deepest = v.larger(v.tile_largest(depth), deepest)
    return deepest
