"""Surfaces before contact points: a coating that wears, and a casing behind it that gives.

A surface pushes with a force N(p) against a point that penetrates it by p; N never falls with p.
The force of a step is a N_{n+1} + b N_n + c N_{n−1}, from the penetrations at the end of this step
and of the two before (`recurrence.newmark`). Let d be the penetration that all other forces and
the earlier forces on the point leave, W the compliance of the point in a step, and x = a W N_{n+1}
the depth that the latest force undoes, so that p = d − x. A line N = K p + B then becomes

    x = γ (K d + B),   γ = a W/(1 + a W K),

and the line with the least or largest N also has the least or largest x. A coating is a row of bars
around the casing, one for every time step of a turn, and one such row (a strip) for every axial
position of contact points. A bar of thickness t and worn depth w pushes with

    N = max(0, min(k₁ (p − w), k₂ p + c₀)),   k₁ = E A/t,  k₂ = k₁ H/(E + H),  c₀ = A E σ_Y/(E + H)

against a point that is p inside the new coating; then its worn depth becomes

    w ← max(w, E/(E + H) (p − σ_Y t/E)).

The second line does not depend on w. At p = t the bar is used up: it strains no further and keeps
its force. The casing behind the bar adds its own force: it is rigid, or has a spring and a damper,
k (p − t) + d ṗ ≥ 0, with ṗ the change of p in the step over the step. A casing that gives without
a coating has a coating of no thickness. Bars and casing have no motion of their own, so that no
stiffness makes a step unstable; a rigid casing acts in its own step only.
Legrand, Batailly, Magnain, Cartraud, Pierre (2012); Batailly, Agrapart, Millecamps, Brunel (2016).
"""

from typing import Any, NamedTuple

import numpy as np

from hpcrub.contact import lanes as v
from hpcrub.contact.arrays import STUCK, UNSOLVED, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.laws.hard import Hard
from hpcrub.contact.laws.yielding_planar import solve_planar
from hpcrub.contact.protocols import Grid, Scene
from hpcrub.contact.recurrence import newmark

BEFORE, BEYOND, START = range(3)  # rows of `Coated.bars`: k₁, k₂ and c₀
LINES = 4  # lines of a point: bar before yield, beyond yield, casing behind, bar used up
WEIGHTS = 3  # number of weights of a point: a, b and c
LATEST, EARLIER = range(2)  # steps whose forces a point remembers


@compiled(inline=True, inner=True)
def relief(lanes: tuple, surface: "Coated", j: int) -> np.ndarray:
    """Depth (L,) [m] that earlier forces on a point undo."""
    earlier = v.load(lanes, surface.earlier, j)
    return v.larger(earlier, 0.0) * v.load(lanes, surface.compliance, j)


@compiled(inline=True, inner=True)
def held(lanes: tuple, surface: "Coated", j: int, worn: np.ndarray) -> np.ndarray:
    """Force (L,) [N] of a bar that is used up; worn: worn depth of the bar (L,) [m]."""
    before = surface.bars[BEFORE, j] * (surface.thickness - worn)
    beyond = surface.bars[BEYOND, j] * surface.thickness + surface.bars[START, j]
    return v.select(beyond < before, beyond, before)


def find_gains(lanes: tuple, surface: "Coated", j: int, compliance: np.ndarray) -> None:
    """Set the gains γ of a point's lines from its compliance W (L,) [m/N] (surface, modified)."""
    v.store(surface.compliance, j, compliance)
    compliance = compliance * v.load(lanes, surface.weights, WEIGHTS * j)
    for row, slope in ((0, surface.bars[BEFORE, j]), (1, surface.bars[BEYOND, j])):
        gain = compliance * v.inverse(v.fma(compliance, slope, 1.0))
        v.store(surface.gain, LINES * j + row, gain)
    behind = surface.stiffness + v.load(lanes, surface.lag, 0)
    gain = compliance * v.inverse(v.fma(compliance, behind, 1.0))
    rigid = v.select(compliance > 0.0, 1.0, 0.0)
    v.store(surface.gain, LINES * j + 2, gain if surface.carried != 0.0 else rigid)
    v.store(surface.gain, LINES * j + 3, compliance * surface.carried)


