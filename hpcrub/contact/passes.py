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
(`model.casing_modes`), ordinary modes whose coordinates turn at the end of a step. A force acts at
the begin of its step, so that what it adds to a pair turns with the pair.

Here is what all modes share; the order of the passes is that of a basis, `dense` or `cyclic`. All
sums run in the order of the points or modes.
"""

from typing import Any

import numpy as np

from hpcrub.contact import lanes as v
from hpcrub.contact.arrays import Bank, Scheme, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import PAIR, TIPS


@compiled(inline=True, inner=True)
def first_pair(scheme: Scheme) -> int:
    """Row of the first pair, which is the number of real modes of the disk."""
    return scheme.decay.shape[0] - scheme.turn.shape[0]


@compiled(inline=True, inner=True)
def turned(lanes: tuple, scheme: Scheme, k: int, c: np.ndarray, s: np.ndarray) -> tuple:
    """Turn a pair c, s by the angle of a step; k: row of c."""
    j = k - first_pair(scheme)
    cosine, sine = v.load(lanes, scheme.turn, j), v.load(lanes, scheme.turn, j + 1)
    return c * cosine + s * sine, s * cosine - c * sine


@compiled(inline=True, inner=True)
def modal_forces(
    lanes: tuple, tile: tuple, scheme: Scheme, state: State, n_active: int, first: int
) -> tuple:
    """Modal forces of the active points on a tile of modes [N/√kg]; first: first mode."""
    modes, total = v.consecutive(tile, first), v.tile_splat(tile, v.splat(lanes, 0.0))
    for a in range(n_active):
        j = state.active[a]
        total = v.tile_add(total, scheme.load, j, modes, v.load(lanes, state.multiplier, j))
    return total


@compiled(inline=True, inner=True)
def resting(
    lanes: tuple, tile: tuple, scheme: Scheme, state: State, step: int, points: tuple
) -> tuple:
    """Penetrations of a tile of contact points of a disk at rest, s b − clearance [m].

    They are minus `CasingShape.gap`.
    """
    depth = v.tile_splat(tile, 0.0 - v.load(lanes, scheme.clearance, 0))
    depth = v.tile_add(depth, scheme.point_clearance, 0, points, v.splat(lanes, -1.0))
    return v.tile_add(depth, scheme.bump, step, points, v.load(lanes, state.ramp, 0))


@compiled(inline=True, inner=True)
def pair_of_forces(
    lanes: tuple, scheme: Scheme, state: State, n_active: int, k: int
) -> tuple[np.ndarray, np.ndarray]:
    """Modal forces (L,) of the active points on the pair in rows k and k + 1, turned [N/√kg]."""
    c, s = modal_forces(lanes, PAIR, scheme, state, n_active, k)
    return turned(lanes, scheme, k, c, s)


@compiled(inline=True, inner=True)
def advance_wave(
    lanes: tuple, scheme: Scheme, state: State, force: tuple, external: Any, step: int, k: int,
    late: Any,
) -> None:  # fmt: skip
    """Corrector and predictor of a complex mode in rows k and k + 1 (state is modified).

    force: pair of modal forces of the step before, turned (L,) [N/√kg].
    external: `Scheme.external`, an argument because only then its type chooses the code.
    late: pair of modal forces that the predictor adds (L,), or None.
    """
    v.tile_advance(force, k, state, scheme, state.increment_before, None, None, None)
    gain, decay = v.load(lanes, scheme.gain, k), v.load(lanes, scheme.decay, k)
    a, b = v.load(lanes, state.position, k), v.load(lanes, state.position, k + 1)
    re, im = turned(lanes, scheme, k, decay * a, decay * b)
    if external is not None:
        x, y = turned(lanes, scheme, k, external[step, k] * gain, external[step, k + 1] * gain)
        re, im = re + x, im + y
    if late is not None:
        x, y = turned(lanes, scheme, k, late[0] * gain, late[1] * gain)
        re, im = re + x, im + y
    v.store(state.increment, k, re - a)
    v.store(state.increment, k + 1, im - b)
    v.store(state.position, k, re)
    v.store(state.position, k + 1, im)


@compiled(inline=True, inner=True)
def turn_pair(lanes: tuple, scheme: Scheme, values: np.ndarray, k: int) -> None:
    """Turn the casing's pair in rows k and k + 1 of an array (modified)."""
    c, s = turned(lanes, scheme, k, v.load(lanes, values, k), v.load(lanes, values, k + 1))
    v.store(values, k, c)
    v.store(values, k + 1, s)


@compiled(inline=True, inner=True)
def advance_ring(
    lanes: tuple, scheme: Scheme, state: State, force: tuple, step: int, k: int
) -> None:
    """Corrector and predictor of the casing's pair in rows k and k + 1 (state is modified).

    force: as in `advance_wave`.
    """
    v.tile_advance(force, k, state, scheme, state.increment_before, None, step, None)
    turn_pair(lanes, scheme, state.increment, k)
    turn_pair(lanes, scheme, state.position, k)


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
    return bank.basis.predict(lanes, bank, step, n_active)
