"""Passes over the modes: corrector, predictor, penetrations and recorded displacements.

With d = q_n − q_{n−1} all schemes are the same lines (``docs/theory.md`` derives them):

    corrector   d ← d + gain·Gλ,  q ← q + gain·Gλ        forces of the step before
    predictor   d ← decay·d − ω² gain·q,  q ← q + d      no contact force
    gap         p = R q + s b − clearance                penetrations, positive inside

decay and gain are numbers per mode and lane (`recurrence.coefficients`); R holds the normal
displacement of every contact point per unit modal coordinate, G the modal forces of multipliers.
The next predictor also applies the corrector of a step, so that each step reads and writes the
modal state once. The last rows are pairs: Re z and Im z of complex modes of a disk in air
(`model.aero`), z ← e^{λh} (z + h Gλ), and pairs of modes of a casing that vibrates
(`model.casing_modes`), ordinary modes whose coordinates turn at the end of a step.

The modes are taken in blocks, whose motion and coefficients stay in the first-level cache. A block
needs three passes: its modal forces Gλ, a tile of modes at a time; its modes, with the first tile
of contact points; the other points. All sums run in the order of the points or modes.
"""

import numpy as np

from hpcrub.contact import lanes as v
from hpcrub.contact.arrays import Bank, Scheme, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import BESIDE_MODES, BLOCK, TILE, TIPS


@compiled(inline=True, inner=True)
def first_pair(scheme: Scheme) -> int:
    """Row of the first pair, which is the number of real modes of the disk."""
    return scheme.normal.shape[0] - scheme.turn.shape[0]


@compiled(inline=True, inner=True)
def end_of_block(scheme: Scheme, begin: int) -> int:
    """End of the block that begins at a row: of real modes, complex modes or casing pairs."""
    n_modes = scheme.normal.shape[0]
    end = n_modes
    if begin < first_pair(scheme):
        end = first_pair(scheme)
    elif begin < n_modes - scheme.casing:
        end = n_modes - scheme.casing
    return min(begin + BLOCK, end)


@compiled(inline=True, inner=True)
def turned(lanes: tuple, scheme: Scheme, k: int, c: np.ndarray, s: np.ndarray) -> tuple:
    """Turn a pair c, s by the angle of a step; k: row of c."""
    j = k - first_pair(scheme)
    cosine, sine = v.load(lanes, scheme.turn, j), v.load(lanes, scheme.turn, j + 1)
    return c * cosine + s * sine, s * cosine - c * sine


@compiled(inline=True, inner=True)
def sum_forces(
    lanes: tuple, scheme: Scheme, state: State, n_active: int, begin: int, end: int
) -> None:
    """Sum the modal forces of the active points on a block of modes (state.force, modified)."""
    for first in range(begin, end if n_active > 0 else begin, TILE):
        modes, total = v.consecutive(TIPS, first), v.tile_splat(TIPS, v.splat(lanes, 0.0))
        for a in range(n_active):
            j = state.active[a]
            total = v.tile_add(total, scheme.load, j, modes, v.load(lanes, state.multiplier, j))
        v.tile_store(state.force, v.consecutive(TIPS, first - begin), total)
    if n_active > 0 and first_pair(scheme) <= begin < scheme.normal.shape[0] - scheme.casing:
        for k in range(begin, end, 2):  # a force on a complex mode acts along e^{λh}
            at = k - begin
            re, im = v.load(lanes, state.force, at), v.load(lanes, state.force, at + 1)
            re, im = turned(lanes, scheme, k, re, im)
            v.store(state.force, at, re)
            v.store(state.force, at + 1, im)


@compiled(inline=True, inner=True)
def begin_gaps(
    lanes: tuple, scheme: Scheme, state: State, step: int, first: int, begin: int
) -> tuple:
    """Penetrations of a tile of contact points before a block of modes is added [m].

    Before the first mode they are s b − clearance, the penetrations of a disk at rest.

    first: first contact point; begin: first mode of the block.
    """
    points = v.consecutive(TIPS, first)
    if begin > 0:
        return v.tile_gather(lanes, state.penetration, points)
    depth = v.tile_splat(TIPS, 0.0 - v.load(lanes, scheme.clearance, 0))
    depth = v.tile_add(depth, scheme.own, 0, points, v.splat(lanes, -1.0))
    return v.tile_add(depth, scheme.bump, step, points, v.load(lanes, state.ramp, 0))


