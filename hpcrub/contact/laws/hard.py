"""A rigid casing as a surface."""

from typing import Any

import numpy as np

from hpcrub.contact.arrays import NoArrays, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import larger, select, splat
from hpcrub.contact.lcp import gauss_seidel, pivoting
from hpcrub.contact.protocols import Scene


@compiled(inline=True, inner=True)
def nothing(*args: Any) -> None:
    """Nothing happens."""


@compiled(inline=True, inner=True)
def unchanged(*args: Any) -> Any:
    """Return the last argument, which a coating would change."""
    return args[-1]


class Hard(NoArrays):
    """A rigid casing: N ≥ 0, p ≤ 0, N p = 0. The code of a point is 1 with a force, else 0.

    It has no state, and none of its forces goes on. `surfaces.Coated` describes the methods.
    """

    advance_clock = find_bars = effective_depth = staticmethod(unchanged)
    remember_force = total_force = staticmethod(unchanged)
    subtract_earlier = set_gains = wear = staticmethod(nothing)
    give_up = staticmethod(pivoting.solve_stuck)

    def fill(self, lane: int, scene: Scene, h: float, compliance: np.ndarray) -> None:
        """Nothing depends on the lane."""

    def set_all_gains(self, stiffness: np.ndarray) -> None:
        """No gains."""

    def memory(self, lane: int) -> None:
        """No memory."""

    def remember(self, lane: int, memory: None) -> None:
        """Nothing to restore."""

    @staticmethod
    @compiled(inline=True, inner=True)
    def solve_planar(lanes: tuple, law: Any, state: State, deepest: np.ndarray) -> int:
        """Contact forces of a planar disk (state is modified)."""
        n_active = gauss_seidel.candidates(lanes, law, state, deepest)
        gauss_seidel.solve(lanes, law, state, deepest, n_active)
        return n_active

    @staticmethod
    @compiled(inline=True, inner=True)
    def depth_undone(lanes: tuple, surface: "Hard", j: int, d: np.ndarray) -> tuple:
        """Depth d where it is positive, and the code of a force."""
        return larger(d, 0.0), splat(lanes, 1.0)

    @staticmethod
    @compiled(inline=True, inner=True)
    def linear_branch(lanes: tuple, surface: "Hard", j: int, code: np.ndarray) -> tuple:
        """Slope and start: x = d with a force, else x = 0."""
        return larger(code, 0.0), splat(lanes, 0.0)

    @staticmethod
    @compiled(inline=True, inner=True)
    def verify_branch(
        lanes: tuple, surface: "Hard", j: int, p: np.ndarray, x: np.ndarray, code: np.ndarray,
        limit: np.ndarray, trying: np.ndarray,
    ) -> np.ndarray:  # fmt: skip
        """1 for a force that pulls, 2 for a point that penetrates without force, else 0."""
        return select(code > 0.0, select(x < 0.0, 1.0, 0.0), select(limit < p, 2.0, 0.0))
