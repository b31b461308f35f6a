"""Lanes that integrate the speeds of a band, each to its steady state.

All speeds of a band lie on one rung of `revolution` and take the same number of steps per
revolution. At every step they have turned by the same angle, see the same casing and share its
table; only the step length differs. A band is integrated in *blocks* of whole bump pitches. A lane
whose speed has reached its steady state takes the next waiting speed at the next block.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from hpcrub.contact import bank, integrate, status
from hpcrub.contact.arrays import FLAW, SWEEPS, UNSOLVED, Bank, packed, take_lanes
from hpcrub.contact.observers import Record, strokes
from hpcrub.contact.status import DIVERGED
from hpcrub.model.reduction import Modes
from hpcrub.response.casing_motion import Runaway, largest, share_of_energy
from hpcrub.response.ensemble import LastWindow, Recent, Windows
from hpcrub.response.growth import Waves, record_step
from hpcrub.response.revolution import Grid
from hpcrub.response.scene import Scene, enough
from hpcrub.response.sliding import permanent_contact
from hpcrub.response.steady import check_blocks, localisation
from hpcrub.response.wear import Wearing

PIECE = 16384  # steps between two polls, if a block is not longer
UNSEEN = 4  # revolutions after which a casing that vibrates is looked at
NEVER = 1e-9  # decay rate [1/s] that stands for a motion that grows by itself


def judge(lanes: Bank, lane: int, size: np.ndarray, scene: Scene) -> int:
    """Code of ``status`` for an error in a lane so far; size: largest displacements [m].

    A flaw of the Delassus operator counts only once the lane has touched the casing.
    """
    state = lanes.state
    touched = state.report[SWEEPS, lane] > 0.0
    flaw = int(state.report[FLAW, lane]) if touched else status.NONE
    if flaw in status.FATAL:
        return flaw
    if state.report[UNSOLVED, lane] > 0.0:
        return status.UNSOLVED
    if not (np.isfinite(state.position[:, lane]).all() and np.isfinite(size).all()):
        return status.NOT_FINITE
    largest = size.max()
    if largest >= scene.interface.radius.max():
        return status.TOO_LARGE
    return flaw if largest < scene.furthest else status.BENT


def watch_of(modes: Modes, scene: Scene, speed_hz: float) -> Any:
    """Rule that ends the integration at a speed [Hz]; modes: at this speed."""
    slowest = float((modes.damping_ratios(scene.damping_ratio) * modes.rows.omega).min())
    decay = max(slowest, NEVER)  # a mode that grows in air never settles
    kind = Windows if scene.steady.rule == "ensemble" else LastWindow
    rule = kind(scene.steady, decay, scene.steady.window_revolutions / speed_hz)
    return Wearing(rule, scene.at(speed_hz)) if scene.coating else rule


class SpeedEnd(NamedTuple):
    """A speed whose motion has ended with an amplitude, as an observer of a sweep sees it."""

    speed_hz: float  # of rotation [Hz]
    modes: Modes  # at this speed
    scene: Scene
    bank: Bank  # state of all lanes at the end of the last window
    lane: int  # lane of the speed
    last: np.ndarray  # observed displacements of the records of the last window (R, O) [m]


Observers = Mapping[str, Callable[[SpeedEnd], float]]  # {name of a quantity: its function}


class Point(NamedTuple):
    """A speed of a disk that waits for a lane."""

    disk: int  # its number
    speed: int  # its number
    modes: Modes  # of the disk
    out: Any  # SweepResult of the disk, to be filled
    motion: Any = None  # Motion at all speeds to start from and to be filled; None: rest


class Course:
    """Integration of one speed in a lane: its start, its next check and its rule."""

    def __init__(
        self, point: Point, speed_hz: float, modes: Modes, scene: Scene, grid: Grid, start: int
    ) -> None:
        """Start at a block; modes: at this speed."""
        self.point, self.index, self.speed_hz, self.start = point, point.speed, speed_hz, start
        self.modes = modes
        self.per_turn, steady = grid.blocks_per_revolution, scene.steady
        first, self.extension = check_blocks(steady, speed_hz, self.per_turn)
        self.check = start + first
        self.cap = start + math.floor(steady.max_time * speed_hz * self.per_turn)
        self.is_ensemble = steady.rule == "ensemble"
        self.window = steady.window_revolutions * self.per_turn
        self.watch = watch_of(modes, scene, speed_hz)
        self.touched = start, np.zeros(0)  # a block, and `steps_touched` of the law there
        vibrates = len(modes.pairs.omega) > 0
        self.runaway = Runaway(modes.pairs, scene, self.per_turn) if vibrates else None

    def seconds(self, now: int) -> float:
        """Time from the start to a block [s]."""
        return (now - self.start) / (self.speed_hz * self.per_turn)

    def records_from(self) -> int:
        """First block to record: two windows before a check, or the start."""
        return self.start if self.watch.always else self.check - 2 * self.window

    def next_event(self, now: int) -> int:
        """Block of the next check, the begin of the window before it, or a window's end."""
        if self.watch.always:
            return min(self.check, now + self.window - (now - self.start) % self.window)
        last = self.check - self.window
        return last if last > now else self.check

    def may_end(self, now: int) -> bool:
        """Whether a verdict is possible at the end of the window that holds a block."""
        ends = self.is_over or self.watch.may_end(self.seconds(self.check))
        return self.check - self.window <= now and ends

    @property
    def is_over(self) -> bool:
        """Whether the next check, or the present one, is the last that time allows."""
        if self.is_ensemble:
            return self.check + self.extension > self.cap
        return self.cap - self.check < self.window  # the windows of two checks must not overlap


