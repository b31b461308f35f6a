"""Dense basis: the modes of one disk, which move every contact point.

It serves planar disks, and disks that do not repeat themselves from blade to blade. The other basis
is `cyclic`.
"""

from typing import Any, NamedTuple

import numpy as np

from hpcrub.contact import lanes as v
from hpcrub.contact.arrays import Bank, Scheme, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import TILE, TIPS
from hpcrub.contact.passes import advance, correct_modes, end_of_block, project, resting
from hpcrub.contact.tables import columns
from hpcrub.model.reduction import Modes

PER_MODE = 8  # products and loads of the recurrence of one mode


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


class NoArrays(NamedTuple):
    """The arrays of the dense basis: none beside those of `arrays.Scheme`."""


class Dense(NoArrays):
    """The dense basis; `cyclic.Cyclic` has the same methods."""

    @staticmethod
    def per_lane() -> tuple[str, ...]:
        """Names of arrays: none."""
        return ()

    @staticmethod
    def cost(modes: Modes) -> float:
        """Products of a step of one lane without contact."""
        return len(modes.omega) * (PER_MODE + columns(modes.normal).shape[1])

    def fill(self, bank: Bank, lane: int, modes: Any, rows: Any, scene: Any) -> None:
        """Nothing depends on the lane."""

    def start(self, bank: Bank, lane: int) -> None:
        """Nothing follows from the motion."""

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
        correct_modes(lanes, bank.scheme, bank.state, n_active)

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
