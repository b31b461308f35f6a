"""The frequency response of one sample: many angular speeds, a few at a time.

The angle is the clock. All speeds of a *band*, which lie on one rung of `revolution`, take the same
number of steps per revolution, so that at every step they see the same casing and share its table;
only the step length differs. A band is integrated in *blocks* of whole bump pitches. A lane whose
speed has reached its steady state takes the next waiting speed at the next block.
"""

import math
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from hpcrub.contact import bank, integrate, status
from hpcrub.contact.arrays import FLAW, SWEEPS, UNSOLVED, Bank, take_lanes
from hpcrub.contact.observers import Record
from hpcrub.contact.status import DIVERGED, NOT_STEADY, STEADY
from hpcrub.model.damping import ratios
from hpcrub.model.reduction import Modes
from hpcrub.response import wear
from hpcrub.response.ensemble import LastWindow, Verdict, Windows
from hpcrub.response.revolution import Grid, cut_revolution, speed_bands
from hpcrub.response.scene import Scene, can_touch
from hpcrub.response.sliding import permanent_contact
from hpcrub.response.steady import localisation
from hpcrub.response.wear import N_ANGLES, Follower

WIDTH = 16  # speeds of a bank: two of the widest vector registers hide each other's latency
NARROWEST = 8  # speeds left when the lanes of a sweep that runs dry are no longer halved
PIECE = 16384  # steps between two polls, if a block is not longer


class Motion(NamedTuple):
    """Where every speed stands at the end of a block of a run, to go on from there."""

    position: np.ndarray  # modal coordinates (S, K) [m·√kg]
    velocity: np.ndarray  # (S, K)
    time: np.ndarray  # since the bumps began to grow (S,) [s]

    @classmethod
    def at_rest(cls, n_speeds: int, n_modes: int) -> "Motion":
        """At rest, before the bumps grow."""
        still = np.zeros((n_speeds, n_modes))
        return cls(still, still.copy(), np.zeros(n_speeds))


class SweepResult(NamedTuple):
    """Frequency response of one sample over S speeds."""

    amplitude: np.ndarray  # (S,) largest observed displacement [m]; NaN where diverged
    time: np.ndarray  # (S,) simulated [s]
    localisation: np.ndarray  # (S,) [-]
    error: np.ndarray  # (S,) standard error of the amplitude [m]; NaN: unknown
    scatter: np.ndarray  # (S,) standard deviation of the windows' amplitudes [m]; NaN: unknown
    point_status: np.ndarray  # (S,) uint8: NO_POINT, STEADY, NOT_STEADY, DIVERGED, IRREGULAR
    point_reason: np.ndarray  # (S,) uint8: code of ``status``
    max_sweeps: np.ndarray  # (S,) uint8: most sweeps of the multiplier solver in a step
    # of a coating; NaN without
    largest_amplitude: np.ndarray  # at any time, while it wore, too (S,) [m]
    largest_time: np.ndarray  # when, the end of its block (S,) [s]
    worn_depth: np.ndarray  # the largest in the end (S,) [m]
    worn_growth: np.ndarray  # the largest of any bar in the last revolutions (S,) [m]
    worn_volume: np.ndarray  # (S,) [m³]
    wear_energy: np.ndarray  # that has gone into it (S,) [J]
    lobes: np.ndarray  # of the worn depth (S,) [-]
    worn: np.ndarray  # worn depth around the casing (S, A) [m]; (S, 0) without a coating
    n_steps: int = 0  # time steps of all speeds

    @classmethod
    def empty(cls, n: int, n_angles: int = 0) -> "SweepResult":
        """Result of n speeds, none of them integrated yet; n_angles: of worn depths."""
        numbers, codes = np.full((5, n), np.nan), np.zeros((3, n), dtype=np.uint8)
        numbers[1] = 0.0
        wear = (*np.full((7, n), np.nan), np.full((n, n_angles), np.nan))
        return cls(*numbers, *codes, *wear)

    def continued(self, reason: np.ndarray) -> "SweepResult":
        """The same, less the points that have failed since; reason: codes of ``status`` (S,)."""
        lost = status.are_fatal(reason) & (self.point_status != DIVERGED)
        kept = self.amplitude, self.localisation, self.error, self.scatter
        amplitude, localisation, error, scatter = np.where(lost, np.nan, kept)
        return self._replace(
            amplitude=amplitude,
            localisation=localisation,
            error=error,
            scatter=scatter,
            point_status=np.where(lost, DIVERGED, self.point_status).astype(np.uint8),
            point_reason=np.where(lost, reason, self.point_reason).astype(np.uint8),
        )


