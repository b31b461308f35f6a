"""The elastic casing of a planar disk: a spring and a damper at every contact point.

A point that is p inside the casing at the end of a step feels N = max(0, k p + d ṗ), with ṗ the
difference to the step before over the step. As p = depth − x and x = W_jj N, this is a line

    x = max(0, α depth − γ (d/h) max(p of the step before, 0)),
    α = W_jj K/(1 + W_jj K),  γ = W_jj/(1 + W_jj K),  K = k + d/h,

so a stiff casing needs no smaller step, and k → ∞ is the rigid casing, α = 1.
"""

from typing import Any, NamedTuple

import numpy as np

from hpcrub.contact.arrays import Bank, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import aligned_zeros, fma, load, positive_part, splat, store
from hpcrub.contact.laws.rigid import Rigid
from hpcrub.contact.lcp import curves, gauss_seidel
from hpcrub.contact.passes import predict_all
from hpcrub.model.coating import ElasticCasing
from hpcrub.model.reduction import Modes


@compiled(inner=True)
def recall(lanes: tuple, law: Any, state: State, n_active: int) -> None:
    """Clear what the active points remember of other steps than the last (law is modified).

    Parameters
    ----------
    lanes, law, state
        As in `integrate.integrate`.
    n_active : int
        Entries of `State.active` that count.
    """
    for a in range(n_active):
        i = state.active[a]
        if law.remembered[i] != law.clock[0] - 1:
            store(law.last, i, splat(lanes, 0.0))


@compiled(inner=True)
def remember(lanes: tuple, law: Any, state: State, n_active: int) -> None:
    """Keep the penetrations at the end of this step (law is modified); as `recall`."""
    for a in range(n_active):
        i = state.active[a]
        p = load(lanes, state.depth, i) - load(lanes, state.multiplier, i)
        store(law.last, i, positive_part(p))
        law.remembered[i] = law.clock[0]


class Elastic(NamedTuple):
    """State of C contact points (padded) in L lanes."""

    coupling: np.ndarray  # these three as in `rigid.Rigid`
    stiffness: np.ndarray
    bound: np.ndarray
    slope: np.ndarray  # α (C, L) [-]
    lag: np.ndarray  # γ d/h (C, L) [-]
    last: np.ndarray  # penetration at the end of the step ``remembered`` (C, L) [m] (modified)
    remembered: np.ndarray  # (C,) int (modified)
    clock: np.ndarray  # steps that the bank has taken (1,) int (modified)

    @staticmethod
    @compiled(inline=True, inner=True)
    def predict(lanes: tuple, bank: Bank, step: int, n_active: int) -> np.ndarray:
        """Corrector, predictor and penetrations; see ``laws``."""
        bank.law.clock[0] += 1
        return predict_all(lanes, bank, step, n_active)

    @staticmethod
    @compiled(inline=True, inner=True)
    def respond(lanes: tuple, law: "Elastic", j: int, depth: np.ndarray) -> np.ndarray:
        """Depth that the force of point j undoes; see ``lcp.curves``."""
        less = splat(lanes, 0.0) - load(lanes, law.lag, j) * load(lanes, law.last, j)
        return positive_part(fma(load(lanes, law.slope, j), depth, less))

    @staticmethod
    @compiled(inline=True, inner=True)
    def forces(lanes: tuple, bank: Bank, step: int, deepest: np.ndarray) -> int:
        """Contact forces of a step (bank is modified); see ``laws``."""
        state, law = bank.state, bank.law
        n_active = gauss_seidel.candidates(lanes, law, state, deepest)
        recall(lanes, law, state, n_active)
        curves.solve(lanes, law, state, deepest, n_active)
        remember(lanes, law, state, n_active)
        return curves.to_forces(lanes, law, state, n_active)

    @staticmethod
    def per_lane() -> tuple[str, ...]:
        """Arrays whose last axis are the lanes."""
        return (*Rigid._fields, "slope", "lag", "last")

    @classmethod
    def allocate(cls, modes: Modes, scene: Any, grid: Any, width: int) -> "Elastic":
        """State of idle lanes; see ``laws``."""
        rigid = Rigid.allocate(modes, scene, grid, width)
        shape = rigid.stiffness.shape
        return cls(
            *rigid,
            slope=aligned_zeros(shape),
            lag=aligned_zeros(shape),
            last=aligned_zeros(shape),
            remembered=np.full(len(rigid.stiffness), -1),
            clock=np.zeros(1, dtype=np.int64),
        )

    @classmethod
    def loads(cls, modes: Modes, scene: Any) -> np.ndarray:
        """Modal forces of unit multipliers (K, C), normal force and friction in one."""
        return Rigid.loads(modes, scene)

    def rigid(self) -> Rigid:
        """The same Delassus operator, of a casing that does not give."""
        return Rigid(self.coupling, self.stiffness, self.bound)

    def fill(self, bank: Bank, lane: int, modes: Modes, scene: Any) -> None:
        """Give a lane its Delassus operator and its line of forces (bank is modified)."""
        self.rigid().fill(bank, lane, modes, scene)
        casing: ElasticCasing = scene.elastic_casing
        rate = casing.damping / bank.scheme.step[lane]
        alone = self.stiffness[:, lane] + casing.stiffness + rate
        self.slope[:, lane] = (casing.stiffness + rate) / alone
        self.lag[:, lane] = rate / alone

    def forces_on_points(
        self, multiplier: np.ndarray, scene: Any
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Normal, tangential and axial forces of multipliers (R, F, L) on the points [N]."""
        return self.rigid().forces_on_points(multiplier, scene)

    def steps_touched(self, lane: int) -> np.ndarray:
        """Nothing (0,): contacts are not counted."""
        return np.zeros(0)
