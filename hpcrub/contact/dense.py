"""Dense basis: the modes of one disk, which move every contact point.

It serves planar disks, and disks that do not repeat themselves from blade to blade. The other basis
is `cyclic`.

The modes are taken in blocks, whose motion and coefficients stay in the first-level cache. A block
needs two passes: its modes, a tile at a time, whose modal forces Gλ stay in registers; then its
part in the penetrations, a tile of points at a time.
"""

from typing import Any

import numpy as np

from hpcrub.contact import lanes as v
from hpcrub.contact.arrays import Bank, NoArrays, Scheme, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import BLOCK, ONE, PAIR, TILE, TIPS
from hpcrub.contact.passes import (
    advance_ring,
    advance_wave,
    first_pair,
    modal_forces,
    pair_of_forces,
    project,
    resting,
)
from hpcrub.contact.protocols import Scene
from hpcrub.contact.tables import columns
from hpcrub.model.reduction import Modes

PER_MODE = 8  # products and loads of the recurrence of one mode


@compiled(inline=True, inner=True)
def end_of_block(scheme: Scheme, begin: int) -> int:
    """End of the block that begins at a row: of real modes, complex modes or casing pairs."""
    n_modes = scheme.decay.shape[0]
    end = n_modes
    if begin < first_pair(scheme):
        end = first_pair(scheme)
    elif begin < n_modes - scheme.casing:
        end = n_modes - scheme.casing
    return min(begin + BLOCK, end)


@compiled(inline=True, inner=True)
def late_forces(lanes: tuple, tile: tuple, late: np.ndarray, push: np.ndarray, first: int) -> Any:
    """Modal forces of bent modes on each other on a tile of modes from ``first`` on.

    late, push: `State.late` and `Scheme.push`.
    """
    modes, total = v.consecutive(tile, first), v.tile_splat(tile, v.splat(lanes, 0.0))
    for row in range(push.shape[0]):
        total = v.tile_add(total, push, row, modes, v.load(lanes, late, row))
    return total


@compiled(inline=True, inner=True)
def advance_tiles(
    lanes: tuple, tile: tuple, scheme: Scheme, state: State, before: Any, step: int | None,
    n_active: int, begin: int, end: int, late: Any,
) -> None:  # fmt: skip
    """Corrector and predictor of whole tiles of real modes (state is modified).

    before, step: as in `lanes.tile_advance`.
    late: `State.late`, an argument because only then its type chooses the code.
    """
    for first in range(begin, end, len(tile)):
        force = modal_forces(lanes, tile, scheme, state, n_active, first)
        if late is None:
            v.tile_advance(force, first, state, scheme, before, scheme.external, step, None)
        else:
            added = late_forces(lanes, tile, late, scheme.push, first)
            v.tile_advance(force, first, state, scheme, before, scheme.external, step, added)


@compiled(inline=True, inner=True)
def advance_waves(
    lanes: tuple, scheme: Scheme, state: State, step: int, n_active: int, begin: int, end: int,
    late: Any,
) -> None:  # fmt: skip
    """Corrector and predictor of complex modes (state is modified); late: as in `advance_tiles`."""
    for k in range(begin, end, 2):
        force = pair_of_forces(lanes, scheme, state, n_active, k)
        if late is None:
            advance_wave(lanes, scheme, state, force, scheme.external, step, k, None)
        else:
            added = late_forces(lanes, PAIR, late, scheme.push, k)
            advance_wave(lanes, scheme, state, force, scheme.external, step, k, added)


@compiled(inline=True, inner=True)
def advance(
    lanes: tuple, scheme: Scheme, state: State, step: int, n_active: int, begin: int, end: int
) -> None:
    """Corrector and predictor of a block of modes (state is modified)."""
    if begin < first_pair(scheme):
        before, whole = state.increment_before, end - (end - begin) % TILE
        late = state.late
        advance_tiles(lanes, TIPS, scheme, state, before, step, n_active, begin, whole, late)
        advance_tiles(lanes, ONE, scheme, state, before, step, n_active, whole, end, late)
    elif begin < scheme.decay.shape[0] - scheme.casing:
        advance_waves(lanes, scheme, state, step, n_active, begin, end, state.late)
    else:
        for k in range(begin, end, 2):
            force = pair_of_forces(lanes, scheme, state, n_active, k)
            advance_ring(lanes, scheme, state, force, step, k)


