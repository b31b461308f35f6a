"""Lanes that integrate the speeds of a band, each to its steady state.

The angle is the clock. All speeds of a band, which lie on one rung of `revolution`, take the same
number of steps per revolution, so that at every step they see the same casing and share its table;
only the step length differs. A band is integrated in *blocks* of whole bump pitches. A lane whose
speed has reached its steady state takes the next waiting speed at the next block.
"""

import math
from typing import Any

import numpy as np

from hpcrub.contact import bank, integrate, status
from hpcrub.contact.arrays import FLAW, SWEEPS, UNSOLVED, Bank, take_lanes
from hpcrub.contact.lanes import WIDTH
from hpcrub.contact.observers import Record
from hpcrub.contact.status import DIVERGED
from hpcrub.model.reduction import Modes
from hpcrub.response.casing_motion import LARGEST, Runaway, largest, share_of_energy
from hpcrub.response.ensemble import LastWindow, Windows
from hpcrub.response.revolution import Grid
from hpcrub.response.scene import Scene
from hpcrub.response.sliding import permanent_contact
from hpcrub.response.steady import check_blocks, localisation
from hpcrub.response.wear import Wearing

NARROWEST = max(WIDTH // 2, 4)  # speeds left when lanes of a sweep that runs dry are halved no more
PIECE = 16384  # steps between two polls, if a block is not longer
NEVER = 1e-9  # [1/s], decay of a motion that grows by itself


def judge(lanes: Bank, lane: int, size: np.ndarray, scene: Scene) -> int:
    """What is wrong with a lane so far, as code of ``status``; size: of its displacements [m].

    A flaw of its contact forces counts once it has touched.
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
    if size.max() >= scene.interface.radius.max():
        return status.TOO_LARGE
    return flaw


def watch_of(modes: Modes, scene: Scene, speed_hz: float) -> Any:
    """The rule that ends the integration at a speed [Hz]; modes: of this speed."""
    slowest = float((modes.damping_ratios(scene.damping_ratio) * modes.joined.omega).min())
    decay = max(slowest, NEVER)  # what grows in air never settles by itself
    kind = Windows if scene.steady.rule == "ensemble" else LastWindow
    rule = kind(scene.steady, decay, scene.steady.window_revolutions / speed_hz)
    return Wearing(rule, scene.at(speed_hz)) if scene.coating else rule


class Band:
    """Lanes that integrate the speeds of one band."""

    def __init__(
        self,
        modes: Modes,
        scene: Scene,
        grid: Grid,
        speeds_hz: np.ndarray,
        width: int,
        motion: Any = None,
    ) -> None:
        self.modes, self.scene, self.grid, self.speeds_hz = modes, scene, grid, speeds_hz
        self.motion = motion
        self.bank = bank.allocate(modes, scene, grid, width)
        self.window = scene.steady.window_revolutions * grid.blocks_per_revolution
        self.record = Record.allocate(self.bank, 2 * self.window, grid.stride)
        self.speed = [None] * width  # index of the speed in each lane
        self.start = [0] * width  # block at which it started
        self.check = [0] * width  # block at which it is checked next
        self.extension = 0  # blocks from a check to the next
        self.watch: list[Any] = [None] * width  # LastWindow, Windows or Wearing
        self.touched = [(0, np.zeros(0))] * width  # a block, and steps_touched until then
        self.runaway: list[Any] = [None] * width  # of a casing that vibrates
        # blocks between two polls; a casing that vibrates is looked at after every one
        vibrates = len(modes.pairs.omega) > 0
        self.most_blocks = 1 if vibrates else max(1, PIECE // grid.steps_per_block)

    def run(self, waiting: list[int], out: Any, poll: Any) -> int:
        """Integrate the speeds ``waiting`` (indices) into ``out`` (modified); returns the steps."""
        n_steps, now = 0, 0
        for lane in range(len(self.speed)):
            self._refill(lane, waiting, now)
        while self._running():
            recording, event = self._next_event(now)
            until = min(event, now + self.most_blocks)
            place = now % (2 * self.window) if recording else -1
            observer = self.record._replace(begin=place, watched=self._watched(now))
            integrate.run(self.bank, until - now, observer)
            self._follow(now, until)
            now = until
            if poll is not None:
                poll()
            self._count_contacts(now)
            for lane in self._running():
                ended = self._ran_away(lane, now, out)
                if ended or (self.check[lane] == now and self._finished(lane, now, out)):
                    n_steps += (now - self.start[lane]) * self.grid.steps_per_block
                    self._refill(lane, waiting, now)
            self._narrow()
        return n_steps

    def _narrow(self):
        """Go on with half the lanes when the others are idle: a step of fewer lanes costs less."""
        running = self._running()
        half = len(self.speed) // 2
        if not self.scene.halves_lanes or half < NARROWEST or len(running) > half:
            return
        idle = [lane for lane, speed in enumerate(self.speed) if speed is None]
        kept = (running + idle)[:half]
        self.bank, self.record = self.bank.take(kept), take_lanes(self.record, kept)
        for name in ("speed", "start", "check", "watch", "touched", "runaway"):
            setattr(self, name, [getattr(self, name)[lane] for lane in kept])

    def _next_event(self, now):
        """Whether any lane records from block ``now`` on, and until when nothing changes."""
        checks = [self.check[lane] for lane in self._running()]
        begin = min(checks) - 2 * self.window
        if begin > now:
            return False, begin
        last_windows = [c - self.window for c in checks if c - self.window > now]
        return True, min(checks + last_windows)

    def _follow(self, now, until):
        """Look at the blocks from ``now`` on, beside the checks; of a bare casing at none."""

    def _running(self):
        """Lanes that have a speed."""
        return [lane for lane, speed in enumerate(self.speed) if speed is not None]

    def _watched(self, now):
        """Lanes whose stresses are observed from block ``now`` on (A,) int.

        Those of which a verdict may come at the end of their window, which forgets those before.
        """
        lanes = self._running() if self.scene.observes_stress else []
        lanes = [lane for lane in lanes if self._may_end(lane, now)]
        begun = [lane for lane in lanes if self.check[lane] - self.window == now]
        self.record.stress_peak[:, begun] = 0.0
        return np.array(lanes, dtype=np.int64)

    def _may_end(self, lane, now):
        """Whether a lane is in its last window before a check that may be its last one."""
        if self.check[lane] - self.window > now:
            return False
        seconds = self._seconds(lane, self.check[lane])
        return self._is_over(lane) or self.watch[lane].may_end(seconds)

    def _count_contacts(self, now):
        """Keep the contacts until now of the lanes whose last window before a check begins."""
        for lane in self._running():
            if self.check[lane] - self.window == now:
                self.touched[lane] = now, self.bank.law.steps_touched(lane)

    def _share_touched(self, lane, now):
        """Share of the last window in which every blade touched (N,); (0,) where not counted."""
        begin, before = self.touched[lane]
        steps = (now - begin) * self.grid.steps_per_block
        return (self.bank.law.steps_touched(lane) - before) / steps

    def _refill(self, lane, waiting, now):
        """Put the next waiting speed into a lane; leave the lane idle if there is none."""
        bank.empty_lane(self.bank, lane)
        self.speed[lane] = waiting.pop(0) if waiting else None
        if self.speed[lane] is None:
            return
        speed = self.speeds_hz[self.speed[lane]]
        h = 1.0 / (speed * self.grid.steps_per_revolution)
        modes = self.modes.at(speed)
        bank.fill_lane(self.bank, lane, modes, self.scene.at(speed), h)
        if self.motion is not None:
            bank.set_motion(self.bank, lane, *(m[self.speed[lane]] for m in self.motion))
        self.start[lane] = now
        self.record.stress_peak[:, lane] = 0.0
        self.watch[lane] = watch_of(modes, self.scene, speed)
        if len(modes.pairs.omega):
            limit = LARGEST * self.scene.interface.radius.max()
            self.runaway[lane] = Runaway(modes.pairs, limit, self.grid.blocks_per_revolution)
        steady, per_turn = self.scene.steady, self.grid.blocks_per_revolution
        first, self.extension = check_blocks(steady, speed, per_turn)
        self.check[lane] = now + first

    def _ran_away(self, lane, now, out):
        """End a lane whose casing runs away (out is modified), and return True if it does."""
        if self.runaway[lane] is None:
            return False
        if not self.runaway[lane].see(self.bank.state.position[-self.bank.scheme.casing :, lane]):
            return False
        index = self.speed[lane]
        growth = self.runaway[lane].growth(self.speeds_hz[index])
        out.casing.waves[index], out.casing.growth[index] = growth
        out.point_status[index], out.point_reason[index] = DIVERGED, status.RUNAWAY
        out.max_sweeps[index] = min(self.bank.state.report[SWEEPS, lane], 255)
        out.time[index] = self._seconds(lane, now)
        return True

    def _finished(self, lane, now, out):
        """Check a lane; write its result (modified) and return True if it ends here."""
        older, newer = self._windows(now)
        peak = self.record.peak.reshape(2 * self.window, -1, len(self.speed))
        peak = peak[:, : len(self.modes.observed), lane]
        before, last = peak[older].max(axis=0), peak[newer].max(axis=0)
        index = self.speed[lane]
        reason, verdict = judge(self.bank, lane, peak, self.scene), DIVERGED
        touched = self._share_touched(lane, now)
        stuck = permanent_contact(touched, self.modes, self.scene, self.speeds_hz[index])
        if stuck == status.FLUTTER and reason not in status.FATAL:
            reason = stuck  # it grows without bounds: no further window can tell more
        if reason not in status.FATAL:
            found = self._look(lane, now, before, last)
            if found is None:
                return False
            verdict = found.status
            if stuck:
                verdict, reason = DIVERGED, stuck
            else:
                self._write(lane, now, found, out)
        if verdict != DIVERGED:
            self._conclude(lane, now, out)
        if reason == status.NONE and self._reverses(lane, now):
            reason = status.REVERSED
        out.point_status[index], out.point_reason[index] = verdict, reason
        out.max_sweeps[index] = min(self.bank.state.report[SWEEPS, lane], 255)
        out.time[index] = self._seconds(lane, now)
        if self.motion is not None:
            for values, end in zip(self.motion, bank.motion(self.bank, lane), strict=True):
                values[index] = end
        return True

    def _conclude(self, lane, now, out):
        """What else a lane that ends with a result tells (out is modified)."""

    def _write(self, lane, now, found, out):
        """Amplitudes of a lane by a Verdict, and what its last window tells (out is modified)."""
        index, pairs, last = self.speed[lane], self.modes.pairs, self._windows(now)[1]
        out.amplitude[index] = found.amplitude
        out.error[index], out.scatter[index] = found.error, found.scatter
        if self.scene.observes_stress:
            out.stress[index] = self.record.stress_peak[0, lane]
        out.half_peak_to_peak[index] = np.ptp(self._signals(lane, last), axis=0).max() / 2.0
        blades = self.scene.interface.of_blades(found.largest)
        out.localisation[index] = localisation(blades)
        if len(pairs.omega):
            n, modes = 2 * len(pairs.omega), self.modes.at(self.speeds_hz[index])
            records = self.record.casing[:, lane].reshape(2 * self.window, -1, n)[last]
            moved = largest(pairs, records.reshape(-1, n))
            out.casing.largest[index], out.casing.waves[index] = moved
            out.casing.share[index] = share_of_energy(modes, self.bank, lane)

    def _reverses(self, lane, now):
        """Whether a tip of a planar disk moves faster than the disk turns in the last two windows.

        In three dimensions friction turns with the slip.
        """
        if len(self.modes.axial) > 0:
            return False
        motion = self._signals(lane, self._windows(now).ravel())
        moved = np.abs(np.diff(motion, axis=0)).max()
        turned = 2.0 * np.pi * self.grid.stride / self.grid.steps_per_revolution
        return moved > turned * self.scene.interface.radius.min()

    def _look(self, lane, now, before, last):
        """The Verdict on the windows of a lane; None, with the time of its next check: go on."""
        time = self._seconds(lane, now)

        def signals(row):
            return tuple(self._signals(lane, w)[:, row].copy() for w in self._windows(now))

        found = self.watch[lane].look(before, last, signals, time, self._is_over(lane))
        self.check[lane] = min(now + self.extension, self.start[lane] + self._cap(lane))
        return found

    def _cap(self, lane):
        """Blocks after which a lane is given up."""
        speed = self.speeds_hz[self.speed[lane]]
        return math.floor(self.scene.steady.max_time * speed * self.grid.blocks_per_revolution)

    def _is_over(self, lane):
        """Whether there is no time for another check of a lane after its next, or present, one."""
        elapsed, cap = self.check[lane] - self.start[lane], self._cap(lane)
        is_ensemble = self.scene.steady.rule == "ensemble"
        return elapsed + self.extension > cap if is_ensemble else elapsed >= cap

    def _seconds(self, lane, now):
        speed = self.speeds_hz[self.speed[lane]]
        return (now - self.start[lane]) / (speed * self.grid.blocks_per_revolution)

    def _windows(self, now):
        """Places in the ring of the blocks of the window before the last one, and of the last.

        The ring holds just these two, and block ``now`` is next: its place is the oldest.
        """
        return (now + np.arange(2 * self.window).reshape(2, -1)) % (2 * self.window)

    def _signals(self, lane, window):
        """Observed displacements over a window, places in the ring, (records, O) [m]."""
        n_observed, n = self.bank.scheme.observed.shape[1], len(self.modes.observed)
        history = self.record.history.reshape(2 * self.window, -1, n_observed, len(self.speed))
        return history[window, :, :n, lane].reshape(-1, n)
