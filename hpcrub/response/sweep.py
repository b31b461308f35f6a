"""The frequency response of one sample: many angular speeds, a few at a time.

The angle is the clock. All speeds of a *band* take the same number of steps per revolution, so
that at every step they see the same casing and share its table; only the step length differs. A
band is integrated in *blocks* of whole bump pitches. A lane whose speed has reached its steady
state takes the next waiting speed at the next block.
"""

import math
from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hpcrub.contact import arrays, bank, kernel, status
from hpcrub.contact.complementarity import FLAW, SWEEPS, UNSOLVED
from hpcrub.contact.status import DIVERGED, NO_POINT, NOT_STEADY, STEADY
from hpcrub.model.casing import NO_PROFILE, Profile, highest, repeats
from hpcrub.model.damping import Damping
from hpcrub.model.interface import Interface, planar_interface
from hpcrub.model.reduction import Modes
from hpcrub.response.steady import (
    SteadyCriteria,
    is_constant,
    is_repeated,
    localisation,
    permanent_contact,
)

WIDTH = 16  # speeds of a bank: two of the widest vector registers hide each other's latency
BAND = 1.08  # ratio of the fastest to the slowest speed of a band
RECORD_INTERVAL = 8e-5  # [s] between recorded displacements: 86 per period at 145 Hz
NARROWEST = 8  # speeds left when the lanes of a sweep that runs dry are no longer halved
MIN_BLOCK = 64  # steps
PIECE = 16384  # steps between two polls, if a block is not longer
COARSE, N_TOPS = 4, 3  # of `find_peak`: first distance in grid points, tops that are surrounded


class Scene(NamedTuple):
    """Everything about a contact run that is the same for all samples and speeds."""

    interface: Interface
    damping_ratio: float | Damping  # of every mode, or of each
    n_bumps: int
    bump_height: float  # [m]
    clearance: float  # [m]
    ramp_time: float  # [s]
    friction: float
    profile: Profile = NO_PROFILE  # of the casing, beside its bumps
    load: float = 0.0  # radial engine-order excitation of every blade, at rest in space [N]
    load_order: int = 1  # its periods around the casing
    kinematics: str = "small"
    scheme: str = "central_difference"
    step: float = 1e-6  # [s], an upper bound
    record_interval: float = RECORD_INTERVAL  # [s], an upper bound
    steady: SteadyCriteria = SteadyCriteria()
    shortcuts: arrays.Shortcuts = arrays.Shortcuts()

    @property
    def repeats(self) -> int:
        """Times that all that a contact point meets repeats itself in a turn."""
        casing = repeats(self.n_bumps, self.bump_height, self.profile)
        return math.gcd(casing, self.load_order) if self.load else casing

    @property
    def highest(self) -> float:
        """Highest place of the casing above its nominal radius, inwards [m]."""
        return highest(self.n_bumps, self.bump_height, self.profile)

    @property
    def lift(self) -> float:
        """Clearance and highest place of the casing together [m]."""
        return self.clearance + self.highest


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
    point_status: np.ndarray  # (S,) uint8: NO_POINT, STEADY, NOT_STEADY, DIVERGED
    point_reason: np.ndarray  # (S,) uint8: code of ``status``
    max_sweeps: np.ndarray  # (S,) uint8: most sweeps of the multiplier solver in a step
    n_steps: int = 0  # time steps of all speeds

    @classmethod
    def empty(cls, n: int) -> "SweepResult":
        """Result of n speeds, none of them integrated yet."""
        nan, zero = np.full(n, np.nan), np.zeros(n, dtype=np.uint8)
        return cls(nan, np.zeros(n), nan.copy(), zero, zero.copy(), zero.copy())

    def continued(self, reason: np.ndarray) -> "SweepResult":
        """The same, less the points that have failed since; reason: codes of ``status`` (S,)."""
        lost = status.are_fatal(reason) & (self.point_status != DIVERGED)
        return self._replace(
            amplitude=np.where(lost, np.nan, self.amplitude),
            localisation=np.where(lost, np.nan, self.localisation),
            point_status=np.where(lost, DIVERGED, self.point_status).astype(np.uint8),
            point_reason=np.where(lost, reason, self.point_reason).astype(np.uint8),
        )


