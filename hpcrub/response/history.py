"""Whole histories of a contact run: modal coordinates and contact forces, block by block.

A sweep keeps only the records that its test of the steady state needs. This module takes the same
steps, bit for bit, and keeps every `kept`-th one, at a somewhat higher cost.
"""

import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from hpcrub.contact import status
from hpcrub.contact.arrays import Bank
from hpcrub.contact.bank import allocate, set_motion
from hpcrub.contact.bank import motion as motion_of
from hpcrub.contact.integrate import run
from hpcrub.contact.jit import compiled
from hpcrub.contact.observers import record_displacements
from hpcrub.contact.status import NOT_STEADY
from hpcrub.model.reduction import Modes
from hpcrub.response.band import judge, watch_of
from hpcrub.response.casing_motion import Runaway
from hpcrub.response.ensemble import Recent, Verdict
from hpcrub.response.growth import Waves, record_step
from hpcrub.response.revolution import Grid, cut_revolution, speed_bands
from hpcrub.response.scene import Scene
from hpcrub.response.sliding import permanent_contact
from hpcrub.response.steady import check_blocks
from hpcrub.response.sweep import Motion
from hpcrub.response.wear import Wear

LANES = (0,) * 8  # speeds integrated together


class Piece(NamedTuple):
    """R records of the motion at S speeds: one block of a history."""

    time: np.ndarray  # since the bumps began to grow (R, S) [s]
    position: np.ndarray  # modal coordinates of the disk (R, K, S) [m·√kg]
    casing: np.ndarray  # turned coordinates of the pairs of the casing (R, 2J, S) [m·√kg]
    observed: np.ndarray  # observed displacements (R, O, S) [m]
    peak: np.ndarray  # largest |observed displacement| of all looks (O, S) [m]
    normal_force: np.ndarray  # inward on each point, mean since the last record (R, C, S) [N]
    tangential_force: np.ndarray  # against the rotation of the disk (R, C, S) [N]
    axial_force: np.ndarray  # against +z (R, C, S), (R, 0, S) without axial motion [N]
    worn: Sequence[np.ndarray]  # worn depth of every bar at the end, for each speed (Z, N) [m]
    reason: np.ndarray  # (S,) uint8: code of ``status``; a fatal one stays, and voids the history
    # waves of a casing that runs away, and their rate of growth [1/s] (S, 2); NaN: it does not
    growth: np.ndarray


class Trace(NamedTuple):
    """Observer of one block: the motion after every ``stride``-th step, the forces before it."""

    position: np.ndarray  # modal coordinates (R, K, L) [m·√kg]
    observed: np.ndarray  # observed displacements (R·O, L) [m]
    peak: np.ndarray  # largest |observed displacement| of looks, then of other records (2·O, L) [m]
    force: np.ndarray  # sums of the multipliers over the steps of a record (R, F, L) [N]
    stride: int
    look: int  # steps from one look to the next

    @staticmethod
    @compiled(inner=True)
    def observe(
        lanes: tuple, bank: Bank, trace: "Trace", block: int, step: int, n_active: int
    ) -> int:
        """Record the step; see ``contact.observers``."""
        record = step // trace.stride
        for a in range(n_active):
            i = bank.state.active[a]
            for lane in range(len(lanes)):
                trace.force[record, i, lane] += bank.state.multiplier[i, lane]
        kept = record if (step + 1) % trace.stride == 0 else -1
        other = (step + 1) % trace.look != 0
        if kept >= 0 or not other:
            seen = trace.observed, trace.peak
            n_active = record_displacements(lanes, bank, *seen, kept, int(other), n_active)
        bank.basis.correct(lanes, bank, n_active)
        if kept < 0:
            return 0
        for k in range(bank.state.position.shape[0]):
            for lane in range(len(lanes)):
                trace.position[record, k, lane] = bank.state.position[k, lane]
        return 0