def run_sweep(
    modes: Modes,
    scene: Scene,
    speeds_hz: npt.ArrayLike,
    poll: Callable[[], object] | None = None,
    width: int = WIDTH,
    selection: Iterable[int] | None = None,
    motion: Motion | None = None,
) -> SweepResult:
    """Integrate every speed in time to its steady state.

    - modes: modes of the sample.
    - speeds_hz: (S,) angular speeds [Hz].
    - poll: called without arguments after every PIECE of steps, some hundredths of a second; what
      it raises ends the sweep.
    - width: speeds integrated together; changes the cost, not one bit of the result.
    - selection: indices of the speeds to integrate, all by default. The steps are those of the
      whole sweep, so that parts of it computed apart are the same bits.
    - motion: to start from, rest by default (modified: the motion at the end).
    """
    speeds_hz = np.asarray(speeds_hz, dtype=float)
    n = len(speeds_hz)
    out, n_steps = SweepResult.empty(n, N_ANGLES if scene.coating else 0), 0
    wanted = set(range(n) if selection is None else selection)
    if motion is None:
        still = [i for i in wanted if not can_touch(scene.at(speeds_hz[i]))]
        _leave_at_rest(out, still, scene)
        wanted -= set(still)
    for band in speed_bands(speeds_hz):
        grid = cut_revolution(speeds_hz[band[0]], scene)
        # fastest first: they take longest to settle, and should not be left to the last lanes
        waiting = [i for i in band[::-1] if i in wanted]
        if waiting:
            n_steps += _Band(modes, scene, grid, speeds_hz, width, motion).run(waiting, out, poll)
    return out._replace(n_steps=n_steps)


def _leave_at_rest(out, still, scene):
    """The response at speeds (indices) at which nothing touches (out is modified)."""
    known = 0.0 if scene.steady.rule == "ensemble" else np.nan
    for values, rest in zip(out[:6], (0.0, 0.0, 0.0, known, known, STEADY), strict=True):
        values[still] = rest
    if scene.coating:
        for values in out[8:-1]:
            values[still] = 0.0