@compiled(inline=True, inner=True)
def corrected(
    lanes: tuple, scheme: Scheme, state: State, n_active: int, begin: int, k: int
) -> tuple:
    """Position and increment (L,) of row k after the corrector (state.before is modified).

    n_active: active points to correct, whose forces on the block from ``begin`` on are summed.
    """
    q, d = v.load(lanes, state.position, k), v.load(lanes, state.increment, k)
    if n_active > 0:
        kick = v.load(lanes, state.force, k - begin) * v.load(lanes, scheme.gain, k)
        q, d = q + kick, d + kick
    if state.before.shape[0] > 0:
        v.store(state.before, k, d)
    return q, d


@compiled(inline=True, inner=True)
def advanced(
    lanes: tuple, scheme: Scheme, state: State, step: int, n_active: int, begin: int, k: int
) -> tuple:
    """Position and increment (L,) of mode k after `corrected` and the predictor of this step."""
    q, d = corrected(lanes, scheme, state, n_active, begin, k)
    gain = v.load(lanes, scheme.gain, k)
    d = v.load(lanes, scheme.decay, k) * d - (gain * v.load(lanes, scheme.squared, k)) * q
    if scheme.external.shape[0] > 0:
        d = d + scheme.external[step, k] * gain
    return q + d, d


@compiled(inline=True, inner=True)
def advance_wave(
    lanes: tuple, scheme: Scheme, state: State, step: int, n_active: int, begin: int, k: int
) -> tuple:
    """Corrector and predictor of a complex mode in rows k and k + 1 (state is modified).

    Returns Re z and Im z (L,) at the end of this step.
    """
    gain, decay = v.load(lanes, scheme.gain, k), v.load(lanes, scheme.decay, k)
    a, _ = corrected(lanes, scheme, state, n_active, begin, k)
    b, _ = corrected(lanes, scheme, state, n_active, begin, k + 1)
    re, im = turned(lanes, scheme, k, decay * a, decay * b)
    if scheme.external.shape[0] > 0:
        x = scheme.external[step, k] * gain
        y = scheme.external[step, k + 1] * gain
        x, y = turned(lanes, scheme, k, x, y)
        re, im = re + x, im + y
    v.store(state.increment, k, re - a)
    v.store(state.increment, k + 1, im - b)
    v.store(state.position, k, re)
    v.store(state.position, k + 1, im)
    return re, im


@compiled(inline=True, inner=True)
def turn_pair(
    lanes: tuple, scheme: Scheme, values: np.ndarray, k: int, c: np.ndarray, s: np.ndarray
) -> tuple:
    """Turn a pair c, s of the casing, and store it in rows k and k + 1 of values (modified)."""
    c, s = turned(lanes, scheme, k, c, s)
    v.store(values, k, c)
    v.store(values, k + 1, s)
    return c, s


@compiled(inline=True, inner=True)
def advance_real(
    lanes: tuple, scheme: Scheme, state: State, step: int, n_active: int, begin: int, end: int,
    depth: tuple,
) -> tuple:  # fmt: skip
    """`advance` for a block of real modes."""
    points = v.consecutive(TIPS, 0)
    for k in range(begin, end):
        q, d = advanced(lanes, scheme, state, step, n_active, begin, k)
        v.store(state.increment, k, d)
        v.store(state.position, k, q)
        if BESIDE_MODES:
            depth = v.tile_add(depth, scheme.normal, k, points, q)
    return depth