class Grid(NamedTuple):
    """How the revolutions of a band are cut."""

    steps_per_revolution: int
    blocks_per_revolution: int
    stride: int  # steps from one record to the next

    @property
    def steps_per_block(self) -> int:
        """Time steps of a block."""
        return self.steps_per_revolution // self.blocks_per_revolution


def speed_bands(speeds_hz: np.ndarray) -> list[np.ndarray]:
    """Split speeds (S,) [Hz] into index arrays of similar speeds, slowest first."""
    order = np.argsort(speeds_hz, kind="stable")
    bands, start = [], 0
    for i in range(1, len(order) + 1):
        if i == len(order) or speeds_hz[order[i]] > BAND * speeds_hz[order[start]]:
            bands.append(order[start:i])
            start = i
    return bands


def cut_revolution(slowest_hz: float, scene: Scene) -> Grid:
    """Whole steps per block and blocks per revolution, no step longer than asked.

    A block turns the disk by a whole number of bump pitches, or periods of what the tips meet.

    Parameters
    ----------
    slowest_hz : float
        Lowest speed of the band [Hz].
    scene : Scene
    """
    n_steps = math.ceil(1.0 / (slowest_hz * scene.step) * (1.0 - 1e-12))
    stride = max(1, min(int(scene.record_interval / scene.step), n_steps // scene.repeats))
    divisors = [d for d in range(1, scene.repeats + 1) if scene.repeats % d == 0]
    blocks = max(d for d in divisors if d == 1 or n_steps >= d * MIN_BLOCK)
    unit = blocks * stride
    return Grid(math.ceil(n_steps / unit) * unit, blocks, stride)


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

    Parameters
    ----------
    modes : Modes
        Of the sample.
    scene : Scene
    speeds_hz : array_like (S,)
        Angular speeds [Hz].
    poll : callable, optional
        Called without arguments after every PIECE of steps, some hundredths of a second; what it
        raises ends the sweep.
    width : int
        Speeds integrated together; changes the cost, not one bit of the result.
    selection : iterable of int, optional
        Indices of the speeds to integrate, all by default. The steps are those of the whole sweep,
        so that parts of it computed apart are the same bits.
    motion : Motion, optional
        To start from, rest by default (modified: the motion at the end).

    Returns
    -------
    SweepResult.
    """
    speeds_hz = np.asarray(speeds_hz, dtype=float)
    n = len(speeds_hz)
    out, n_steps = SweepResult.empty(n), 0
    wanted = set(range(n) if selection is None else selection)
    touches = can_touch(scene) or motion is not None
    if scene.shortcuts.nothing_touches and not touches:
        for values, rest in zip(out[:4], (0.0, 0.0, 0.0, STEADY), strict=True):
            values[list(wanted)] = rest
        return out
    for band in speed_bands(speeds_hz):
        grid = cut_revolution(speeds_hz[band[0]], scene)
        # fastest first: they take longest to settle, and should not be left to the last lanes
        waiting = [i for i in band[::-1] if i in wanted]
        n_steps += _Band(modes, scene, grid, speeds_hz, width, motion).run(waiting, out, poll)
    return out._replace(n_steps=n_steps)


def find_peak(
    modes: Modes,
    scene: Scene,
    speeds_hz: np.ndarray,
    poll: Callable[[], object] | None = None,
) -> SweepResult:
    """Integrate only some speeds, closer and closer to the largest amplitudes.

    Starts with every COARSE-th speed and halves the distance around the N_TOPS largest amplitudes
    until these and their neighbours have been integrated. A narrow peak may be missed.

    Parameters as of `run_sweep`; speeds that were left out have the status NO_POINT.
    """
    chosen = sorted({*range(0, len(speeds_hz), COARSE), len(speeds_hz) - 1})
    out = run_sweep(modes, scene, speeds_hz, poll, selection=chosen)
    distance = COARSE
    while distance > 1 or chosen:
        distance = max(1, distance // 2)
        chosen = _unknown_neighbours(out, distance)
        if chosen:
            out = _merge(out, run_sweep(modes, scene, speeds_hz, poll, selection=chosen))
    return out


def _unknown_neighbours(result, distance):
    """Speeds not integrated yet at a distance from those of the N_TOPS largest amplitudes."""
    known = np.flatnonzero(result.point_status != NO_POINT)
    size = np.nan_to_num(result.amplitude[known], nan=-1.0)
    tops = known[np.argsort(-size, kind="stable")[:N_TOPS]]
    near = {int(top + d) for top in tops for d in (-distance, distance)}
    return sorted(i for i in near - set(known.tolist()) if 0 <= i < len(result.amplitude))


def _merge(first, second):
    """Results of two sweeps over different selections of the same speeds (first is modified)."""
    new = second.point_status != NO_POINT
    for old, found in zip(first[:-1], second[:-1], strict=True):
        old[new] = found[new]
    return first._replace(n_steps=first.n_steps + second.n_steps)


def can_touch(scene: Scene) -> bool:
    """Whether a disk that starts at rest can touch the casing, or stays at rest."""
    if scene.load:
        return True
    return scene.highest > scene.clearance + scene.interface.clearance.min()


def judge(lanes: arrays.Bank, lane: int, size: np.ndarray, scene: Scene) -> int:
    """What is wrong with a lane so far; a flaw of its contact forces counts once it has touched.

    Parameters
    ----------
    lanes : arrays.Bank
        After some integration.
    lane : int
        Index.
    size : ndarray
        Magnitudes of its observed displacements, of any shape [m].
    scene : Scene

    Returns
    -------
    int
        Code of ``status``.
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
        self.speed = [None] * width  # index of the speed in each lane
        self.start = [0] * width  # block at which it started
        self.check = [0] * width  # block at which it is checked next
        self.passed = [0] * width  # checks passed in succession
        self.touched = [(0, np.zeros(0))] * width  # a block, and steps_touched until then

    def run(self, waiting, out, poll):
        """Integrate the speeds ``waiting`` (indices) into ``out`` (modified); returns the steps."""
        n_steps, now = 0, 0
        for lane in range(len(self.speed)):
            self._refill(lane, waiting, now)
        while any(speed is not None for speed in self.speed):
            recording, event = self._next_event(now)
            until = min(event, now + max(1, PIECE // self.grid.steps_per_block))
            place = now % (2 * self.window) if recording else -1
            self._integrate(until - now, place)
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

    def _integrate(self, n_blocks, place):
        kernel.integrate((0,) * len(self.speed), *self.bank, n_blocks, place, self.grid.stride)

    def _narrow(self):
        """Go on with half the lanes when the others are idle: a step of fewer lanes costs less."""
        running = [lane for lane, speed in enumerate(self.speed) if speed is not None]
        half = len(self.speed) // 2
        if not self.scene.shortcuts.narrow or half < NARROWEST or len(running) > half:
            return
        idle = [lane for lane, speed in enumerate(self.speed) if speed is None]
        kept = (running + idle)[:half]
        self.bank = self.bank.take(kept)
        for name in ("speed", "start", "check", "passed", "touched"):
            setattr(self, name, [getattr(self, name)[lane] for lane in kept])

    def _next_event(self, now):
        """Whether any lane records from block ``now`` on, and until when nothing changes."""
        checks = [c for c, s in zip(self.check, self.speed, strict=True) if s is not None]
        begin = min(checks) - 2 * self.window
        recording = begin <= now or not self.scene.shortcuts.windows
        if not recording:
            return False, begin
        last_windows = [c - self.window for c in checks if c - self.window > now]
        return True, min(checks + last_windows)

    def _count_contacts(self, now):
        """Keep the contacts until now of the lanes whose last window before a check begins."""
        for lane, check in enumerate(self.check):
            if self.speed[lane] is not None and check - self.window == now:
                self.touched[lane] = now, bank.steps_touched(self.bank, lane)

    def _share_touched(self, lane, now):
        """Share of the last window in which every blade touched (N,); (0,) where not counted."""
        begin, before = self.touched[lane]
        steps = (now - begin) * self.grid.steps_per_block
        return (bank.steps_touched(self.bank, lane) - before) / steps

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
        bank.fill_lane(self.bank, lane, self.modes.at(speed), self.scene, h)
        if self.motion is not None:
            bank.set_motion(self.bank, lane, *(m[self.speed[lane]] for m in self.motion))
        self.start[lane], self.passed[lane] = now, 0
        first = self._blocks(lane, self.scene.steady.first_check, math.ceil)
        self.check[lane] = now + max(first, 2 * self.window)

    def _finished(self, lane, now, out):
        """Check a lane; write its result (modified) and return True if it ends here."""
        steady = self.scene.steady
        older, newer = self._windows(now)
        peak = self.bank.record.peak.reshape(2 * self.window, -1, len(self.speed))
        peak = peak[:, : len(self.modes.observed), lane]
        before, last = peak[older].max(axis=0), peak[newer].max(axis=0)
        index = self.speed[lane]
        elapsed = now - self.start[lane]
        reason = judge(self.bank, lane, peak, self.scene)
        if reason in status.FATAL:
            verdict = DIVERGED
        else:
            most = int(np.argmax(last))
            cap = self._blocks(lane, steady.max_time, math.floor)
            passes = is_constant(before[most], last[most], steady) and is_repeated(
                self._signal(lane, most, older), self._signal(lane, most, newer), steady
            )
            self.passed[lane] = self.passed[lane] + 1 if passes else 0
            if self.passed[lane] >= steady.confirmations:
                verdict = STEADY
            elif elapsed >= cap:
                verdict = NOT_STEADY
            else:
                extend = steady.extend_revolutions * self.grid.blocks_per_revolution
                self.check[lane] = min(now + extend, self.start[lane] + cap)
                return False
            stuck = permanent_contact(self._share_touched(lane, now), last.max(), self.scene.lift)
            if stuck:
                verdict, reason = DIVERGED, stuck
            else:
                out.amplitude[index] = last.max()
                out.localisation[index] = localisation(self.scene.interface.of_blades(last))
        out.point_status[index], out.point_reason[index] = verdict, reason
        out.max_sweeps[index] = min(self.bank.state.report[SWEEPS, lane], 255)
        out.time[index] = elapsed / (self.speeds_hz[index] * self.grid.blocks_per_revolution)
        if self.motion is not None:
            for values, end in zip(self.motion, bank.motion(self.bank, lane), strict=True):
                values[index] = end
        return True

    def _windows(self, now):
        """Places in the ring of the blocks of the window before the last one, and of the last.

        The ring holds just these two, and block ``now`` is next: its place is the oldest.
        """
        return (now + np.arange(2 * self.window).reshape(2, -1)) % (2 * self.window)

    def _signal(self, lane, row, window):
        """One observed displacement over a window, places in the ring."""
        n_observed = self.bank.scheme.observed.shape[1]
        history = self.bank.record.history.reshape(2 * self.window, -1, n_observed, len(self.speed))
        return history[window, :, row, lane].ravel()


def warm_up(axial: bool = False) -> None:
    """Compile the kernel, or load it from the cache; the first call of a machine takes a minute.

    ``axial``: that of disks with axial motion.
    """
    modes, scene = smallest_case(axial)
    for width in (WIDTH, NARROWEST):
        run_sweep(modes, scene, [100.0], width=width)


def smallest_case(axial: bool = False) -> tuple[Modes, Scene]:
    """Modes and Scene of one mass and a few steps; ``axial``: it can move axially, too."""
    one = np.ones((1, 1))
    modes, interface = Modes.planar(np.ones(1), one, one), planar_interface(np.zeros(1), 1.0)
    if axial:
        modes, interface = modes._replace(axial=one), interface._replace(axial=np.zeros((1, 2)))
    return modes, Scene(
        interface=interface,
        damping_ratio=0.01,
        n_bumps=1,
        bump_height=2e-3,
        clearance=1e-3,
        ramp_time=1e-2,
        friction=0.1,
        step=1e-3,
        steady=SteadyCriteria(first_check=0.01, window_revolutions=1, max_time=0.02),
    )
