"""A rigid casing as a surface of disks that move in three dimensions."""

from typing import Any, NamedTuple

import numpy as np

from hpcrub.contact.arrays import State
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import below, positive_part, select, splat
from hpcrub.contact.laws.blades import solve_stuck


class Hard(NamedTuple):
    """A rigid casing: N ≥ 0, p ≤ 0, N p = 0. A point carries a force (1) or none (0)."""

    @staticmethod
    def per_lane() -> tuple[str, ...]:
        """No arrays."""
        return ()

    def fill(self, lane: int, scene: Any, h: float, compliance: np.ndarray) -> None:
        """Nothing depends on the lane."""

    def memory(self, lane: int) -> None:
        """Nothing."""

    @staticmethod
    @compiled(inline=True, inner=True)
    def tick(lanes: tuple, surface: "Hard", deepest: np.ndarray) -> np.ndarray:
        """See `surfaces.Coated.tick`; these all do what those do."""
        return deepest

    @staticmethod
    @compiled(inline=True, inner=True)
    def meet(
        lanes: tuple, surface: "Hard", state: State, stiffness: np.ndarray, deepest: np.ndarray
    ) -> np.ndarray:
        """The deepest penetration (L,) [m]."""
        return deepest

    @staticmethod
    @compiled(inline=True, inner=True)
    def near(
        lanes: tuple, surface: "Hard", j: int, stiffness: np.ndarray, depth: np.ndarray
    ) -> np.ndarray:
        """The penetration (L,) [m]."""
        return depth

    @staticmethod
    @compiled(inline=True, inner=True)
    def relieve(
        lanes: tuple, surface: "Hard", state: State, law: Any, start: int, end: int, n: int
    ) -> None:
        """No force goes on."""

    @staticmethod
    @compiled(inline=True, inner=True)
    def total(lanes: tuple, surface: "Hard", j: int, force: np.ndarray) -> np.ndarray:
        """The force (L,) [N]."""
        return force

    @staticmethod
    @compiled(inline=True, inner=True)
    def keep(lanes: tuple, surface: "Hard", j: int, pushed: np.ndarray) -> None:
        """Nothing is remembered."""

    @staticmethod
    @compiled(inline=True, inner=True)
    def comply(lanes: tuple, surface: "Hard", j: int, compliance: np.ndarray) -> None:
        """Nothing depends on the compliance."""

    @staticmethod
    @compiled(inline=True, inner=True)
    def line(
        lanes: tuple, surface: "Hard", j: int, code: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """All of d, or nothing."""
        return positive_part(code), splat(lanes, 0.0)

    @staticmethod
    @compiled(inline=True, inner=True)
    def check(
        lanes: tuple, surface: "Hard", j: int, p: np.ndarray, x: np.ndarray, code: np.ndarray,
        limit: np.ndarray, trying: np.ndarray,
    ) -> np.ndarray:  # fmt: skip
        """1 for a force that pulls, or where there is none at a point that penetrates."""
        zero, one = splat(lanes, 0.0), splat(lanes, 1.0)
        pulls = select(below(x, zero), one, zero)
        penetrates = select(below(limit, p), one, zero)
        return select(below(zero, code), pulls, penetrates)

    @staticmethod
    @compiled(inline=True, inner=True)
    def change(lanes: tuple, code: np.ndarray, wrong: np.ndarray) -> np.ndarray:
        """The other code."""
        return code + wrong * (splat(lanes, 1.0) - code - code)

    @staticmethod
    @compiled(inline=True, inner=True)
    def wear(lanes: tuple, surface: "Hard", state: State, n_active: int) -> None:
        """Nothing is worn."""

    @staticmethod
    @compiled(inner=True)
    def despair(state: State, law: Any, n_active: int) -> None:
        """Try another method where no set of points was right."""
        solve_stuck(state, law, n_active)
