"""The abradable coating of a planar disk's casing, rigid or elastic behind it.

The coating is a row of bars around the casing, one for every time step of a turn; where points
stand at different axial places, a row for each (a strip). A bar of thickness t and worn depth w
pushes with

    N = max(0, min(k₁ (p − w), k₂ p + c₀)),   k₁ = E A/t,  k₂ = k₁ H/(E + H),  c₀ = A E σ_Y/(E + H)

against a point that is p inside the new coating at the end of a step, after which its worn depth is

    w ← max(w, E/(E + H) (p − σ_Y t/E)),   at most t.

The second line does not depend on w. The casing behind takes over at p = t: rigid, or with
k (p − t) + d ṗ of `elastic`. As p = depth − x and x = W_jj N, each line N = K p − C is a line
x = α depth − γ C of the depth that the other forces leave, in the same order:

    x = max(0, min(x₁, x₂), min(x₃, x₄)),   x₃ and x₄ with the casing, where depth > t.

Bars have no motion of their own, so that a coating needs no smaller step. Legrand, Batailly,
Magnain, Cartraud, Pierre (2012); Batailly, Agrapart, Millecamps, Brunel (2016).
"""

from typing import Any, NamedTuple

import numpy as np

from hpcrub.contact.arrays import FLAW, Bank, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import (
    aligned_zeros,
    any_lane,
    below,
    fma,
    larger,
    load,
    positive_part,
    select,
    splat,
    store,
)
from hpcrub.contact.laws.elastic import recall, remember
from hpcrub.contact.laws.rigid import Rigid
from hpcrub.contact.lcp import curves, gauss_seidel
from hpcrub.contact.passes import predict_all
from hpcrub.contact.status import FATAL
from hpcrub.model.coating import Coating, ElasticCasing
from hpcrub.model.reduction import Modes

# Numbers of a point in a lane, rows of `Abradable.lines`: slopes α and offsets γC of the lines
# 1 to 4, what line 3 loses by worn depth, and what 3 and 4 lose by the last step's penetration
A1, A2, A3, A4, C2, C3, C4, WORN3, LAG3, LAG4 = range(10)
N_LINES = 10


@compiled(inner=True)
def find_bars(law: Any, state: State, n_active: int) -> None:
    """Rows of the bars under the active points (law.bar, modified); as `elastic.recall`."""
    n_steps = law.n_steps
    now = law.clock[0] % n_steps
    for a in range(n_active):
        i = state.active[a]
        at = now + law.offset[i]
        law.bar[i] = law.strip[i] * n_steps + (at - n_steps if at >= n_steps else at)


@compiled(inner=True)
def wear(lanes: tuple, law: Any, state: State, n_active: int) -> None:
    """Worn depths after the step (law is modified); as `elastic.recall`."""
    kept, start = splat(lanes, law.kept), splat(lanes, law.kept * law.depth_at_yield)
    most = splat(lanes, law.thickness)
    for a in range(n_active):
        i = state.active[a]
        p = load(lanes, state.depth, i) - load(lanes, state.multiplier, i)
        new = kept * p - start
        new = select(below(new, most), new, most)
        store(law.worn, law.bar[i], larger(new, load(lanes, law.worn, law.bar[i])))