def judge(lanes: Bank, lane: int, size: np.ndarray, scene: Scene) -> int:
    """What is wrong with a lane so far; a flaw of its contact forces counts once it has touched.

    - lanes: after some integration.
    - lane: index.
    - size: magnitudes of its observed displacements, of any shape [m].

    Returns code of ``status``.
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


class _Band:
    """Lanes that integrate the speeds of one band."""

    def __init__(
        self,
        modes: Modes,
        scene: Scene,
        grid: Grid,
        speeds_hz: np.ndarray,
        width: int,
        motion: Motion | None = None,
    ) -> None:
        self.modes, self.scene, self.grid, self.speeds_hz = modes, scene, grid, speeds_hz
        self.motion = motion
        self.bank = bank.allocate(modes, scene, grid, width)
        self.window = scene.steady.window_revolutions * grid.blocks_per_revolution
        self.record = Record.allocate(self.bank, 2 * self.window, grid.stride)
        self.speed = [None] * width  # index of the speed in each lane
        self.start = [0] * width  # block at which it started
        self.check = [0] * width  # block at which it is checked next
        self.watch: list[Any] = [None] * width  # LastWindow or Windows
        self.ensemble = scene.steady.rule == "ensemble"
        self.touched = [(0, np.zeros(0))] * width  # a block, and steps_touched until then
        self.coating = [Follower() for _ in range(width)]  # where there is one

    def run(self, waiting, out, poll):
        """Integrate the speeds ``waiting`` (indices) into ``out`` (modified); returns the steps."""
        n_steps, now = 0, 0
        for lane in range(len(self.speed)):
            self._refill(lane, waiting, now)
        while any(speed is not None for speed in self.speed):
            recording, event = self._next_event(now)
            until = min(event, now + max(1, PIECE // self.grid.steps_per_block))
            place = now % (2 * self.window) if recording else -1
            integrate.run(self.bank, until - now, self.record._replace(begin=place))
            if self.scene.coating:
                self._follow_coating(now, until)
            now = until
            if poll is not None:
                poll()
            self._count_contacts(now)
            for lane, check in enumerate(self.check):
                if self.speed[lane] is not None and check == now and self._finished(lane, now, out):
                    n_steps += (now - self.start[lane]) * self.grid.steps_per_block
                    self._refill(lane, waiting, now)
            self._narrow()
        return n_steps

    def _narrow(self):
        """Go on with half the lanes when the others are idle: a step of fewer lanes costs less."""
        running = [lane for lane, speed in enumerate(self.speed) if speed is not None]
        half = len(self.speed) // 2
        if half < NARROWEST or len(running) > half:
            return
        idle = [lane for lane, speed in enumerate(self.speed) if speed is None]
        kept = (running + idle)[:half]
        self.bank, self.record = self.bank.take(kept), take_lanes(self.record, kept)
        for name in ("speed", "start", "check", "watch", "touched", "coating"):
            setattr(self, name, [getattr(self, name)[lane] for lane in kept])

    def _next_event(self, now):
        """Whether any lane records from block ``now`` on, and until when nothing changes."""
        checks = [c for c, s in zip(self.check, self.speed, strict=True) if s is not None]
        begin = min(checks) - 2 * self.window
        if self.scene.coating:  # amplitudes while it wears, window by window of every lane
            starts = [s for s, i in zip(self.start, self.speed, strict=True) if i is not None]
            kept = [s + ((now - s) // self.window + 1) * self.window for s in starts]
            return True, min(checks + kept)
        if begin > now:
            return False, begin
        last_windows = [c - self.window for c in checks if c - self.window > now]
        return True, min(checks + last_windows)

    def _count_contacts(self, now):
        """Keep the contacts until now of the lanes whose last window before a check begins."""
        for lane, check in enumerate(self.check):
            if self.speed[lane] is not None and check - self.window == now:
                self.touched[lane] = now, self.bank.law.steps_touched(lane)

    def _share_touched(self, lane, now):
        """Share of the last window in which every blade touched (N,); (0,) where not counted."""
        begin, before = self.touched[lane]
        steps = (now - begin) * self.grid.steps_per_block
        return (self.bank.law.steps_touched(lane) - before) / steps

    def _blocks(self, lane, seconds, rounding):
        return rounding(
            seconds * self.speeds_hz[self.speed[lane]] * self.grid.blocks_per_revolution
        )

    def _refill(self, lane, waiting, now):
        """Put the next waiting speed into a lane; leave the lane idle if there is none."""
        bank.empty_lane(self.bank, lane)
        self.speed[lane] = waiting.pop(0) if waiting else None
        if self.speed[lane] is None:
            return
        speed = self.speeds_hz[self.speed[lane]]
        h = 1.0 / (speed * self.grid.steps_per_revolution)
        modes, window = self.modes.at(speed), self.scene.steady.window_revolutions / speed
        bank.fill_lane(self.bank, lane, modes, self.scene.at(speed), h)
        if self.motion is not None:
            bank.set_motion(self.bank, lane, *(m[self.speed[lane]] for m in self.motion))
        self.start[lane], self.coating[lane] = now, Follower()
        decay = float((ratios(self.scene.damping_ratio, modes.omega) * modes.omega).min())
        kind = Windows if self.ensemble else LastWindow
        self.watch[lane] = kind(self.scene.steady, decay, window)
        first = self._blocks(lane, self.scene.steady.first_check, math.ceil)
        if self.ensemble:  # whole windows, so that all lanes are checked together
            first = -(-first // self.window) * self.window
        self.check[lane] = now + max(first, 2 * self.window)

    def _finished(self, lane, now, out):
        """Check a lane; write its result (modified) and return True if it ends here."""
        older, newer = self._windows(now)
        peak = self.record.peak.reshape(2 * self.window, -1, len(self.speed))
        peak = peak[:, : len(self.modes.observed), lane]
        before, last = peak[older].max(axis=0), peak[newer].max(axis=0)
        index = self.speed[lane]
        reason, verdict = judge(self.bank, lane, peak, self.scene), DIVERGED
        stuck = permanent_contact(self._share_touched(lane, now), self.modes, self.scene)
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
                out.amplitude[index] = found.amplitude
                out.error[index], out.scatter[index] = found.error, found.scatter
                blades = self.scene.interface.of_blades(found.largest)
                out.localisation[index] = localisation(blades)
        if self.scene.coating and verdict != DIVERGED:
            self._write_wear(lane, index, out)
        out.point_status[index], out.point_reason[index] = verdict, reason
        out.max_sweeps[index] = min(self.bank.state.report[SWEEPS, lane], 255)
        out.time[index] = self._seconds(lane, now)
        if self.motion is not None:
            for values, end in zip(self.motion, bank.motion(self.bank, lane), strict=True):
                values[index] = end
        return True

    def _look(self, lane, now, before, last):
        """The Verdict on the windows of a lane; None, with the time of its next check: go on."""
        steady, elapsed = self.scene.steady, now - self.start[lane]
        extend = steady.window_revolutions if self.ensemble else steady.extend_revolutions
        extend *= self.grid.blocks_per_revolution
        cap = self._blocks(lane, steady.max_time, math.floor)
        over = elapsed + extend > cap if self.ensemble else elapsed >= cap

        def signals(row):
            return tuple(self._signal(lane, row, window) for window in self._windows(now))

        found = self.watch[lane].look(before, last, signals, self._seconds(lane, now), over)
        if self.scene.coating:
            found = self._of_coating(lane, found, last, over)
        self.check[lane] = min(now + extend, self.start[lane] + cap)
        return found

    def _of_coating(self, lane, found, last, over):
        """What a Verdict becomes when the coating still wears, or the motion has died away."""
        known = found is not None and found.status != NOT_STEADY
        if self.coating[lane].has_ended(known, last.max()):
            return found if known else Verdict(STEADY, last, last.max(), math.nan, math.nan)
        return found._replace(status=NOT_STEADY) if over else None

    def _seconds(self, lane, now):
        speed = self.speeds_hz[self.speed[lane]]
        return (now - self.start[lane]) / (speed * self.grid.blocks_per_revolution)

    def _follow_coating(self, now, until):
        """Look at the amplitudes of the blocks from ``now`` on; keep the coating by windows.

        Of a lane's own windows, so that it does not matter when those beside it are checked.
        """
        places = np.arange(now, until) % (2 * self.window)
        peak = self.record.peak.reshape(2 * self.window, -1, len(self.speed))[places]
        peak = peak[:, : len(self.modes.observed)].max(axis=1)
        for lane, speed in enumerate(self.speed):
            if speed is None:
                continue
            for block, size in zip(range(now + 1, until + 1), peak[:, lane], strict=True):
                self.coating[lane].see(size, self._seconds(lane, block))
            if (until - self.start[lane]) % self.window == 0:
                revolutions = (until - self.start[lane]) // self.grid.blocks_per_revolution
                self.coating[lane].keep(revolutions, self.bank.law.surface.worn_depth(lane))

    def _write_wear(self, lane, index, out):
        """What became of the coating of a lane (out is modified)."""
        followed, worn = self.coating[lane], self.bank.law.surface.worn_depth(lane)
        radius = float(self.scene.interface.radius.max())
        out.largest_amplitude[index] = followed.largest
        out.largest_time[index] = followed.time
        out.worn_depth[index], out.worn_growth[index] = worn.max(), followed.growth
        out.worn_volume[index] = wear.volume(worn, self.scene.coating, radius)
        out.wear_energy[index] = wear.energy(worn, self.scene.coating, radius)
        out.lobes[index] = wear.lobes(worn, self.scene.repeats)
        out.worn[index] = wear.around(worn)

    def _windows(self, now):
        """Places in the ring of the blocks of the window before the last one, and of the last.

        The ring holds just these two, and block ``now`` is next: its place is the oldest.
        """
        return (now + np.arange(2 * self.window).reshape(2, -1)) % (2 * self.window)

    def _signal(self, lane, row, window):
        """One observed displacement over a window, places in the ring."""
        n_observed = self.bank.scheme.observed.shape[1]
        history = self.record.history.reshape(2 * self.window, -1, n_observed, len(self.speed))
        return history[window, :, row, lane].ravel()
