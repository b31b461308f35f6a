"""The contact law of planar disks, with friction that always slides the same way.

Before a rigid casing λ ≥ 0, w = p − Wλ ≤ 0, λ·w = 0 hold at all contact points, with the Delassus
operator W = R·gain·(R + μT)ᵀ and the normal and tangential displacements R and T of the points per
unit modal coordinate (Joachim, Nyssen, Batailly 2020, section 2.2.2). The points meet one of the
`surfaces`.
"""

import numpy as np

from hpcrub.contact.arrays import FLAW, Bank
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import lane_arrays
from hpcrub.contact.laws.surface_law import SurfaceLaw
from hpcrub.contact.laws.surfaces import surface_of
from hpcrub.contact.lcp import pivoting
from hpcrub.contact.lcp.gauss_seidel import Coupled
from hpcrub.contact.protocols import Grid, Scene
from hpcrub.contact.status import NONE, UNPROVEN
from hpcrub.contact.tables import columns, delassus, row_bound, spread
from hpcrub.model.reduction import Rows


class Planar(SurfaceLaw, Coupled):
    """The law of planar disks, with C contact points (padded) in L lanes."""

    @staticmethod
    @compiled(inline=True, inner=True)
    def forces(lanes: tuple, bank: Bank, step: int, deepest: np.ndarray) -> int:
        """Contact forces of a step (bank is modified); see `protocols.Law`."""
        return bank.law.surface.solve_planar(lanes, bank.law, bank.state, deepest)

    @staticmethod
    def per_lane() -> tuple[str, ...]:
        """Names of arrays whose last axis is the lanes."""
        return Planar._fields

    @classmethod
    def allocate(cls, rows: Rows, scene: Scene, grid: Grid, width: int) -> "Planar":
        """Make the arrays for idle lanes; see `protocols.Law`."""
        n_points = columns(rows.normal).shape[1]
        return cls(
            **lane_arrays(width, coupling=(n_points + 1) ** 2, stiffness=n_points, bound=1),
            surface=surface_of(scene, grid, n_points, width),
        )

    @classmethod
    def loads(cls, rows: Rows, scene: Scene) -> np.ndarray:
        """Modal forces of unit multipliers (K, C), normal force and friction together."""
        normal, tangential, _ = rows.forces
        return -(columns(normal) + scene.friction * columns(tangential))

    def fill(self, bank: Bank, lane: int, rows: Rows, scene: Scene) -> None:
        """Give a lane its Delassus operator and a new surface (bank is modified)."""
        gain, (normal, tangential, _) = bank.scheme.gain[:, lane], rows.forces
        by_normal = delassus(rows.normal.T, normal.T, gain)
        W = by_normal + scene.friction * delassus(rows.normal.T, tangential.T, gain)
        self.surface.fill(lane, scene, bank.scheme.step[lane], by_normal)
        bank.state.report[FLAW, lane] = flaw = pivoting.flaw(W)
        if flaw not in (NONE, UNPROVEN):  # the lane gets no forces, and fails once a point touches
            return
        coupling = W / np.diag(W)
        np.fill_diagonal(coupling, 0.0)
        spread(self.coupling, lane, coupling)
        self.stiffness[: len(W), lane] = 1.0 / np.diag(W)
        self.bound[0, lane] = row_bound(coupling)
        self.surface.set_all_gains(self.stiffness)

    def forces_on_points(
        self, multiplier: np.ndarray, scene: Scene
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Normal, tangential and axial forces on the points [N] by multipliers (R, F, L)."""
        normal = multiplier[:, : len(scene.interface.angle)]
        return normal, scene.friction * normal, normal[:, :0]

    def steps_touched(self, lane: int) -> np.ndarray:
        """Empty array (0,): this law does not count contacts."""
        return np.zeros(0)
