"""Corrector, predictor and penetrations of disks with many modes and points, block by block.

The same arithmetic as `passes.predict_all`, ordered so that all contact points see a block of modes
while its motion, coefficients and projections are in the first-level cache. The increments of the
step before are kept, because friction follows the slip velocity.
"""

from typing import Any

import numpy as np

from hpcrub.contact.arrays import Bank, Scheme, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import (
    TILE,
    TIPS,
    consecutive,
    indices,
    larger,
    load,
    splat,
    store,
    tile_add,
    tile_dot,
    tile_gather,
    tile_largest,
    tile_store,
)
from hpcrub.contact.passes import FEW, MANY, SOME, open_gap

BLOCK = 32  # modes whose motion, coefficients and projections the first-level cache holds


@compiled(inner=True)
def add_forces(
    lanes: tuple,
    slots: tuple,
    scheme: Scheme,
    state: State,
    law: Any,
    first: int,
    begin: int,
    end: int,
) -> None:
    """Modal forces of some active points (law.before, modified).

    slots: as many zeros as there are points.
    first: place of the first of them in `State.active`; 0 to begin the sum.
    """
    columns = indices(slots, state.active, first)
    forces = tile_gather(lanes, state.multiplier, columns)
    for k in range(begin, end):
        total = splat(lanes, 0.0)
        if first > 0:
            total = load(lanes, law.before, k)
        store(law.before, k, tile_dot(scheme.load, k, columns, forces, total))


@compiled(inner=True)
def advance_modes(
    lanes: tuple,
    scheme: Scheme,
    state: State,
    law: Any,
    step: int,
    n_active: int,
    begin: int,
    end: int,
) -> None:
    """Corrector and predictor of some modes (state, law.before are modified).

    lanes, scheme, state, law: as in `integrate.integrate`; ``before`` holds the modal forces on
        entry, if there are any, and the increments of the step before on return.
    n_active: zero where there are no forces.
    """
    loaded = scheme.external.shape[0] > 0
    for k in range(begin, end):
        gain = load(lanes, scheme.gain, k)
        q, d = load(lanes, state.position, k), load(lanes, state.increment, k)
        if n_active > 0:
            kick = load(lanes, law.before, k) * gain
            q, d = q + kick, d + kick
        store(law.before, k, d)
        d = load(lanes, scheme.decay, k) * d - (gain * load(lanes, scheme.squared, k)) * q
        if loaded:
            d = d + scheme.external[step, k] * gain
        store(state.increment, k, d)
        store(state.position, k, q + d)


@compiled(inner=True)
def predict_blocks(lanes: tuple, bank: Bank, step: int, n_active: int) -> np.ndarray:
    """Corrector of the step before, predictor and penetrations of this one (bank is modified).

    Block by block of modes, so that all points see a mode while it is in the cache.

    Returns (L,); deepest penetration of all contact points [m].
    """
    scheme, state, law = bank.scheme, bank.state, bank.law
    n_modes, n_points = scheme.normal.shape
    deepest = splat(lanes, -np.inf)
    for first in range(0, n_points, TILE):
        points = consecutive(TIPS, first)
        tile_store(state.penetration, points, open_gap(lanes, scheme, state, step, first))
    for begin in range(0, n_modes, BLOCK):
        end = min(begin + BLOCK, n_modes)
        for first in range(0, n_active, TILE):
            if n_active - first <= len(FEW):
                add_forces(lanes, FEW, scheme, state, law, first, begin, end)
            elif n_active - first <= len(SOME):
                add_forces(lanes, SOME, scheme, state, law, first, begin, end)
            else:
                add_forces(lanes, MANY, scheme, state, law, first, begin, end)
        advance_modes(lanes, scheme, state, law, step, n_active, begin, end)
        for first in range(0, n_points, TILE):
            points = consecutive(TIPS, first)
            depth = tile_gather(lanes, state.penetration, points)
            for k in range(begin, end):
                depth = tile_add(depth, scheme.normal, k, points, load(lanes, state.position, k))
            tile_store(state.penetration, points, depth)
            if end == n_modes:
                deepest = larger(tile_largest(depth), deepest)
    return deepest
