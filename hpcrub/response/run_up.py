"""Run-up and run-down of one disk: its motion while the speed of rotation changes.

The disk turns by the same angle in every step, so that steps become shorter as it gains speed. The
steps of a *stretch*, a revolution or a part of one, have one length, such that the disk is at the
exact angle at the exact time when the stretch ends. In between it lags behind even steps while it
gains speed, and the casing in the kernel's table is shifted by this lag. Lanes are repetitions of
the run, which begin at evenly spaced angles of the casing.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from hpcrub.contact import integrate, status
from hpcrub.contact.arrays import FLAW, UNSOLVED, arrays_of
from hpcrub.contact.bank import allocate, empty_lane
from hpcrub.contact.jit import compiled
from hpcrub.contact.observers import Record
from hpcrub.contact.retune import Speeds
from hpcrub.model.reduction import Modes
from hpcrub.response.band import judge
from hpcrub.response.revolution import Grid, cut_revolution
from hpcrub.response.scene import Scene, enough
from hpcrub.response.schedule import Schedule

LANES = 4, 8  # numbers of lanes for repetitions
# A stretch of several periods of the casing ends before LAG, the largest lag [rad] times the number
# of periods; one of several revolutions before PART of an interval of speed, and MOST_TURNS
LAG, PART, MOST_TURNS = 0.05, 0.5, 8


class Asked(NamedTuple):
    """What is recorded of a run."""

    intervals_hz: np.ndarray  # borders of the intervals of speed (I + 1,) [Hz]
    repeats: int  # number of repetitions R, at most 8
    amplitude: float = np.inf  # limits, above which seconds and cycles count [m]
    stress: float = np.inf  # [Pa]
    frequencies_hz: np.ndarray = np.zeros(0)  # of the spectra of the first repetition (F,) [Hz]


@dataclass
class Run:
    """Results of R repetitions of a run in D legs, which rise or fall; NaN where there is none."""

    envelope: np.ndarray  # largest |u_t| of any tip within an interval of speed (R, D, I) [m]
    stress: np.ndarray  # largest stress likewise; (R, D, 0) where stresses are not observed [Pa]
    seconds: np.ndarray  # time of the stretches whose largest values exceed a limit (R, D) [s]
    cycles: np.ndarray  # cycles of the tip that moves furthest in these stretches (R, D)
    worn: np.ndarray  # largest worn depth at the end of a leg (R, D) [m]; NaN without a coating
    reason: np.ndarray  # code of ``contact.status`` against a repetition (R,) u1
    # amplitudes of the tip that moves furthest, in the first repetition (D, I, F) [m]
    spectrum: np.ndarray

    @classmethod
    def empty(cls, asked: Asked, n_legs: int, has_stress: bool) -> "Run":
        """Run that has not begun."""
        n, n_intervals = asked.repeats, len(asked.intervals_hz) - 1
        return cls(
            envelope=np.full((n, n_legs, n_intervals), np.nan),
            stress=np.full((n, n_legs, n_intervals * has_stress), np.nan),
            seconds=np.zeros((n, n_legs)),
            cycles=np.zeros((n, n_legs)),
            worn=np.full((n, n_legs), np.nan),
            reason=np.zeros(n, dtype=np.uint8),
            spectrum=np.full((n_legs, n_intervals, len(asked.frequencies_hz)), np.nan),
        )


class _Now(NamedTuple):
    """A stretch of all repetitions: arrays (R,)."""

    n_periods: int  # of the casing
    lasts: np.ndarray  # [s]
    speed_hz: np.ndarray  # mean speed [Hz]
    leg: np.ndarray  # int
    interval: np.ndarray  # lowest and highest interval of speed that it is in (2, R) int
    counts: np.ndarray  # whether the repetition has begun, and has not ended or failed


class Runner:
    """Integration of one run, which can be interrupted and go on with the same bits."""

    def __init__(self, modes: Modes, scene: Scene, schedule: Schedule, asked: Asked) -> None:
        """Begin at rest."""
        self.modes, self.scene, self.schedule, self.asked = modes, scene, schedule, asked
        n, first_hz = asked.repeats, schedule.speed_hz[0]
        ends = schedule.speed_hz.min(), schedule.speed_hz.max()
        whole = cut_revolution(ends[0], scene)
        self.grid = grid = stretches(whole, schedule, asked)
        lanes, start_hz = enough(LANES, n), np.full(n, first_hz)
        self.bank = bank = allocate(modes, scene, grid, lanes, start_hz)
        scheme, self.period = bank.scheme, whole.steps_per_block
        period = self.period
        self.tables = [_Shifted(scheme.bump, period, 1)]
        if scheme.external is not None:
            self.tables.append(_Shifted(scheme.external, period, 0))
        # steps that each repetition waits before it begins to turn
        self.delay = np.arange(n) * period // n
        bank.state.n_steps[:n] = -self.delay
        self.record = Record.allocate(bank, 1, grid.stride, grid.look, 1)._replace(begin=0)
        if scene.observes_stress:
            self.record = self.record._replace(watched=np.arange(n))
        self.coefficients = Speeds(
            bank, lambda f: allocate(modes, scene, grid, len(f), f), float(first_hz), ends
        )
        self.run = Run.empty(asked, len(schedule.leg_ends), scene.observes_stress)
        self.spectra = _Spectra(asked, self.run.spectrum, grid, len(modes.observed))
        n_steps = schedule.turned[-1] * grid.steps_per_revolution * (1.0 - 1e-12)
        self.n_periods = int(np.ceil((n_steps + self.delay.max()) / period))
        self.n_done, self.failed = 0, np.zeros(n, dtype=bool)
        self.time = self._when(0)  # of every repetition now, negative before it begins [s]
        self.last = np.zeros((scheme.observed.shape[1], n))  # displacements in the last record [m]

    def go_on(self) -> Iterator[int]:
        """Integrate stretch by stretch, and yield the number of periods that are done."""
        while self.n_done < self.n_periods and not self.failed.all():
            now = self._begin()
            scheme, n_steps = self.bank.scheme, now.n_periods * self.period
            load = None if scheme.external is None else scheme.external[:n_steps]
            scheme = scheme._replace(bump=scheme.bump[:n_steps], external=load)
            integrate.run(self.bank._replace(scheme=scheme), 1, self.record)
            self._keep(now)
            self.n_done += now.n_periods
            yield self.n_done

    def result(self) -> Run:
        """Results of a run that is over."""
        self.spectra.write()
        spectrum, seen = self.run.spectrum, np.isfinite(self.run.envelope[0])
        for leg, interval in np.argwhere(seen & np.isnan(spectrum).all(axis=2)).tolist():
            if interval:  # which a stretch passes that is counted with a slower one
                spectrum[leg, interval] = spectrum[leg, interval - 1]
        return self.run

    def state(self) -> dict[str, np.ndarray]:
        """All that has changed since the begin, by name; `restore` takes it."""
        parts = {str(k): part for k, part in enumerate(self._arrays())}
        mine = {"last": self.last, "periods": np.array(self.n_done)}
        return parts | mine | self.spectra.state()

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Go on from a state of the same run (self is modified)."""
        for k, part in enumerate(self._arrays()):
            part[...] = state[str(k)]
        self.last, self.n_done = state["last"], int(state["periods"])
        self.time = self._when(self.n_done)
        self.failed = status.are_fatal(self.run.reason)
        for table in self.tables:
            table.written = np.nan, 0  # the next stretch writes it anew
        self.spectra.restore(state)

    def _arrays(self) -> list[np.ndarray]:
        return [*arrays_of(self.bank), *arrays_of(self.record), *vars(self.run).values()]

    def _when(self, n_periods: int) -> np.ndarray:
        """Time of every repetition after some periods, negative before it begins [s]."""
        n_steps = n_periods * self.period - self.delay
        return self.schedule.when(n_steps / self.grid.steps_per_revolution)

    def _next(self) -> tuple[int, np.ndarray]:
        """Periods of the coming stretch, and the time of every repetition at its end [s].

        Where a repetition still waits, or the gain of speed changes, repetitions lag behind by
        different angles: there a stretch is one period, in which the lag is small.
        """
        most = self.grid.steps_per_block // self.period
        ends, times = self._when(self.n_done + most), self.schedule.time
        first, last = np.searchsorted(times, [self.time.min(), ends.max()], side="right")
        if first == last > 0 or most == 1:
            return most, ends
        return 1, self._when(self.n_done + 1)

    def _begin(self) -> _Now:
        """Give all repetitions the mean speed of the coming stretch, and shift the tables."""
        grid, plan, asked = self.grid, self.schedule, self.asked
        per_turn, bank = grid.steps_per_revolution, self.bank
        n_periods, ends = self._next()
        began, n_steps = self.time, n_periods * self.period
        lasts, first = ends - began, plan.at(began)
        mean = n_steps / (lasts * per_turn)
        mean = np.where(np.abs(mean / first - 1.0) < 1e-12, first, mean)
        self.coefficients.set(mean, 1.0 / (mean * per_turn))
        middle = began + lasts / 2.0
        if self.scene.running is not None or self.scene.over_time is not None:
            bank.scheme.clearance[0, : len(mean)] = self.scene.clearances(mean, middle)
        # of an even acceleration a in a stretch T: (T t − t²) a/2, most after T/2, in steps
        lag = 0.125 * float(np.mean((plan.at(ends) - first) * lasts)) * per_turn
        for table in self.tables:
            table.shift(lag, n_steps)
        legs, borders = plan.leg_ends, asked.intervals_hz
        leg = np.minimum(np.searchsorted(legs, middle), len(legs) - 1)
        ends_hz = np.sort([first, plan.at(ends)], axis=0)
        interval = np.searchsorted(borders[1:-1], ends_hz, side="right")
        counts = (middle > 0.0) & (middle <= legs[-1]) & ~self.failed
        self.time = ends
        return _Now(n_periods, lasts, mean, leg, interval, counts)

    def _keep(self, now: _Now) -> None:
        """Keep what a stretch has shown."""
        n, run, record = self.asked.repeats, self.run, self.record
        peaks, stress = record.peak[: len(self.modes.observed), :n], record.stress_peak[0, :n]
        size = peaks.max(axis=0)
        self._judge(peaks, size)
        lanes = np.flatnonzero(now.counts & ~self.failed)
        low, high = now.interval[:, lanes]
        for beyond_low in range(int((high - low).max(initial=-1)) + 1):
            where = lanes, now.leg[lanes], np.minimum(low + beyond_low, high)
            run.envelope[where] = np.fmax(run.envelope[where], size[lanes])
            if run.stress.size:
                run.stress[where] = np.fmax(run.stress[where], stress[lanes])
        history = record.history.reshape(-1, len(self.last), self.bank.width)
        history = history[: now.n_periods * self.period // self.grid.stride]
        beyond = (size > self.asked.amplitude) | (stress > self.asked.stress)
        for lane in lanes[beyond[lanes]]:
            at, tip = (lane, now.leg[lane]), peaks[:, lane].argmax()
            run.seconds[at] += now.lasts[lane]
            run.cycles[at] += _cycles(self.last[tip, lane], history[:, tip, lane])
        if len(self.asked.frequencies_hz) and now.counts[0]:
            self.spectra.take(history[..., 0], now.leg[0], now.interval[0, 0], now.speed_hz[0])
        self.last = history[-1, :, :n].copy()
        stress[:] = 0.0
        if self.scene.coating:
            law: Any = self.bank.law
            run.worn[lanes, now.leg[lanes]] = law.surface.worn[:, lanes].max(axis=0)

    def _judge(self, peaks: np.ndarray, size: np.ndarray) -> None:
        """Find repetitions that fail, which have no result (self is modified)."""
        most = min(self.scene.furthest, float(self.scene.interface.radius.max()))
        report = self.bank.state.report[:, : len(size)]
        doubtful = ~(size < most) | (report[UNSOLVED] > 0.0) | (report[FLAW] > 0.0)
        for lane in np.flatnonzero(doubtful & ~self.failed).tolist():
            reason = judge(self.bank, lane, peaks[:, lane], self.scene)
            self.run.reason[lane] = reason
            if status.are_fatal(reason):
                self.failed[lane] = True
                for values in (self.run.envelope, self.run.stress, self.run.seconds,
                               self.run.cycles, self.run.worn):  # fmt: skip
                    values[lane] = np.nan
        for lane in np.flatnonzero(self.failed).tolist():  # its motion may be anything
            step = self.bank.scheme.step[lane]
            empty_lane(self.bank, lane)
            self.bank.scheme.step[lane] = step


@compiled
def shift_rows(
    table: np.ndarray, even: np.ndarray, slope: np.ndarray, bend: np.ndarray, lag: float, first: int
) -> None:
    """Shift rows of even angles by a lag, which rises and falls over them (table is modified).

    table: (P, n); even: one period of the rows at even angles (p, n), p a divisor of P.
    slope, bend: half the differences and the second differences of its rows (p, n).
    lag: in the middle of the rows, in rows; first: time step of row 0, 0 or 1.
    """
    n_rows, period = table.shape[0], even.shape[0]
    for row in range(n_rows):
        t, k = (row + first) / n_rows, row % period
        off = -4.0 * lag * t * (1.0 - t)
        for i in range(table.shape[1]):
            table[row, i] = even[k, i] + off * (slope[k, i] + off * bend[k, i])


class _Shifted:
    """A table of even angles in the kernel that is shifted by the lag of the disk.

    The parabola through three rows has a relative error of order (lag times angle of a step)³.
    """

    def __init__(self, table: np.ndarray, period: int, first: int) -> None:
        """table: (P, n), modified; period: rows after which it repeats itself; first: its step."""
        self.table, self.first, self.written = table, first, (0.0, len(table))
        self.even = table[:period].copy()
        table[:] = np.tile(self.even, (len(table) // period, 1))  # with the bits of the first
        after, before = np.roll(self.even, -1, axis=0), np.roll(self.even, 1, axis=0)
        self.slope, self.bend = (after - before) / 2.0, (after + before) / 2.0 - self.even

    def shift(self, lag: float, n_rows: int) -> None:
        """Write the first rows for a stretch; lag: in its middle, in rows."""
        if (lag, n_rows) != self.written and (lag != 0.0 or self.written[0] != 0.0):
            table = self.table[:n_rows]
            shift_rows(table, self.even, self.slope, self.bend, lag, self.first)
            self.written = lag, n_rows


class Stretches(NamedTuple):
    """Division of a revolution into steps, and of a run into stretches, as the kernel's blocks."""

    steps_per_revolution: int
    steps_per_block: int
    stride: int
    look: int


def stretches(grid: Grid, schedule: Schedule, asked: Asked) -> Stretches:
    """Stretches of as many periods of the casing as LAG allows, and MOST_TURNS.

    They are short against the time in an interval of speed, unless a revolution is longer.
    grid: of the slowest speed, with a block for each period of the casing, or for several.
    """
    n, fastest = grid.blocks_per_revolution, float(np.abs(schedule.slopes).max())
    if fastest > 0.0:
        # lag a T²/8 in turns
        lasts = np.sqrt(8.0 * LAG / (2.0 * np.pi * n * fastest))
        part = PART * float(np.diff(asked.intervals_hz).min()) / fastest
        lasts = min(lasts, max(part, 1.0 / float(schedule.speed_hz.min())))
    else:
        lasts = np.inf
    n_blocks = max(1, int(min(lasts * float(schedule.speed_hz.min()), MOST_TURNS) * n))
    n_steps = n_blocks * grid.steps_per_block
    return Stretches(grid.steps_per_revolution, n_steps, grid.stride, grid.look)


def _cycles(before: float, record: np.ndarray) -> float:
    """Upward crossings of the mean in a record (M,), which follows a value before."""
    above = np.append(before, record) > record.mean()
    return float(np.count_nonzero(above[1:] & ~above[:-1]))


class _Spectra:
    """Spectra of a repetition, one for each interval of speed."""

    def __init__(self, asked: Asked, spectrum: np.ndarray, grid: Stretches, n_rows: int) -> None:
        """spectrum: (D, I, F), filled as intervals are complete (modified)."""
        self.asked, self.spectrum, self.n_rows = asked, spectrum, n_rows
        self.records_per_turn = grid.steps_per_revolution / grid.stride
        self.place: tuple[int, int] = (-1, -1)
        self.kept: list[np.ndarray] = []
        self.speeds: list[float] = []

    def state(self) -> dict[str, np.ndarray]:
        """What was taken of an interval that is not over, by name."""
        kept = np.concatenate(self.kept) if self.kept else np.zeros((0, self.n_rows))
        return {"kept": kept, "speeds": np.array(self.speeds), "place": np.array(self.place)}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Go on from a `state` (self is modified)."""
        self.kept = [state["kept"]] if len(state["kept"]) else []
        leg, interval = state["place"].tolist()
        self.speeds, self.place = state["speeds"].tolist(), (leg, interval)

    def take(self, history: np.ndarray, leg: int, interval: int, speed_hz: float) -> None:
        """Take the records (M, O) of a stretch; write the spectrum of an interval that is over."""
        if self.place != (leg, interval):
            self.write()
            self.place = int(leg), int(interval)
        self.kept.append(history[:, : self.n_rows].copy())
        self.speeds.append(float(speed_hz))

    def write(self) -> None:
        """Write the spectrum of what was taken, by a Hann window over equal angles."""
        if not self.kept:
            return
        records, mean_hz = np.concatenate(self.kept), float(np.mean(self.speeds))
        tip = np.abs(records).max(axis=0).argmax()
        window = np.hanning(len(records) + 2)[1:-1]
        size = np.abs(np.fft.rfft(records[:, tip] * window)) * 2.0 / window.sum()
        order = np.arange(len(size)) * self.records_per_turn / len(records)
        at = np.interp(self.asked.frequencies_hz, order * mean_hz, size, right=0.0)
        self.spectrum[self.place] = np.fmax(self.spectrum[self.place], at)
        self.kept, self.speeds = [], []


def run_up(
    modes: Modes,
    scene: Scene,
    schedule: Schedule,
    asked: Asked,
    poll: Callable[[], object] | None = None,
) -> Run:
    """Integrate a whole run of one disk.

    modes: of the disk; poll: called without arguments after every stretch; an exception from it
    ends the run.
    """
    runner = Runner(modes, scene, schedule, asked)
    for _ in runner.go_on():
        if poll is not None:
            poll()
    return runner.result()
