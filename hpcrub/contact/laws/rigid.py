"""The rigid casing of a planar disk, with friction that always slides the same way.

The casing does not give: λ ≥ 0, w = p − Wλ ≤ 0, λ·w = 0 at all contact points at once, with the
Delassus operator W = R·gain·(R + μT)ᵀ, R the normal and T the tangential displacement of the points
per unit modal coordinate (Joachim, Nyssen, Batailly 2020, section 2.2.2).
"""

from typing import Any, NamedTuple

import numpy as np

from hpcrub.contact.arrays import FLAW, Bank
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import aligned_zeros, positive_part
from hpcrub.contact.lcp import gauss_seidel, pivoting
from hpcrub.contact.passes import predict_all
from hpcrub.contact.status import NONE, UNPROVEN
from hpcrub.contact.tables import columns, delassus, row_bound, spread
from hpcrub.model.reduction import Modes


class Rigid(NamedTuple):
    """Delassus operator of C contact points (padded) in L lanes."""

    coupling: np.ndarray  # W_ij / W_jj ((C + 1)², L), row i·(C + 1) + j; zero where i = j or last
    stiffness: np.ndarray  # 1 / W_jj (C, L) [N/m]
    bound: np.ndarray  # how far in others push a point, over the deepest penetration (1, L) [-]

    @staticmethod
    @compiled(inline=True, inner=True)
    def predict(lanes: tuple, bank: Bank, step: int, n_active: int) -> np.ndarray:
        """Corrector, predictor and penetrations; see ``laws``."""
        return predict_all(lanes, bank, step, n_active)

    @staticmethod
    @compiled(inline=True, inner=True)
    def respond(lanes: tuple, law: "Rigid", j: int, depth: np.ndarray) -> np.ndarray:
        """Depth that the force of point j undoes: all that there is."""
        return positive_part(depth)

    @staticmethod
    @compiled(inline=True, inner=True)
    def forces(lanes: tuple, bank: Bank, step: int, deepest: np.ndarray) -> int:
        """Contact forces of a step (bank is modified); see ``laws``."""
        n_active = gauss_seidel.candidates(lanes, bank.law, bank.state, deepest)
        gauss_seidel.solve(lanes, bank.law, bank.state, deepest, n_active)
        return n_active

    @staticmethod
    def per_lane() -> tuple[str, ...]:
        """Arrays whose last axis are the lanes."""
        return Rigid._fields

    @classmethod
    def allocate(cls, modes: Modes, scene: Any, grid: Any, width: int) -> "Rigid":
        """State of idle lanes; see ``laws``."""
        n_points = columns(modes.normal).shape[1]
        return cls(
            coupling=aligned_zeros(((n_points + 1) ** 2, width)),
            stiffness=aligned_zeros((n_points, width)),
            bound=aligned_zeros((1, width)),
        )

    @classmethod
    def loads(cls, modes: Modes, scene: Any) -> np.ndarray:
        """Modal forces of unit multipliers (K, C), normal force and friction in one."""
        return -(columns(modes.normal) + scene.friction * columns(modes.tangential))

    def fill(self, bank: Bank, lane: int, modes: Modes, scene: Any) -> np.ndarray:
        """Give a lane its Delassus operator (bank is modified).

        Returns (C, C); its part by normal forces, without friction [m/N].
        """
        gain, normal = bank.scheme.gain[:, lane], modes.normal.T
        by_normal = delassus(normal, normal, gain)
        W = by_normal + scene.friction * delassus(normal, modes.tangential.T, gain)
        bank.state.report[FLAW, lane] = flaw = pivoting.flaw(W)
        if flaw not in (NONE, UNPROVEN):  # no forces, and no result once a point touches
            return by_normal
        coupling = W / np.diag(W)
        np.fill_diagonal(coupling, 0.0)
        spread(self.coupling, lane, coupling)
        self.stiffness[: len(W), lane] = 1.0 / np.diag(W)
        self.bound[0, lane] = row_bound(coupling)
        return by_normal

    def forces_on_points(
        self, multiplier: np.ndarray, scene: Any
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Normal, tangential and axial forces of multipliers (R, F, L) on the points [N]."""
        normal = multiplier[:, : len(scene.interface.angle)]
        return normal, scene.friction * normal, normal[:, :0]

    def memory(self, lane: int) -> None:
        """Nothing."""

    def steps_touched(self, lane: int) -> np.ndarray:
        """Nothing (0,): contacts are not counted."""
        return np.zeros(0)