class CoatedArrays(NamedTuple):
    """Z strips of S bars before C contact points (padded), with the casing behind, in L lanes."""

    compliance: np.ndarray  # W of every point (C, L) [m/N] (modified)
    gain: np.ndarray  # γ (4·C, L) [m/N]; 1 for a rigid casing behind (modified)
    lag: np.ndarray  # d/h of the casing (1, L) [N/m]
    worn: np.ndarray  # worn depth of every bar, strip by strip (Z·S, L) [m] (modified)
    reached: np.ndarray  # penetration of the new coating after a step (C, L) [m] (modified)
    last: np.ndarray  # penetration of the casing in the step before (C, L) [m] (modified)
    weights: np.ndarray  # a, b and c (3·C, L) [-]
    unweighted: np.ndarray  # 1/a (C, L) [-]
    remembered: np.ndarray  # N of the last two steps (2·C, L) [N] (modified)
    earlier: np.ndarray  # b N_n + c N_{n−1} in the coming force (C, L) [N] (modified)
    filled: np.ndarray  # clock at which a lane was filled (1, L) [steps] (modified)
    # number of steps taken; last step with a point near; last step with a force (3,) int (modified)
    clock: np.ndarray
    strip: np.ndarray  # strip before every point (C,) int
    offset: np.ndarray  # angle of every point, in bars (C,) int
    bar: np.ndarray  # row of ``worn`` under every point (C,) int (modified)
    bars: np.ndarray  # k₁, k₂ and c₀ of every point (3, C) [N/m, N/m, N]
    n_steps: int  # S, time steps of a turn; 1 without a coating
    kept: float  # E/(E + H) [-]
    depth_at_yield: float  # [m]
    thickness: float  # [m]
    stiffness: float  # k of the casing [N/m]; 1 for a rigid casing
    carried: float  # 1; 0 for a rigid casing, whose force replaces that of the bar


