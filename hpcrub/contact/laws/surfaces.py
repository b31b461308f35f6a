"""What a contact point meets: a hard casing, or a coating that wears and a casing that gives.

A surface pushes with N(p) against a point that is p inside it at the end of a step, a function that
never falls. Let d be the penetration that all other forces leave and x = W N the depth that the own
one undoes, W the compliance of the point in a step, so that p = d − x. A line N = K p + B is then

    x = γ (K d + B),   γ = W/(1 + W K),

and the least or largest of several lines is that of their x, in the same order. A coating is a row
of bars around the casing, one for every time step of a turn; where points stand at different axial
places, a row for each (a strip). A bar of thickness t and worn depth w pushes with

    N = max(0, min(k₁ (p − w), k₂ p + c₀)),   k₁ = E A/t,  k₂ = k₁ H/(E + H),  c₀ = A E σ_Y/(E + H)

against a point that is p inside the new coating, after which its worn depth is

    w ← max(w, E/(E + H) (p − σ_Y t/E)),   at most t.

The second line does not depend on w. Behind p = t stands the casing: rigid, or with a spring and
a damper, k (p − t) + d ṗ ≥ 0, ṗ the difference to the step before over the step. A casing that
gives without coating is one whose coating has no thickness. Neither bars nor casing move by
themselves, so that no stiffness makes a step unstable; but a step that is long beside the rebound
of a tip damps it (`setup.plausibility`). k → ∞ is the hard casing. Legrand, Batailly,
Magnain, Cartraud, Pierre (2012); Batailly, Agrapart, Millecamps, Brunel (2016).
"""

from typing import Any, NamedTuple

import numpy as np

from hpcrub.contact.arrays import UNSOLVED, State
from hpcrub.contact.jit import compiled
from hpcrub.contact.lanes import (
    aligned_zeros,
    any_lane,
    below,
    fma,
    inverse,
    larger,
    load,
    positive_part,
    select,
    splat,
    store,
)
from hpcrub.contact.laws.blades import solve_stuck

BEFORE, BEYOND, START = range(3)  # rows of `Coated.bars`: k₁, k₂ and c₀
LINES = 4  # before and beyond yield, both without and with the casing behind


class Hard(NamedTuple):
    """A rigid casing: N ≥ 0, p ≤ 0, N p = 0. A point carries a force (1) or none (0)."""

    @staticmethod
    def per_lane() -> tuple[str, ...]:
        """No arrays."""
        return ()

    def fill(self, lane: int, scene: Any, h: float) -> None:
        """Nothing depends on the lane."""

    def memory(self, lane: int) -> None:
        """Nothing."""

    @staticmethod
    @compiled(inline=True, inner=True)
    def tick(surface: "Hard") -> None:
        """See `Coated.tick`; these all do what those do."""

    @staticmethod
    @compiled(inline=True, inner=True)
    def meet(lanes: tuple, surface: "Hard", state: State, deepest: np.ndarray) -> np.ndarray:
        """The deepest penetration (L,) [m]."""
        return deepest

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


def find_gains(lanes: tuple, surface: Any, j: int, compliance: np.ndarray) -> None:
    """Gains γ of the lines of a point from its compliance W (L,) [m/N] (surface is modified)."""
    one = splat(lanes, 1.0)
    before, beyond = splat(lanes, surface.bars[BEFORE, j]), splat(lanes, surface.bars[BEYOND, j])
    store(surface.gain, LINES * j, compliance * inverse(fma(compliance, before, one)))
    store(surface.gain, LINES * j + 1, compliance * inverse(fma(compliance, beyond, one)))
    if surface.carried == 0.0:
        behind = select(below(splat(lanes, 0.0), compliance), one, splat(lanes, 0.0))
        store(surface.gain, LINES * j + 2, behind)
        store(surface.gain, LINES * j + 3, behind)
        return
    behind = splat(lanes, surface.stiffness) + load(lanes, surface.lag, 0)
    before, beyond = before + behind, beyond + behind
    store(surface.gain, LINES * j + 2, compliance * inverse(fma(compliance, before, one)))
    store(surface.gain, LINES * j + 3, compliance * inverse(fma(compliance, beyond, one)))