@compiled(inline=True, inner=True)
def begin_gaps(
    lanes: tuple, scheme: Scheme, state: State, step: int, first: int, begin: int
) -> tuple:
    """Penetrations of a tile of contact points before a block of modes is added [m].

    first: first contact point; begin: first mode of the block.
    """
    points = v.consecutive(TIPS, first)
    if begin > 0:
        return v.load(lanes, state.penetration, points)
    return resting(lanes, TIPS, scheme, state, step, points)


@compiled(inline=True, inner=True)
def move(lanes: tuple, table: np.ndarray, position: np.ndarray, moved: np.ndarray) -> None:
    """Displacements of the rows of a table at modal coordinates (moved is modified)."""
    for first in range(0, table.shape[1], TILE):
        tile = v.tile_splat(TIPS, v.splat(lanes, 0.0))
        tile = project(lanes, table, position, first, 0, position.shape[0], tile)
        v.store(moved, v.consecutive(TIPS, first), tile)


class Dense(NoArrays):
    """The dense basis, all in `Scheme`; `cyclic.Cyclic` has the same methods."""

    @staticmethod
    def cost(modes: Modes) -> float:
        """Products of a step of one lane without contact."""
        return len(modes.omega) * (PER_MODE + columns(modes.normal).shape[1])

    def fill(self, bank: Bank, lane: int, modes: Modes, scene: Scene) -> None:
        """Nothing depends on the lane."""

    def start(self, bank: Bank, lanes: Any) -> None:
        """Find the bent modes in the step before of lanes that do not start at rest (modified)."""
        if bank.state.before is not None:
            before = (bank.state.position - bank.state.increment)[:, lanes]
            bent = bank.scheme.bent.T @ before
            bank.state.before[:, lanes] = bent[: len(bank.state.before)]

    @staticmethod
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
            advance(lanes, scheme, state, step, n_active, begin, end)
            for first in range(0, n_points, TILE):
                depth = begin_gaps(lanes, scheme, state, step, first, begin)
                depth = project(lanes, scheme.normal, state.position, first, begin, end, depth)
                v.store(state.penetration, v.consecutive(TIPS, first), depth)
                deepest = v.larger(v.tile_largest(depth), deepest) if end == n_modes else deepest
            begin = end
        return deepest

    @staticmethod
    @compiled(inline=True, inner=True)
    def correct(lanes: tuple, bank: Bank, n_active: int) -> None:
        """Corrector of all modes without a predictor (bank is modified)."""
        scheme, state = bank.scheme, bank.state
        if n_active == 0:
            return
        n_real = first_pair(scheme)
        whole = n_real - n_real % TILE
        advance_tiles(lanes, TIPS, scheme, state, None, None, n_active, 0, whole, None)
        advance_tiles(lanes, ONE, scheme, state, None, None, n_active, whole, n_real, None)
        for k in range(n_real, state.position.shape[0], 2):
            force = pair_of_forces(lanes, scheme, state, n_active, k)
            v.tile_advance(force, k, state, scheme, None, None, None, None)

    @staticmethod
    @compiled(inline=True, inner=True)
    def displace(lanes: tuple, bank: Bank, bent: Any) -> None:
        """Find the tangential motion of all points, and the bent modes of all blades.

        bent: `laws.bent.Bent`, whose ``along`` and ``bent`` are modified.
        """
        move(lanes, bank.law.tangential, bank.state.position, bent.along)
        move(lanes, bank.scheme.bent, bank.state.position, bent.bent)

    @staticmethod
    @compiled(inline=True, inner=True)
    def look(lanes: tuple, bank: Bank) -> None:
        """Nothing is needed before `seen`."""

    @staticmethod
    @compiled(inline=True, inner=True)
    def seen(lanes: tuple, bank: Bank, first: int) -> tuple:
        """Observed displacements of a tile of rows from ``first`` on [m]."""
        scheme, tile = bank.scheme, v.tile_splat(TIPS, v.splat(lanes, 0.0))
        n_disk = scheme.observed.shape[0] - scheme.casing
        return project(lanes, scheme.observed, bank.state.position, first, 0, n_disk, tile)
