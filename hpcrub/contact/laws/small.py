"""Small displacements, the kinematics of contact to first order."""

from typing import Any

import numpy as np

from hpcrub.contact import lanes as v
from hpcrub.contact.arrays import Bank, NoArrays, State
from hpcrub.contact.jit import compiled


@compiled(inline=True, inner=True)
def row_of_pair(law: Any, i: int, j: int) -> int:
    """Row in ``law.compliance`` of the motion of point i by the normal force on point j."""
    apart = law.sector[i] - law.sector[j]
    apart = apart + law.n_sectors if apart < 0 else apart
    return 3 * ((apart * law.n_places + law.place[j]) * law.n_places + law.place[i])


@compiled(inline=True, inner=True)
def list_directions(state: State, n: int) -> int:
    """List the tangential and axial multipliers of n listed points, too (state is modified).

    Returns the number of listed multipliers.
    """
    n_points = state.penetration.shape[0] - 1
    for a in range(n):
        state.active[n + a] = n_points + state.active[a]
        state.active[2 * n + a] = 2 * n_points + state.active[a]
    return 3 * n


class Small(NoArrays):
    """Small displacements: points meet the casing where they rest, in directions that stay.

    They have no state. `bent.Bent` describes the methods.
    """

    STEEPER = 0.0  # what tilted surfaces add to the coefficient of friction at most

    @staticmethod
    @compiled(inline=True, inner=True)
    def displace(lanes: tuple, bank: Bank, step: int, deepest: np.ndarray) -> np.ndarray:
        """The deepest penetration is that of the points where they rest."""
        return deepest

    @staticmethod
    @compiled(inline=True, inner=True)
    def see(lanes: tuple, law: Any, i: int) -> None:
        """Directions stay."""

    @staticmethod
    @compiled(inline=True, inner=True)
    def push(lanes: tuple, law: Any, j: int, along: np.ndarray, across: np.ndarray) -> None:
        """Directions stay."""

    @staticmethod
    @compiled(inline=True, inner=True)
    def compliance(
        lanes: tuple, law: Any, i: int, j: int, along: np.ndarray, across: np.ndarray
    ) -> np.ndarray:
        """Normal motion (L,) of point i by a unit normal force on j, with friction [m/N]."""
        at = row_of_pair(law, i, j)
        w = v.load(lanes, law.compliance, at)
        w = v.fma(along, v.load(lanes, law.compliance, at + 1), w)
        return v.fma(across, v.load(lanes, law.compliance, at + 2), w)

    @staticmethod
    @compiled(inline=True, inner=True)
    def directed(lanes: tuple, state: State, law: Any, n: int) -> int:
        """Normal, tangential and axial forces of the n listed points (state is modified)."""
        n_points = state.penetration.shape[0] - 1
        for a in range(n):
            i = state.active[a]
            friction = law.friction * v.load(lanes, state.multiplier, i)
            v.store(state.multiplier, n_points + i, friction * v.load(lanes, law.cosine, i))
            v.store(state.multiplier, 2 * n_points + i, friction * v.load(lanes, law.sine, i))
        return list_directions(state, n)