gains_found = compiled(find_gains, inner=True)


class Coated(NamedTuple):
    """Z strips of S bars before C contact points (padded), and the casing behind, in L lanes.

    State.penetration is that of the worn surface from `meet` on. The code of a line is 1 or 2
    before or beyond yield, 3 or 4 the same with the casing behind, 0 without force.
    """

    gain: np.ndarray  # γ (4·C, L) [m/N], of a rigid casing behind 1 (modified)
    lag: np.ndarray  # d/h of the casing (1, L) [N/m]
    worn: np.ndarray  # worn depth of every bar, strip by strip (Z·S, L) [m] (modified)
    reached: np.ndarray  # place in the new coating at the end of a step (C, L) [m] (modified)
    last: np.ndarray  # penetration of the casing in the step before (C, L) [m] (modified)
    filled: np.ndarray  # clock at which a lane was filled (1, L) [steps] (modified)
    clock: np.ndarray  # steps taken, and the last in which anything touched (2,) int (modified)
    strip: np.ndarray  # of every point (C,) int
    offset: np.ndarray  # angle of every point, in bars (C,) int
    bar: np.ndarray  # row of ``worn`` under every point (C,) int (modified)
    bars: np.ndarray  # k₁, k₂ and c₀ of every point (3, C) [N/m, N/m, N]
    n_steps: int  # S
    kept: float  # E/(E + H) [-]
    depth_at_yield: float  # [m]
    thickness: float  # [m]
    stiffness: float  # k of the casing [N/m]; 1 of a rigid one
    carried: float  # 1; 0 of a rigid casing, whose force the coating adds nothing to

    @staticmethod
    def per_lane() -> tuple[str, ...]:
        """Arrays whose last axis are the lanes."""
        return "gain", "lag", "worn", "reached", "last", "filled"

    @classmethod
    def allocate(cls, scene: Any, grid: Any, n_points: int, width: int) -> "Coated":
        """Surface of idle lanes; n_points: padded."""
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
            gain=aligned_zeros((LINES * n_points, width)),
            lag=aligned_zeros((1, width)),
            worn=aligned_zeros(((strip.max() + 1) * n_steps, width)),
            reached=aligned_zeros((n_points, width)),
            last=aligned_zeros((n_points, width)),
            filled=aligned_zeros((1, width)),
            clock=np.array([0, -1]),
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
        )

    def fill(self, lane: int, scene: Any, h: float) -> None:
        """Give a lane a new coating; h: its step [s] (surface is modified)."""
        self.filled[0, lane] = self.clock[0] % self.n_steps
        self.lag[0, lane] = scene.elastic_casing.damping / h if scene.elastic_casing else 0.0

    def worn_depth(self, lane: int) -> np.ndarray:
        """Worn depths around the casing (Z, S) [m], bar e at the angle 2πe/S of the casing."""
        worn = self.worn[:, lane].reshape(-1, self.n_steps)
        return np.roll(worn, -int(self.filled[0, lane]), axis=1)

    def memory(self, lane: int) -> tuple[np.ndarray, np.ndarray]:
        """Worn depths from where the disk stands (Z, S) and `reached` in the last step (C,) [m]."""
        worn = self.worn[:, lane].reshape(-1, self.n_steps)
        touched = self.clock[1] == self.clock[0]
        reached = np.where(touched, self.reached[:, lane], 0.0)
        return np.roll(worn, -(self.clock[0] % self.n_steps), axis=1), reached

    def remember(self, lane: int, memory: tuple[np.ndarray, np.ndarray]) -> None:
        """Give a lane that has just been filled a `memory` of as many steps a turn (modified)."""
        worn, reached = memory
        if self.clock[1] != self.clock[0]:  # nobody touched in the last step
            self.reached[:] = 0.0
            self.clock[1] = self.clock[0]
        self.worn[:, lane] = np.roll(worn, self.clock[0] % self.n_steps, axis=1).ravel()
        self.reached[:, lane] = reached

    @staticmethod
    @compiled(inline=True, inner=True)
    def tick(surface: "Coated") -> None:
        """A step begins (surface is modified)."""
        surface.clock[0] += 1

    @staticmethod
    @compiled(inner=True)
    def meet(lanes: tuple, surface: "Coated", state: State, deepest: np.ndarray) -> np.ndarray:
        """Find the bars, and penetrations of what is left of them (surface, state are modified).

        Returns (L,); the deepest penetration [m].
        """
        follows, now = surface.clock[1] == surface.clock[0] - 1, surface.clock[0] % surface.n_steps
        surface.clock[1] = surface.clock[0]
        zero, thickness = splat(lanes, 0.0), splat(lanes, surface.thickness)
        deepest = splat(lanes, -np.inf)
        for i in range(surface.strip.shape[0]):
            at = now + surface.offset[i]
            at = at - surface.n_steps if at >= surface.n_steps else at
            surface.bar[i] = surface.strip[i] * surface.n_steps + at
            last = positive_part(load(lanes, surface.reached, i) - thickness)
            store(surface.last, i, last if follows else zero)
            p = load(lanes, state.penetration, i)
            store(surface.reached, i, p)
            p = p - load(lanes, surface.worn, surface.bar[i])
            store(state.penetration, i, p)
            deepest = larger(p, deepest)
        return deepest

    @staticmethod
    @compiled(inline=True, inner=True)
    def comply(lanes: tuple, surface: "Coated", j: int, compliance: np.ndarray) -> None:
        """Lines of point j, which a unit force moves by ``compliance`` (L,) [m/N] in a step."""
        gains_found(lanes, surface, j, compliance)

    @staticmethod
    @compiled(inner=True)
    def follow(
        lanes: tuple, surface: "Coated", j: int, d: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Depth x (L,) [m] that the force of point j undoes of d [m], and the code of its line."""
        zero, worn = splat(lanes, 0.0), load(lanes, surface.worn, surface.bar[j])
        before = splat(lanes, surface.bars[BEFORE, j]) * d
        beyond = fma(
            splat(lanes, surface.bars[BEYOND, j]), d + worn, splat(lanes, surface.bars[START, j])
        )
        x = load(lanes, surface.gain, LINES * j) * before
        other = load(lanes, surface.gain, LINES * j + 1) * beyond
        yields = below(other, x)
        x, code = select(yields, other, x), select(yields, splat(lanes, 2.0), splat(lanes, 1.0))
        behind = (d + worn) - splat(lanes, surface.thickness)
        pressed = below(zero, behind)
        if any_lane(pressed):
            lag, carried = load(lanes, surface.lag, 0), splat(lanes, surface.carried)
            push = (splat(lanes, surface.stiffness) + lag) * behind
            push = push - lag * load(lanes, surface.last, j)
            both = load(lanes, surface.gain, LINES * j + 2) * fma(carried, before, push)
            other = load(lanes, surface.gain, LINES * j + 3) * fma(carried, beyond, push)
            yields = below(other, both)
            both = select(pressed, select(yields, other, both), x)
            pushes = below(x, both)
            both_code = select(yields, splat(lanes, 4.0), splat(lanes, 3.0))
            x, code = select(pushes, both, x), select(pushes, both_code, code)
        return positive_part(x), select(below(zero, x), code, zero)

    @staticmethod
    @compiled(inner=True)
    def line(
        lanes: tuple, surface: "Coated", j: int, code: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Slope (L,) [-] and start (L,) [m] of the line x = slope·d + start of a code."""
        zero, worn = splat(lanes, 0.0), load(lanes, surface.worn, surface.bar[j])
        before, beyond = (
            splat(lanes, surface.bars[BEFORE, j]), splat(lanes, surface.bars[BEYOND, j])
        )  # fmt: skip
        first = fma(beyond, worn, splat(lanes, surface.bars[START, j]))
        gain, other = (
            load(lanes, surface.gain, LINES * j), load(lanes, surface.gain, LINES * j + 1)
        )  # fmt: skip
        yields = below(splat(lanes, 1.5), code)
        slope = select(yields, other * beyond, gain * before)
        start = select(yields, other * first, zero)
        pressed = below(splat(lanes, 2.5), code)
        if any_lane(pressed):
            lag, carried = load(lanes, surface.lag, 0), splat(lanes, surface.carried)
            behind = splat(lanes, surface.stiffness) + lag
            push = behind * (worn - splat(lanes, surface.thickness))
            push = push - lag * load(lanes, surface.last, j)
            gain = load(lanes, surface.gain, LINES * j + 2)
            other = load(lanes, surface.gain, LINES * j + 3)
            yields = below(splat(lanes, 3.5), code)
            both = select(
                yields, other * fma(carried, beyond, behind), gain * fma(carried, before, behind)
            )
            slope = select(pressed, both, slope)
            both = select(yields, other * fma(carried, first, push), gain * push)
            start = select(pressed, both, start)
        touches = below(zero, code)
        return select(touches, slope, zero), select(touches, start, zero)

    @staticmethod
    @compiled(inline=True, inner=True)
    def check(
        lanes: tuple, surface: "Coated", j: int, p: np.ndarray, x: np.ndarray, code: np.ndarray,
        limit: np.ndarray, trying: np.ndarray,
    ) -> np.ndarray:  # fmt: skip
        """1 and the right code where x (L,) [m] is not the depth that the force at p (L,) undoes.

        limit: (L,) tolerance [m].
        trying: (L,) bool, lanes that count (their ``reached`` is modified).
        """
        worn = load(lanes, surface.worn, surface.bar[j])
        store(surface.reached, j, select(trying, p + worn, load(lanes, surface.reached, j)))
        right, found = surface.follow(lanes, surface, j, p + x)
        zero, off = splat(lanes, 0.0), right - x
        off = larger(off, zero - off)
        return select(below(limit, off), splat(lanes, 1.0) + found, zero)

    @staticmethod
    @compiled(inline=True, inner=True)
    def change(lanes: tuple, code: np.ndarray, wrong: np.ndarray) -> np.ndarray:
        """The code that `check` has found, where it was not right."""
        return select(below(splat(lanes, 0.0), wrong), wrong - splat(lanes, 1.0), code)

    @staticmethod
    @compiled(inner=True)
    def wear(lanes: tuple, surface: "Coated", state: State, n_active: int) -> None:
        """Worn depths under the first points of ``state.active`` after the step (modified)."""
        kept = splat(lanes, surface.kept)
        start = splat(lanes, surface.kept * surface.depth_at_yield)
        most = splat(lanes, surface.thickness)
        for a in range(n_active):
            i = state.active[a]
            bar = surface.bar[i]
            new = kept * load(lanes, surface.reached, i) - start
            new = select(below(new, most), new, most)
            store(surface.worn, bar, larger(new, load(lanes, surface.worn, bar)))

    @staticmethod
    @compiled(inline=True, inner=True)
    def despair(state: State, law: Any, n_active: int) -> None:
        """Say that the lanes marked in ``law.right`` have no solution (state is modified)."""
        for lane in range(state.report.shape[1]):
            if law.right[0, lane] != 0.0:
                state.report[UNSOLVED, lane] = 1.0


def surface_of(scene: Any, grid: Any, n_points: int, width: int) -> Hard | Coated:
    """Surface of idle lanes before n_points contact points (padded)."""
    if scene.coating or scene.elastic_casing:
        return Coated.allocate(scene, grid, n_points, width)
    return Hard()
