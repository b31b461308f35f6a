"""The contact law of planar disks before a casing that gives, or a coating that wears.

Contact forces by projected Gauss–Seidel as before a rigid casing, with the line of `surfaces` that
each point is on in place of max(d, 0). Slopes below one make it converge no slower.
"""

from typing import Any, NamedTuple

import numpy as np

from hpcrub.contact.arrays import FLAW, SWEEPS, UNSOLVED, Bank, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import (
    TILE,
    any_lane,
    fma,
    inverse,
    larger,
    load,
    positive_part,
    select,
    splat,
    store,
)
from hpcrub.contact.laws.rigid import Rigid
from hpcrub.contact.laws.surfaces import Coated, find_gains, relief
from hpcrub.contact.lcp import gauss_seidel
from hpcrub.contact.passes import predict_all
from hpcrub.contact.status import FATAL
from hpcrub.model.reduction import Modes


@compiled(inner=True)
def solve(lanes: tuple, law: Any, state: State, deepest: np.ndarray, n_active: int) -> None:
    """Depths x that the forces of the active points undo, in state.multiplier (state is modified).

    On return ``state.depth`` holds the depths d that the others leave.
    """
    limit = positive_part(deepest) * gauss_seidel.TOLERANCE
    changing = deepest > 0.0
    failed, sweeps = gauss_seidel.solve_many(lanes, law, state, n_active, limit, changing)
    stuck = select(failed, 1.0, 0.0)
    store(state.report, SWEEPS, larger(sweeps, load(lanes, state.report, SWEEPS)))
    store(state.report, UNSOLVED, larger(stuck, load(lanes, state.report, UNSOLVED)))


@compiled(inner=True)
def relieve(lanes: tuple, law: Any, state: State) -> np.ndarray:
    """Take from all penetrations what the forces of earlier steps undo (state, law are modified).

    Returns (L,); the deepest penetration [m].
    """
    last, zero = state.penetration.shape[0] - 1, splat(lanes, 0.0)
    for j in range(last):
        less = 0.0 - relief(lanes, law.surface, j, law.stiffness)
        store(state.multiplier, j, zero)
        if any_lane(less < 0.0):
            for i in range(last):
                effect = load(lanes, law.coupling, i * (last + 1) + j)
                left = fma(effect, less, load(lanes, state.penetration, i))
                store(state.penetration, i, left + less if i == j else left)
    deepest = load(lanes, state.penetration, 0)
    for i in range(last):
        p = load(lanes, state.penetration, i)
        store(law.surface.reached, i, p + load(lanes, law.surface.worn, law.surface.bar[i]))
        deepest = larger(p, deepest)
    return deepest


@compiled(inner=True)
def to_forces(lanes: tuple, law: Any, state: State, n_active: int) -> int:
    """Turn the depths x into forces, and keep what the points reach (state, law are modified).

    Returns points in `State.active`: those that carry a force in any lane.
    """
    surface, n = law.surface, 0
    for a in range(n_active):
        i = state.active[a]
        x, worn = load(lanes, state.multiplier, i), load(lanes, surface.worn, surface.bar[i])
        store(surface.reached, i, load(lanes, state.depth, i) - x + worn)
    surface.wear(lanes, surface, state, n_active)
    for i in range(state.penetration.shape[0] - 1):
        force = load(lanes, state.multiplier, i) * load(lanes, law.stiffness, i)
        surface.keep(lanes, surface, i, force)
        force = surface.total(lanes, surface, i, force)
        store(state.multiplier, i, force)
        if any_lane(force > 0.0):
            state.active[n] = i
            n += 1
    for a in range(n, n + TILE):
        state.active[a] = state.penetration.shape[0] - 1
    return n


class Giving(NamedTuple):
    """C contact points (padded) in L lanes."""

    coupling: np.ndarray  # these three as in `rigid.Rigid`
    stiffness: np.ndarray
    bound: np.ndarray
    surface: Coated

    @staticmethod
    @compiled(inline=True, inner=True)
    def predict(lanes: tuple, bank: Bank, step: int, n_active: int) -> np.ndarray:
        """Corrector, predictor and penetrations; see ``laws``."""
        deepest = predict_all(lanes, bank, step, n_active)
        return bank.law.surface.tick(lanes, bank.law.surface, deepest)

    @staticmethod
    @compiled(inline=True, inner=True)
    def respond(lanes: tuple, law: "Giving", j: int, depth: np.ndarray) -> np.ndarray:
        """Depth that the force of point j undoes; see `lcp.gauss_seidel`."""
        return law.surface.follow(lanes, law.surface, j, depth)[0]

    @staticmethod
    @compiled(inline=True, inner=True)
    def forces(lanes: tuple, bank: Bank, step: int, deepest: np.ndarray) -> int:
        """Contact forces of a step (bank is modified); see ``laws``."""
        state, law = bank.state, bank.law
        deepest = law.surface.meet(lanes, law.surface, state, law.stiffness, deepest)
        if not any_lane(deepest > 0.0):
            return 0
        deepest = relieve(lanes, law, state)
        n_active = gauss_seidel.candidates(lanes, law, state, deepest)
        solve(lanes, law, state, deepest, n_active)
        return to_forces(lanes, law, state, n_active)

    @staticmethod
    def per_lane() -> tuple[str, ...]:
        """Arrays whose last axis are the lanes."""
        return Giving._fields

    @classmethod
    def allocate(cls, modes: Modes, scene: Any, grid: Any, width: int) -> "Giving":
        """State of idle lanes; see ``laws``."""
        rigid = Rigid.allocate(modes, scene, grid, width)
        return cls(*rigid, Coated.allocate(scene, grid, len(rigid.stiffness), width))

    @classmethod
    def loads(cls, modes: Modes, scene: Any) -> np.ndarray:
        """Modal forces of unit multipliers (K, C), normal force and friction in one."""
        return Rigid.loads(modes, scene)

    def rigid(self) -> Rigid:
        """The same Delassus operator, of a casing that does not give."""
        return Rigid(self.coupling, self.stiffness, self.bound)

    def fill(self, bank: Bank, lane: int, modes: Modes, scene: Any) -> None:
        """Give a lane its Delassus operator and a new surface (bank is modified)."""
        compliance = self.rigid().fill(bank, lane, modes, scene)
        self.surface.fill(lane, scene, bank.scheme.step[lane], compliance)
        if bank.state.report[FLAW, lane] in FATAL:
            return
        for j in range(len(scene.interface.angle)):
            find_gains((0,) * bank.width, self.surface, j, inverse(self.stiffness[j]))

    def forces_on_points(
        self, multiplier: np.ndarray, scene: Any
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Normal, tangential and axial forces of multipliers (R, F, L) on the points [N]."""
        return self.rigid().forces_on_points(multiplier, scene)

    def memory(self, lane: int) -> Any:
        """What the surface keeps; see ``laws``."""
        return self.surface.memory(lane)

    def remember(self, lane: int, memory: Any) -> None:
        """Go on before a surface that has been met (modified)."""
        self.surface.remember(lane, memory)

    def steps_touched(self, lane: int) -> np.ndarray:
        """Nothing (0,): contacts are not counted."""
        return np.zeros(0)