@compiled(inline=True, inner=True)
def advance_pairs(
    lanes: tuple, scheme: Scheme, state: State, step: int, n_active: int, begin: int, end: int,
    depth: tuple,
) -> tuple:  # fmt: skip
    """`advance` for a block of pairs of rows: complex modes, or pairs of the casing."""
    points, complex_modes = v.consecutive(TIPS, 0), begin < scheme.normal.shape[0] - scheme.casing
    for k in range(begin, end, 2):
        if complex_modes:
            a, b = advance_wave(lanes, scheme, state, step, n_active, begin, k)
        else:
            a, da = advanced(lanes, scheme, state, step, n_active, begin, k)
            b, db = advanced(lanes, scheme, state, step, n_active, begin, k + 1)
            turn_pair(lanes, scheme, state.increment, k, da, db)
            a, b = turn_pair(lanes, scheme, state.position, k, a, b)
        if BESIDE_MODES:
            depth = v.tile_add(depth, scheme.normal, k, points, a)
            depth = v.tile_add(depth, scheme.normal, k + 1, points, b)
    return depth


@compiled(inline=True, inner=True)
def advance(
    lanes: tuple, scheme: Scheme, state: State, step: int, n_active: int, begin: int, end: int,
    depth: tuple,
) -> tuple:  # fmt: skip
    """Corrector and predictor of a block of modes (state is modified).

    depth: penetrations of the first tile of contact points [m].
    Returns depth, with the block added where registers have room for the sums beside the modes.
    """
    if begin >= first_pair(scheme):
        return advance_pairs(lanes, scheme, state, step, n_active, begin, end, depth)
    # Each branch compiles a loop over the modes without the tests whose answer the branch knows.
    if scheme.external.shape[0] > 0 or state.before.shape[0] > 0:
        return advance_real(lanes, scheme, state, step, n_active, begin, end, depth)
    if n_active > 0 or BESIDE_MODES:  # beside the sums a third loop is no faster
        return advance_real(lanes, scheme, state, step, n_active, begin, end, depth)
    return advance_real(lanes, scheme, state, step, 0, begin, end, depth)


@compiled(inline=True, inner=True)
def project(
    lanes: tuple, matrix: np.ndarray, position: np.ndarray, first: int, begin: int, end: int,
    tile: tuple,
) -> tuple:  # fmt: skip
    """Add the displacements by a block of modes to a tile of rows.

    matrix: (K, n) displacement of each row per unit modal coordinate; first: row of the tile.
    position: (K, L) modal coordinates.
    """
    rows = v.consecutive(TIPS, first)
    for k in range(begin, end):
        tile = v.tile_add(tile, matrix, k, rows, v.load(lanes, position, k))
    return tile


@compiled(inline=True, inner=True)
def predict(lanes: tuple, bank: Bank, step: int, n_active: int) -> np.ndarray:
    """Corrector of the step before, predictor and penetrations of this step (bank is modified).

    Returns the deepest penetration of all contact points (L,) [m].
    """
    scheme, state = bank.scheme, bank.state
    n_modes, n_points = scheme.normal.shape
    deepest, begin = v.splat(lanes, -np.inf), 0
    while begin < n_modes:
        end = end_of_block(scheme, begin)
        sum_forces(lanes, scheme, state, n_active, begin, end)
        depth = begin_gaps(lanes, scheme, state, step, 0, begin)
        depth = advance(lanes, scheme, state, step, n_active, begin, end, depth)
        for first in range(0, n_points, TILE):
            if first > 0 or not BESIDE_MODES:
                depth = begin_gaps(lanes, scheme, state, step, first, begin)
                depth = project(lanes, scheme.normal, state.position, first, begin, end, depth)
            v.tile_store(state.penetration, v.consecutive(TIPS, first), depth)
            deepest = v.larger(v.tile_largest(depth), deepest) if end == n_modes else deepest
        begin = end
    return deepest


@compiled(inline=True, inner=True)
def correct(lanes: tuple, scheme: Scheme, state: State, n_active: int) -> None:
    """Corrector of all modes without a predictor (state is modified)."""
    begin = 0
    while begin < state.position.shape[0] and n_active > 0:
        end = end_of_block(scheme, begin)
        sum_forces(lanes, scheme, state, n_active, begin, end)
        for k in range(begin, end):
            kick = v.load(lanes, state.force, k - begin) * v.load(lanes, scheme.gain, k)
            v.store(state.position, k, v.load(lanes, state.position, k) + kick)
            v.store(state.increment, k, v.load(lanes, state.increment, k) + kick)
        begin = end