class Coated(CoatedArrays):
    """A coating that wears, and the casing behind it.

    From `find_bars` on `State.penetration` counts from the worn surface. The code of a line is 1
    before and 2 beyond yield, 3 on the casing behind, 4 on a bar that is used up while the casing
    would pull, and 0 without force.
    """

    solve_planar = staticmethod(solve_planar)
    set_gains = staticmethod(compiled(find_gains, inner=True))

    @staticmethod
    def per_lane() -> tuple[str, ...]:
        """Names of arrays whose last axis is the lanes."""
        return (
            "compliance", "gain", "lag", "worn", "reached", "last", "weights", "unweighted",
            "remembered", "earlier", "filled",
        )  # fmt: skip

    @classmethod
    def allocate(cls, scene: Scene, grid: Grid, n_points: int, width: int) -> "Coated":
        """Make the surface for idle lanes; n_points: number of points, padded."""
        coating, casing, interface = scene.coating, scene.elastic_casing, scene.interface
        bars, n_steps, n = np.zeros((3, n_points)), 1, len(interface.angle)
        strip, offset = np.zeros((2, n_points), dtype=np.int64)
        if coating:
            n_steps = grid.steps_per_revolution
            strip[:n] = interface.strip
            offset[:n] = np.round(interface.angle * n_steps / (2.0 * np.pi)).astype(int) % n_steps
            bars[:, :n] = np.transpose(
                [coating.stiffnesses(coating.area * share) for share in interface.share]
            )
        return cls(
            **v.lane_arrays(
                width, compliance=n_points, gain=LINES * n_points, lag=1,
                worn=(strip.max() + 1) * n_steps, reached=n_points, last=n_points,
                weights=WEIGHTS * n_points, unweighted=n_points, remembered=2 * n_points,
                earlier=n_points, filled=1,
            ),
            clock=np.array([0, -1, -2]),
            strip=strip,
            offset=offset,
            bar=np.zeros(n_points, dtype=np.int64),
            bars=bars,
            n_steps=n_steps,
            kept=coating.kept if coating else 0.0,
            depth_at_yield=coating.depth_at_yield if coating else 0.0,
            thickness=coating.thickness if coating else 0.0,
            stiffness=casing.stiffness if casing else 1.0,
            carried=1.0 if casing else 0.0,
        )  # fmt: skip

    def fill(self, lane: int, scene: Scene, h: float, compliance: np.ndarray) -> None:
        """Give a lane a new coating (surface is modified).

        h: time step [s]; compliance: motion of each point by a unit force on each (n, n) [m/N].
        """
        self.filled[0, lane] = self.clock[0] % self.n_steps
        self.lag[0, lane] = lag = scene.elastic_casing.damping / h if scene.elastic_casing else 0.0
        n = len(compliance)
        stiffness = self.bars[BEFORE, :n] + self.carried * self.stiffness + lag
        for row, weight in enumerate(newmark(np.abs(compliance) @ stiffness)):
            self.weights[row : WEIGHTS * n : WEIGHTS, lane] = weight
        self.unweighted[:n, lane] = 1.0 / self.weights[: WEIGHTS * n : WEIGHTS, lane]
        # what `relief` needs in the first step, if earlier forces go on
        self.compliance[:n, lane] = np.diag(compliance)

    def set_all_gains(self, stiffness: np.ndarray) -> None:
        """Set the gains of all points in all lanes where W never changes; stiffness: 1/W (C, L)."""
        for j, row in enumerate(stiffness):
            find_gains((0,) * len(row), self, j, v.inverse(row))

    def worn_depth(self, lane: int) -> np.ndarray:
        """Worn depths around the casing (Z, S) [m], bar e at the angle 2πe/S of the casing."""
        worn = self.worn[:, lane].reshape(-1, self.n_steps)
        return np.roll(worn, -int(self.filled[0, lane]), axis=1)

    def memory(self, lane: int) -> tuple[np.ndarray, ...]:
        """State of a lane from which a later run goes on.

        Returns worn depths from the present angle of the disk on (Z, S) [m], `reached` in the last
        step (C,) [m] and `remembered` (2·C,) [N].
        """
        worn = self.worn[:, lane].reshape(-1, self.n_steps)
        touched = self.clock[1] == self.clock[0]
        reached = np.where(touched, self.reached[:, lane], 0.0)
        worn = np.roll(worn, -(self.clock[0] % self.n_steps), axis=1)
        return worn, reached, self.remembered[:, lane].copy()

    def remember(self, lane: int, memory: tuple[np.ndarray, ...]) -> None:
        """Restore a `memory`, with as many steps in a turn, in a lane just filled (modified)."""
        worn, reached, self.remembered[:, lane] = memory
        self.clock[2] = self.clock[0]
        if self.clock[1] != self.clock[0]:  # no point was near in the last step
            self.reached[:] = 0.0
            self.clock[1] = self.clock[0]
        self.worn[:, lane] = np.roll(worn, self.clock[0] % self.n_steps, axis=1).ravel()
        self.reached[:, lane] = reached

    @staticmethod
    @compiled(inline=True, inner=True)
    def advance_clock(lanes: tuple, surface: "Coated", deepest: np.ndarray) -> np.ndarray:
        """Advance the clock by a step (surface is modified).

        Returns the deepest penetration (L,) [m], made positive while earlier forces go on.
        """
        surface.clock[0] += 1
        goes_on = surface.clock[0] - surface.clock[2] <= 2
        return v.larger(deepest, 1.0) if goes_on else deepest

    @staticmethod
    @compiled(inner=True)
    def find_bars(lanes: tuple, surface: "Coated", state: State, deepest: np.ndarray) -> np.ndarray:
        """Find the bars under the points, penetrations of the worn bars, and forces that go on.

        Modifies surface and state.
        Returns the deepest penetration, or the depth that earlier forces undo (L,) [m].
        """
        follows, now = surface.clock[1] == surface.clock[0] - 1, surface.clock[0] % surface.n_steps
        surface.clock[1] = surface.clock[0]
        zero = v.splat(lanes, 0.0)
        deepest = v.splat(lanes, -np.inf)
        for i in range(surface.strip.shape[0]):
            at = now + surface.offset[i]
            at = at - surface.n_steps if at >= surface.n_steps else at
            surface.bar[i] = surface.strip[i] * surface.n_steps + at
            last = v.larger(v.load(lanes, surface.reached, i) - surface.thickness, 0.0)
            v.store(surface.last, i, last if follows else zero)
            p = v.load(lanes, state.penetration, i)
            v.store(surface.reached, i, p)
            p = p - v.load(lanes, surface.worn, surface.bar[i])
            v.store(state.penetration, i, p)
            latest = v.load(lanes, surface.remembered, 2 * i + LATEST)
            earlier = latest * v.load(lanes, surface.weights, WEIGHTS * i + 1)
            before = v.load(lanes, surface.remembered, 2 * i + EARLIER)
            earlier = v.fma(before, v.load(lanes, surface.weights, WEIGHTS * i + 2), earlier)
            v.store(surface.earlier, i, earlier)
            v.store(surface.remembered, 2 * i + EARLIER, latest)
            v.store(surface.remembered, 2 * i + LATEST, zero)
            deepest = v.larger(v.larger(p, relief(lanes, surface, i)), deepest)
        return deepest

    @staticmethod
    @compiled(inline=True, inner=True)
    def effective_depth(lanes: tuple, surface: "Coated", j: int, depth: np.ndarray) -> np.ndarray:
        """Depth (L,) [m] of a point, the depth that earlier forces undo where this is larger."""
        undone = relief(lanes, surface, j)
        return v.select(undone > 0.0, v.larger(depth, undone), depth)

    @staticmethod
    @compiled(inner=True)
    def subtract_earlier(lanes: tuple, surface: "Coated", state: State, law: Any, n: int) -> None:
        """Reduce the depths of n listed points by their earlier forces (state is modified)."""
        n_rows = state.penetration.shape[0]
        for b in range(n):
            j = state.active[b]
            less = 0.0 - relief(lanes, surface, j)
            if v.any_lane(less < 0.0):
                for a in range(n):
                    effect = v.load(lanes, law.coupling, b * n_rows + a)
                    v.store(state.depth, a, v.fma(effect, less, v.load(lanes, state.depth, a)))

    @staticmethod
    @compiled(inline=True, inner=True)
    def total_force(lanes: tuple, surface: "Coated", j: int, force: np.ndarray) -> np.ndarray:
        """Force (L,) [N] on a point, including earlier forces that go on."""
        return force + v.load(lanes, surface.earlier, j)

    @staticmethod
    @compiled(inner=True)
    def remember_force(lanes: tuple, surface: "Coated", j: int, pushed: np.ndarray) -> np.ndarray:
        """Remember the force N on a point; pushed: a N (L,) [N] (surface is modified).

        Returns `total_force`.
        """
        new = pushed * v.load(lanes, surface.unweighted, j)
        if surface.carried == 0.0:  # a rigid casing pushes in its own step only
            most = held(lanes, surface, j, v.load(lanes, surface.worn, surface.bar[j]))
            new = v.select(most < new, most, new)
        v.store(surface.remembered, 2 * j + LATEST, new)
        if v.any_lane(new > 0.0):
            surface.clock[2] = surface.clock[0]
        return pushed + v.load(lanes, surface.earlier, j)

    @staticmethod
    @compiled(inner=True)
    def depth_undone(
        lanes: tuple, surface: "Coated", j: int, d: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Depth x (L,) that the force on point j undoes at the depth d [m], and its line's code."""
        worn = v.load(lanes, surface.worn, surface.bar[j])
        before = surface.bars[BEFORE, j] * d
        beyond = v.fma(surface.bars[BEYOND, j], d + worn, surface.bars[START, j])
        x = v.load(lanes, surface.gain, LINES * j) * before
        other = v.load(lanes, surface.gain, LINES * j + 1) * beyond
        yields = other < x
        x, code = v.select(yields, other, x), v.select(yields, 2.0, 1.0)
        behind = (d + worn) - surface.thickness
        pressed = x < behind
        if v.any_lane(pressed):
            lag = v.load(lanes, surface.lag, 0)
            most = surface.carried * held(lanes, surface, j, worn)
            push = v.fma(surface.stiffness + lag, behind, most)
            push = push - lag * v.load(lanes, surface.last, j)
            both = v.load(lanes, surface.gain, LINES * j + 2) * push
            alone = v.load(lanes, surface.gain, LINES * j + 3) * most
            pulls = both < alone
            x = v.select(pressed, v.select(pulls, alone, both), x)
            code = v.select(pressed, v.select(pulls, 4.0, 3.0), code)
        return v.larger(x, 0.0), v.select(x > 0.0, code, 0.0)

    @staticmethod
    @compiled(inner=True)
    def linear_branch(
        lanes: tuple, surface: "Coated", j: int, code: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Slope (L,) [-] and start (L,) [m] of the line x = slope·d + start with a code."""
        worn = v.load(lanes, surface.worn, surface.bar[j])
        before, beyond = surface.bars[BEFORE, j], surface.bars[BEYOND, j]
        first = v.fma(beyond, worn, surface.bars[START, j])
        gain = v.load(lanes, surface.gain, LINES * j)
        other = v.load(lanes, surface.gain, LINES * j + 1)
        yields = code > 1.5
        slope = v.select(yields, other * beyond, gain * before)
        start = v.select(yields, other * first, 0.0)
        pressed = code > 2.5
        if v.any_lane(pressed):
            lag = v.load(lanes, surface.lag, 0)
            most = surface.carried * held(lanes, surface, j, worn)
            behind, pulls = surface.stiffness + lag, code > 3.5
            push = v.fma(behind, worn - surface.thickness, most)
            push = push - lag * v.load(lanes, surface.last, j)
            gain = v.load(lanes, surface.gain, LINES * j + 2)
            alone = v.load(lanes, surface.gain, LINES * j + 3) * most
            slope = v.select(pressed, v.select(pulls, 0.0, gain * behind), slope)
            start = v.select(pressed, v.select(pulls, alone, gain * push), start)
        touches = code > 0.0
        return v.select(touches, slope, 0.0), v.select(touches, start, 0.0)

    @staticmethod
    @compiled(inline=True, inner=True)
    def verify_branch(
        lanes: tuple, surface: "Coated", j: int, p: np.ndarray, x: np.ndarray, code: np.ndarray,
        limit: np.ndarray, trying: np.ndarray,
    ) -> np.ndarray:  # fmt: skip
        """Check a depth x (L,) [m] against the line of a point at the penetration p (L,) [m].

        code: (L,) code of the line that gave x; limit: (L,) tolerance [m].
        trying: (L,) bool, lanes that count (their ``reached`` is modified).
        Returns 1 + the code of the right line where x is wrong, else 0.
        """
        worn = v.load(lanes, surface.worn, surface.bar[j])
        v.store(surface.reached, j, v.select(trying, p + worn, v.load(lanes, surface.reached, j)))
        right, line_code = surface.depth_undone(lanes, surface, j, p + x)
        off = right - x
        return v.select(limit < v.larger(off, 0.0 - off), 1.0 + line_code, 0.0)

    @staticmethod
    @compiled(inner=True)
    def wear(lanes: tuple, surface: "Coated", state: State, n_active: int) -> None:
        """Wear the bars under the listed points at the end of the step (surface is modified)."""
        start, deepest = surface.kept * surface.depth_at_yield, surface.thickness
        if surface.carried != 0.0:  # on a rigid casing only rounding errors reach further
            deepest = surface.kept * surface.thickness - start
        for a in range(n_active):
            i = state.active[a]
            bar = surface.bar[i]
            new = surface.kept * v.load(lanes, surface.reached, i) - start
            new = v.select(new < deepest, new, deepest)
            v.store(surface.worn, bar, v.larger(new, v.load(lanes, surface.worn, bar)))

    @staticmethod
    @compiled(inline=True, inner=True)
    def give_up(state: State, law: Any, n_active: int) -> None:
        """Report the lanes that are stuck as lanes without a solution (state is modified)."""
        for lane in range(state.report.shape[1]):
            if state.report[STUCK, lane] != 0.0:
                state.report[UNSOLVED, lane] = 1.0


Surface = Hard | Coated


def surface_of(scene: Scene, grid: Grid, n_points: int, width: int) -> Surface:
    """Make the surface before n_points contact points (padded), for idle lanes."""
    if scene.coating or scene.elastic_casing:
        return Coated.allocate(scene, grid, n_points, width)
    return Hard()