class Abradable(NamedTuple):
    """State of C contact points (padded), Z strips of S bars, in L lanes."""

    coupling: np.ndarray  # these three as in `rigid.Rigid`
    stiffness: np.ndarray
    bound: np.ndarray
    lines: np.ndarray  # (10·C, L): slopes and offsets of the lines, see above
    worn: np.ndarray  # worn depth of every bar, strip by strip (Z·S, L) [m] (modified)
    last: np.ndarray  # these three as in `elastic.Elastic` (modified)
    remembered: np.ndarray
    clock: np.ndarray
    filled: np.ndarray  # clock at which a lane was filled (1, L) [steps] (modified)
    strip: np.ndarray  # of every point (C,) int
    offset: np.ndarray  # angle of every point, in bars (C,) int
    bar: np.ndarray  # row of ``worn`` under every point (C,) int (modified)
    n_steps: int  # S
    kept: float  # E/(E + H) [-]
    depth_at_yield: float  # [m]
    thickness: float  # [m]

    @staticmethod
    @compiled(inline=True, inner=True)
    def predict(lanes: tuple, bank: Bank, step: int, n_active: int) -> np.ndarray:
        """Corrector, predictor and penetrations; see ``laws``."""
        bank.law.clock[0] += 1
        return predict_all(lanes, bank, step, n_active)

    @staticmethod
    @compiled(inner=True)
    def respond(lanes: tuple, law: "Abradable", j: int, depth: np.ndarray) -> np.ndarray:
        """Depth that the force of point j undoes; see ``lcp.curves``."""
        row, zero, lines = N_LINES * j, splat(lanes, 0.0), law.lines
        worn = load(lanes, law.worn, law.bar[j])
        before = load(lanes, lines, row + A1) * (depth - worn)
        beyond = fma(load(lanes, lines, row + A2), depth, load(lanes, lines, row + C2))
        x = select(below(before, beyond), before, beyond)
        behind = below(splat(lanes, law.thickness), depth)
        if any_lane(behind):
            last = positive_part(load(lanes, law.last, j) - splat(lanes, law.thickness))
            before = fma(load(lanes, lines, row + A3), depth, load(lanes, lines, row + C3))
            before = before - load(lanes, lines, row + WORN3) * worn
            before = before - load(lanes, lines, row + LAG3) * last
            beyond = fma(load(lanes, lines, row + A4), depth, load(lanes, lines, row + C4))
            beyond = beyond - load(lanes, lines, row + LAG4) * last
            both = select(below(before, beyond), before, beyond)
            x = select(behind, larger(both, x), x)
        return larger(x, zero)

    @staticmethod
    @compiled(inline=True, inner=True)
    def forces(lanes: tuple, bank: Bank, step: int, deepest: np.ndarray) -> int:
        """Contact forces of a step (bank is modified); see ``laws``."""
        state, law = bank.state, bank.law
        n_active = gauss_seidel.candidates(lanes, law, state, deepest)
        find_bars(law, state, n_active)
        recall(lanes, law, state, n_active)
        curves.solve(lanes, law, state, deepest, n_active)
        wear(lanes, law, state, n_active)
        remember(lanes, law, state, n_active)
        return curves.to_forces(lanes, law, state, n_active)

    @staticmethod
    def per_lane() -> tuple[str, ...]:
        """Arrays whose last axis are the lanes."""
        return (*Rigid._fields, "lines", "worn", "last", "filled")

    @classmethod
    def allocate(cls, modes: Modes, scene: Any, grid: Any, width: int) -> "Abradable":
        """State of idle lanes; see ``laws``."""
        rigid, coating, n_steps = (
            Rigid.allocate(modes, scene, grid, width), scene.coating, grid.steps_per_revolution
        )  # fmt: skip
        n_points, interface = len(rigid.stiffness), scene.interface
        strip, offset = np.zeros((2, n_points), dtype=np.int64)
        places, found = strips(interface)
        n = len(interface.angle)
        strip[:n] = found
        offset[:n] = np.round(interface.angle * n_steps / (2.0 * np.pi)).astype(int) % n_steps
        return cls(
            *rigid,
            lines=aligned_zeros((N_LINES * n_points, width)),
            worn=aligned_zeros((len(places) * n_steps, width)),
            last=aligned_zeros((n_points, width)),
            remembered=np.full(n_points, -1),
            clock=np.zeros(1, dtype=np.int64),
            filled=aligned_zeros((1, width)),
            strip=strip,
            offset=offset,
            bar=np.zeros(n_points, dtype=np.int64),
            n_steps=n_steps,
            kept=coating.kept,
            depth_at_yield=coating.depth_at_yield,
            thickness=coating.thickness,
        )

    @classmethod
    def loads(cls, modes: Modes, scene: Any) -> np.ndarray:
        """Modal forces of unit multipliers (K, C), normal force and friction in one."""
        return Rigid.loads(modes, scene)

    def rigid(self) -> Rigid:
        """The same Delassus operator, of a casing that does not give."""
        return Rigid(self.coupling, self.stiffness, self.bound)

    def fill(self, bank: Bank, lane: int, modes: Modes, scene: Any) -> None:
        """Give a lane its Delassus operator, its lines and a new coating (bank is modified)."""
        self.rigid().fill(bank, lane, modes, scene)
        self.filled[0, lane] = self.clock[0] % self.n_steps
        if bank.state.report[FLAW, lane] in FATAL:
            return
        lines = self.lines.reshape(-1, N_LINES, self.lines.shape[1])
        step = bank.scheme.step[lane]
        for j, share in enumerate(scene.interface.share):
            lines[j, :, lane] = line_table(
                self.stiffness[j, lane], scene.coating, share, scene.elastic_casing, step
            )

    def forces_on_points(
        self, multiplier: np.ndarray, scene: Any
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Normal, tangential and axial forces of multipliers (R, F, L) on the points [N]."""
        return self.rigid().forces_on_points(multiplier, scene)

    def steps_touched(self, lane: int) -> np.ndarray:
        """Nothing (0,): contacts are not counted."""
        return np.zeros(0)

    def worn_depth(self, lane: int) -> np.ndarray:
        """Worn depths around the casing (Z, S) [m], bar e at the angle 2πe/S of the casing."""
        worn = self.worn[:, lane].reshape(-1, self.n_steps)
        return np.roll(worn, -int(self.filled[0, lane]), axis=1)


def strips(interface: Any) -> tuple[np.ndarray, np.ndarray]:
    """Axial places of the strips of a coating (Z,) [m], and the strip of every point (C,)."""
    digits = np.round(interface.axial_position, 9)
    return np.unique(digits, return_inverse=True)


def line_table(
    alone: float, coating: Coating, share: float, casing: ElasticCasing | None, step: float
) -> np.ndarray:
    """Slopes and offsets of the lines of a contact point (10,).

    Parameters
    ----------
    alone : float
        Stiffness of the structure in one step, 1/W_jj [N/m].
    coating : Coating
    share : float
        Of the blade's tip that belongs to the point [-].
    casing : ElasticCasing or None
        Behind the coating; None: rigid.
    step : float
        Time step [s].
    """
    k1, k2, c0 = coating.stiffnesses(coating.area * share)
    t, table = coating.thickness, np.zeros(N_LINES)
    table[A1], table[A2], table[C2] = k1 / (alone + k1), k2 / (alone + k2), c0 / (alone + k2)
    if casing is None:
        table[[A3, A4]], table[[C3, C4]] = 1.0, -t
        return table
    lag = casing.damping / step
    behind = casing.stiffness + lag
    one, two = alone + k1 + behind, alone + k2 + behind
    table[[A3, A4]] = (k1 + behind) / one, (k2 + behind) / two
    table[[C3, C4]] = -behind * t / one, (c0 - behind * t) / two
    table[[WORN3, LAG3, LAG4]] = k1 / one, lag / one, lag / two
    return table