class Band:
    """Lanes that integrate the speeds of one band, of one disk or of disks with a common basis."""

    def __init__(
        self,
        modes: Modes,
        scene: Scene,
        grid: Grid,
        speeds_hz: np.ndarray,
        width: int,
        observers: Observers = MappingProxyType({}),
    ) -> None:
        self.modes, self.scene, self.grid, self.speeds_hz = modes, scene, grid, speeds_hz
        self.observers = observers
        self.bank = bank.allocate(modes, scene, grid, width)
        self.window = scene.steady.window_revolutions * grid.blocks_per_revolution
        self.waves = Waves.of(scene.interface.observed_blade, modes.pairs)
        self.most_blocks = max(1, PIECE // grid.steps_per_block)  # between two polls
        if len(modes.pairs.omega):  # a casing that runs away goes on until the next
            self.most_blocks = min(self.most_blocks, UNSEEN * grid.blocks_per_revolution)
        kept = 2 * self.window, grid.stride, grid.look, self.most_blocks
        self.record = Record.allocate(self.bank, *kept)
        self.lanes: list[Course | None] = [None] * width

    def run(self, waiting: list[Point], poll: Any) -> Iterator[Point]:
        """Integrate the points that wait, in this order (modified), and yield each that ends."""
        now = 0
        for lane in range(len(self.lanes)):
            self._refill(lane, waiting, now)
        while self._running():
            courses = [course for _, course in self._running()]
            begin = min(course.records_from() for course in courses)  # block from which to record
            event = begin if begin > now else min(course.next_event(now) for course in courses)
            until = min(event, now + self.most_blocks)
            place = now % (2 * self.window) if begin <= now else -1
            observer = self.record._replace(begin=place, watched=self._watched(now))
            integrate.run(self.bank, until - now, observer)
            self._follow(now, until)
            before, now = now, until
            if poll is not None:
                poll()
            for lane, course in self._running():
                if course.check - self.window == now:  # the last window before a check begins
                    course.touched = now, self.bank.law.steps_touched(lane)
                ended = self._ran_away(lane, course, before, now)
                if ended or (course.check == now and self._finished(lane, course, now)):
                    course.point.out.n_steps += (now - course.start) * self.grid.steps_per_block
                    self._refill(lane, waiting, now)
                    yield course.point
            self._narrow()

    def _narrow(self) -> None:
        """Drop idle lanes where fewer lanes are enough, whose steps cost less."""
        running = [lane for lane, _ in self._running()]
        fewest = enough(self.scene.lanes, len(running))
        if not len(running) <= fewest < len(self.lanes):
            return
        idle = [lane for lane, course in enumerate(self.lanes) if course is None]
        kept = (running + idle)[:fewest]
        self.bank, self.record = self.bank.take(kept), packed(take_lanes(self.record, kept))
        self.lanes = [self.lanes[lane] for lane in kept]

    def _follow(self, now: int, until: int) -> None:
        """Pass the blocks from ``now`` on to the rules that need every block."""
        for lane, course in self._running():
            if not course.watch.always:
                continue
            places = np.arange(now, until) % (2 * self.window)
            peak = self._peaks()[places, :, lane].max(axis=1)
            for block, size in zip(range(now + 1, until + 1), peak, strict=True):
                course.watch.see(size, course.seconds(block))
            if (until - course.start) % self.window == 0:
                self._keep_worn(lane, course, until)

    def _keep_worn(self, lane: int, course: Course, now: int) -> None:
        """Pass the worn depth of a lane to a rule that needs it."""
        if course.watch.always:
            revolutions = (now - course.start) // self.grid.blocks_per_revolution
            course.watch.keep(revolutions, self.bank.law.surface.worn_depth(lane))

    def _running(self) -> list[tuple[int, Course]]:
        """List of (lane, Course) for every lane that has a speed."""
        return [(lane, course) for lane, course in enumerate(self.lanes) if course]

    def _watched(self, now: int) -> np.ndarray:
        """Lanes whose stresses are observed from block ``now`` on (A,) int.

        Stresses are observed where the rule needs every block, or where a verdict is possible at
        the end of the window, from whose begin the largest stress counts.
        """
        running = self._running() if self.scene.observes_stress else []
        running = [(k, c) for k, c in running if c.watch.always or c.may_end(now)]
        begun = [k for k, c in running if not c.watch.always and c.check - self.window == now]
        self.record.stress_peak[:, begun] = 0.0
        return np.array([lane for lane, _ in running], dtype=np.int64)

    def _refill(self, lane: int, waiting: list[Point], now: int) -> None:
        """Put the next waiting point into a lane; leave the lane idle if there is none."""
        self.lanes[lane] = None
        if not waiting:
            bank.empty_lane(self.bank, lane)
            return
        point = waiting.pop(0)
        speed = self.speeds_hz[point.speed]
        modes, h = point.modes.at(speed), 1.0 / (speed * self.grid.steps_per_revolution)
        bank.fill_lane(self.bank, lane, modes, self.scene.at(speed), h)
        if point.motion is not None:
            bank.set_motion(self.bank, lane, *(m[point.speed] for m in point.motion))
        self.record.stress_peak[:, lane] = 0.0
        self.lanes[lane] = Course(point, speed, modes, self.scene, self.grid, now)

    def _ran_away(self, lane: int, course: Course, before: int, now: int) -> bool:
        """End a lane whose casing ran away in the last blocks; whether it did."""
        if course.runaway is None:
            return False
        ends = self.record.ends[:, lane].reshape(self.most_blocks, -1)
        n = course.runaway.see(ends[: now - before])
        if n:
            growth = course.runaway.growth(course.speed_hz)
            casing = course.point.out.casing
            casing.waves[course.index], casing.growth[course.index] = growth
            reason = course.runaway.reason(course.speed_hz)
            self._end(lane, course, before + n, DIVERGED, reason)
        return n > 0

    def _finished(self, lane: int, course: Course, now: int) -> bool:
        """Check a lane; if it ends here, write its result and return True."""
        windows = self._windows(now)
        sizes = self._peaks()[windows, :, lane].max(axis=1)  # (2, O) [m]
        reason, outcome = judge(self.bank, lane, sizes, self.scene), DIVERGED
        begin, touched = course.touched
        steps = (now - begin) * self.grid.steps_per_block
        share = (self.bank.law.steps_touched(lane) - touched) / steps
        stuck = permanent_contact(share, course.modes, self.scene, course.speed_hz)
        if stuck == status.FLUTTER and reason not in status.FATAL:
            reason = stuck  # the motion grows without bound: another window adds nothing
        if reason not in status.FATAL:
            verdict = self._look(lane, course, now, windows, sizes)
            if verdict is None:
                return False
            outcome, (stroke, jump) = verdict.status, self._strokes(lane, now)
            if stuck:
                outcome, reason = DIVERGED, stuck
            else:
                self._write(lane, course, now, verdict, stroke)
                reason = reason or verdict.reason
            if reason == status.NONE and self._reverses(jump):
                reason = status.REVERSED
        if outcome != DIVERGED:
            self._keep_worn(lane, course, now)
            course.watch.write(course.index, course.point.out.wear)
        self._end(lane, course, now, outcome, reason)
        if (motion := course.point.motion) is not None:
            for values, end in zip(motion, bank.motion(self.bank, lane), strict=True):
                values[course.index] = end
        return True

    def _end(self, lane: int, course: Course, now: int, outcome: int, reason: int) -> None:
        """Write status, reason and time of a speed that ends."""
        index, out = course.index, course.point.out
        out.point_status[index], out.point_reason[index] = outcome, reason
        out.max_sweeps[index] = min(self.bank.state.report[SWEEPS, lane], 255)
        out.time[index] = course.seconds(now)

    def _write(self, lane: int, course: Course, now: int, verdict: Any, stroke: float) -> None:
        """Write the amplitudes of a Verdict, and data of the last window.

        stroke: largest peak-to-peak displacement in the last window [m].
        """
        index, out, modes = course.index, course.point.out, course.modes
        pairs, last = modes.pairs, self._windows(now)[1]
        out.amplitude[index] = verdict.amplitude
        out.error[index], out.scatter[index] = verdict.error, verdict.scatter
        out.growth_shows[index] = verdict.shows
        if self.scene.observes_stress:
            out.stress[index] = self.record.stress_peak[0, lane]
        out.half_peak_to_peak[index] = stroke / 2.0
        out.localisation[index] = localisation(self.scene.interface.of_blades(verdict.largest))
        if len(pairs.omega):
            n = 2 * len(pairs.omega)
            records = self.record.casing[:, lane].reshape(2 * self.window, -1, n)[last]
            moved = largest(pairs, records.reshape(-1, n))
            out.casing.largest[index], out.casing.waves[index] = moved
            out.casing.share[index] = share_of_energy(modes, self.bank, lane)
        if self.observers:
            seen = self._history()[last, :, :, lane]
            seen = seen[..., : len(modes.observed)].reshape(-1, len(modes.observed))
            end = SpeedEnd(course.speed_hz, modes, self.scene, self.bank, lane, seen)
            for name, observe in self.observers.items():
                out.observed[name][index] = observe(end)

    def _strokes(self, lane: int, now: int) -> tuple[float, float]:
        """Largest stroke in the last window and jump in the last two [m]; see `strokes`."""
        n_observed, n_rows = self.bank.scheme.observed.shape[1], len(self.modes.observed)
        records = self.grid.steps_per_block // self.grid.stride  # of a block
        oldest = now % (2 * self.window) * records
        return strokes(self.record.history, lane, n_observed, n_rows, oldest)

    def _reverses(self, jump: float) -> bool:
        """Whether a tip of a planar disk outruns its rotation; jump: between two records [m]."""
        if len(self.modes.axial) > 0:  # friction turns with the slip
            return False
        turned = 2.0 * np.pi * self.grid.stride / self.grid.steps_per_revolution
        return jump > turned * self.scene.interface.radius.min()

    def _look(self, lane: int, course: Course, now: int, windows: Any, sizes: np.ndarray) -> Any:
        """Verdict on the last two windows; None: go on. Sets the block of the next check."""
        history, n_casing = self._history(), self.bank.scheme.casing
        casing = self.record.casing.reshape(*history.shape[:2], n_casing, len(self.lanes))
        step, n_rows = record_step(self.window, history.shape[1]), len(self.modes.observed)

        def signals(row: int) -> Any:  # places in the ring stand for the blocks of a window
            return tuple(history[window, :, row, lane].ravel() for window in windows)

        def waves(window: Any) -> Any:
            kept = history[:, ::step, :n_rows, lane], casing[:, ::step, :, lane]
            return self.waves.seen(*(part[windows[window]] for part in kept))

        recent = Recent(sizes, signals, waves)
        verdict = course.watch.look(recent, course.seconds(now), course.is_over)
        course.check = min(now + course.extension, course.cap)
        return verdict

    def _windows(self, now: int) -> np.ndarray:
        """Places in the ring of the last two windows, the older one first (2, blocks).

        The ring holds just these two windows; the place of the next block, ``now``, is the oldest.
        """
        return (now + np.arange(2 * self.window).reshape(2, -1)) % (2 * self.window)

    def _history(self) -> np.ndarray:
        """Observed displacements of the ring (blocks, records, O, lanes) [m]."""
        n_observed = self.bank.scheme.observed.shape[1]
        return self.record.history.reshape(2 * self.window, -1, n_observed, len(self.lanes))

    def _peaks(self) -> np.ndarray:
        """Largest observed displacements of the blocks in the ring (blocks, O, lanes) [m]."""
        peak = self.record.peak.reshape(2 * self.window, -1, len(self.lanes))
        return peak[:, : len(self.modes.observed)]