def n_records(speed_hz: float, duration: float, scene: Scene) -> int:
    """Number of records that `integrate` yields for a speed [Hz] and a duration [s]."""
    grid = cut_revolution(speed_hz, scene)
    return n_blocks(speed_hz, duration, grid) * (grid.steps_per_block // grid.kept)


def n_blocks(speed_hz: float, duration: float, grid: Grid) -> int:
    """Number of blocks that a duration [s] takes at a speed [Hz], rounded up."""
    # the factor keeps rounding errors from adding a block to a duration of whole blocks
    return math.ceil(duration * speed_hz * grid.blocks_per_revolution * (1.0 - 1e-12))


def checks(speed_hz: float, duration: float, scene: Scene) -> range:
    """Blocks after which a sweep would check the motion at a speed [Hz], within a duration [s]."""
    grid = cut_revolution(speed_hz, scene)
    first, extension = check_blocks(scene.steady, speed_hz, grid.blocks_per_revolution)
    return range(first, n_blocks(speed_hz, duration, grid) + 1, extension)


class Follower:
    """Judges one speed of a history as a sweep would: its amplitude and the wear of the coating."""

    def __init__(self, modes: Modes, scene: Scene, speed_hz: float, duration: float) -> None:
        """Start before the first block; duration: of the history [s]."""
        grid, self.modes = cut_revolution(speed_hz, scene), modes
        self.scene, self.speed, self.per_turn = scene, speed_hz, grid.blocks_per_revolution
        self.window = scene.steady.window_revolutions * self.per_turn
        every = grid.stride // grid.kept
        self.seen = slice(every - 1, None, every)  # records of a sweep among those of a history
        self.checks = checks(speed_hz, duration, scene)
        self.n_blocks = n_blocks(speed_hz, duration, grid)
        self.watch = watch_of(modes.at(speed_hz), scene, speed_hz)
        self.waves = Waves.of(scene.interface.observed_blade, modes.pairs)
        # observed displacements of two windows, coordinates of the casing, and peaks, by block
        self.recent: deque[tuple[np.ndarray, ...]] = deque(maxlen=2 * self.window)
        self.n_taken, self.time = 0, math.nan  # time of the last check [s]; NaN: there was none
        self.known: Verdict | None = None

    def take(self, piece: Piece, lane: int) -> None:
        """Read the next Piece, unless this speed has reached its last block or has failed."""
        if self.n_taken == self.n_blocks or status.are_fatal(piece.reason[lane]):
            return
        self.n_taken += 1
        peak = piece.peak[:, lane]
        observed, casing = (part[self.seen, :, lane] for part in (piece.observed, piece.casing))
        self.recent.append((observed, casing, peak))
        time = self.n_taken / (self.speed * self.per_turn)
        if self.watch.always:
            self.watch.see(float(peak.max()), time)
            if self.n_taken % self.window == 0 or self.n_taken == self.n_blocks:
                self.watch.keep(self.n_taken // self.per_turn, piece.worn[lane])
        if self.n_taken in self.checks and self.known is None:
            self._look(time)

    def _look(self, time: Any) -> None:
        observed, casing, peaks = map(np.array, zip(*self.recent, strict=True))
        before, last = np.split(observed, 2)
        sizes = np.array([part.max(axis=0) for part in np.split(peaks, 2)])
        over = self.n_taken == self.checks[-1]
        self.time, step = time, record_step(self.window, observed.shape[1])

        def signals(tip: Any) -> Any:
            return before[:, :, tip].ravel(), last[:, :, tip].ravel()

        def waves(window: Any) -> Any:
            kept = (np.split(part[:, ::step], 2) for part in (observed, casing))
            return self.waves.seen(*(part[window] for part in kept))

        self.known = self.watch.look(Recent(sizes, signals, waves), time, over)

    @property
    def verdict(self) -> Verdict:
        """Verdict of a sweep on this speed; not steady where the history ends too early."""
        unknown = np.full(self.scene.interface.observed.shape[0], np.nan)
        return self.known or Verdict(NOT_STEADY, unknown, math.nan, math.nan, math.nan)

    def doubt(self, reason: int, share: np.ndarray) -> int:
        """Reason against the motion in the end, a code of ``status``.

        reason: code of the last Piece; share: (N,) of the last window in which each blade touches.
        """
        if status.are_fatal(reason):
            return reason
        stuck = permanent_contact(share, self.modes, self.scene, self.speed)
        return stuck or reason or self.verdict.reason

    @property
    def wear(self) -> Wear:
        """State of the coating at the end of the history: a Wear of one speed."""
        wear = Wear.empty(1, self.scene.n_strips)
        self.watch.write(0, wear)
        return wear


def groups(speeds_hz: np.ndarray) -> list[np.ndarray]:
    """Split speeds (S,) [Hz] into index arrays, each of speeds that `integrate` takes together."""
    width, bands = len(LANES), speed_bands(speeds_hz)
    return [part for band in bands for part in np.split(band, range(width, len(band), width))]


def integrate(
    modes: Modes,
    scene: Scene,
    speeds_hz: np.ndarray,
    duration: float,
    motion: Motion | None = None,
    poll: Callable[[], object] | None = None,
) -> Iterator[Piece]:
    """Integrate a few speeds in time, and yield their histories as Pieces of one block.

    - modes: of the sample.
    - speeds_hz: speeds of one of the `groups`, (S,) [Hz].
    - duration: [s], rounded up to blocks of the fastest speed.
    - motion: initial motion, rest by default (modified: it becomes the motion at the end).
    - poll: called without arguments after every Piece; an exception from it ends the integration.

    The `reason` of the last Piece holds for the whole history; after all have failed none moves.
    """
    speeds_hz = np.asarray(speeds_hz, dtype=float)
    n_speeds = len(speeds_hz)
    motion = motion or Motion.at_rest(n_speeds, modes.n_rows)
    grid = cut_revolution(speeds_hz.min(), scene)
    bank = allocate(modes, scene, grid, len(LANES), speeds_hz)
    for lane in range(n_speeds):
        set_motion(bank, lane, *(values[lane] for values in motion))
    reason, growth = np.zeros(n_speeds, dtype=np.uint8), np.full((n_speeds, 2), np.nan)
    runaways = [Runaway(modes.pairs, scene, grid.blocks_per_revolution) for _ in speeds_hz]
    for _ in range(n_blocks(speeds_hz.max(), duration, grid)):
        piece = _piece(bank, modes, scene, grid, n_speeds, bool(status.are_fatal(reason).all()))
        for lane in np.flatnonzero(~status.are_fatal(reason)).tolist():
            reason[lane] = judge(bank, lane, piece.peak[:, lane], scene)
            if modes.pairs.omega.size and runaways[lane].see(piece.casing[-1:, :, lane]):
                reason[lane] = runaways[lane].reason(speeds_hz[lane])
                growth[lane] = runaways[lane].growth(speeds_hz[lane])
        yield piece._replace(reason=reason.copy(), growth=growth)
        if poll is not None:
            poll()
    for lane in range(n_speeds):
        for values, end in zip(motion, motion_of(bank, lane), strict=True):
            values[lane] = end


def _piece(bank: Bank, modes: Modes, scene: Scene, grid: Grid, n_speeds: int, failed: Any) -> Any:
    """Integrate one block into a Piece, without its reasons, unless failed (bank is modified)."""
    n_records, width = grid.steps_per_block // grid.kept, len(LANES)
    n_observed, n_columns = len(modes.observed), bank.scheme.observed.shape[1]
    position = np.zeros((n_records, len(bank.state.position), width))
    observed, peak = (np.zeros((n * n_columns, width)) for n in (n_records, 2))
    force = np.zeros((n_records, len(bank.state.multiplier), width))
    started = bank.state.n_steps[:n_speeds].copy()
    if failed:
        bank.state.n_steps[:n_speeds] += grid.steps_per_block
    else:
        run(bank, 1, Trace(position, observed, peak, force, grid.kept, grid.look))
    steps = started + grid.kept * np.arange(1, n_records + 1)[:, None]
    force = force[:, :, :n_speeds] / grid.kept
    normal, tangential, axial = bank.law.forces_on_points(force, scene)
    time = steps * bank.scheme.step[:n_speeds]
    parts = modes.of_rows(np.moveaxis(position[:, :, :n_speeds], 1, 2))
    position, casing = (np.moveaxis(part, 2, 1) for part in parts)
    observed = observed.reshape(n_records, n_columns, width)[:, :n_observed, :n_speeds]
    peak = peak[:n_observed, :n_speeds]
    worn = [bank.law.surface.worn_depth(k) for k in range(n_speeds if scene.coating else 0)]
    return Piece(
        time, position, casing, observed, peak, normal, tangential, axial, worn, *np.empty((2, 0))
    )
