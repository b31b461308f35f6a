"""Estimate of a study's computing time from a trial of a small part on this machine."""

import time
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from hpcrub.config.run_up import runs_up, schedules
from hpcrub.config.schema import Config
from hpcrub.contact.lanes import WIDTH, WIDTHS
from hpcrub.model.reduction import Modes
from hpcrub.response import history, sweep
from hpcrub.response.linear import linear_peak
from hpcrub.response.run_up import Runner
from hpcrub.response.scene import Scene, can_touch
from hpcrub.response.schedule import Schedule
from hpcrub.response.sweep import SweepResult
from hpcrub.setup.disks import deviation, modes_of, rubbing_modes
from hpcrub.setup.problem import Problem
from hpcrub.setup.run_up import asked_of

# time step of the trial of a planar disk, whose steps cost the same at any length [s]
MEASURED_STEP = 2e-5
MEASURED_SPEEDS = 41
MEASURED_TIME = 0.05  # [s] simulated by the trial of a history
LONGEST = 60.0  # [s] duration of a trial, about
# share of it that the trial of a run-up may take at the cost of its begin, without contact
OF_RUN_UP = 0.25


class Cost(NamedTuple):
    """Amount of work in all tasks of a study together, on any machine."""

    sweeps: int = 0  # over all speeds, each followed until its motion is steady, or run-ups
    histories: float = 0.0  # [s] simulated at all speeds while the motion is kept
    disks: int = 0  # eigenproblems, each with the linear responses


class Trial(NamedTuple):
    """Time that a small part of a study took."""

    seconds_per_disk: float
    until_steady: float = 0.0  # [s] simulated at a point, on average
    steps_per_second: float = np.inf  # of points that are followed to the steady state
    history_steps_per_second: float = np.inf  # while the motion is kept
    result: SweepResult | None = None  # of the mistuned disk of the trial
    seconds_of_runs: float = 0.0  # for all run-ups of a disk

    def seconds(self, cost: Cost, config: Config) -> float:
        """Time for a Cost on one core [s]."""
        lanes = len(history.LANES) * len(history.groups(config.speeds.values_hz))  # and idle ones
        kept = cost.histories * lanes / config.step / self.history_steps_per_second
        steps = config.speeds.n_values * self.until_steady / config.step
        sought = steps / self.steps_per_second + self.seconds_of_runs
        return cost.sweeps * sought + kept + cost.disks * self.seconds_per_disk


def trial(
    config: Config,
    problem: Problem,
    loads: tuple[int, ...] = (1,),
    integrates: bool = True,
    histories: bool = False,
) -> Trial:
    """Compute the last level's first disk at some speeds, and measure the time.

    loads: periods around the disk of the loads whose linear responses the study computes;
    integrates, histories: whether the study integrates in time, and whether it keeps the motion.
    """
    started = time.perf_counter()
    at = partial(modes_of, config, problem, deviation(config, len(config.levels) - 1, 0))
    modes = at()
    for n_diameters in loads:
        load = config.forcing.amplitude, n_diameters, problem.scene.interface
        linear_peak(modes, problem.scene.damping_ratio, *load, config.disk.n_blades, at)
    seconds_per_disk = time.perf_counter() - started
    if not integrates:
        return Trial(seconds_per_disk)
    if problem.basis:
        modes = rubbing_modes(config, problem, deviation(config, len(config.levels) - 1, 0))
    if runs_up(config):
        runs = _seconds_of_runs(modes, problem.scene, config)
        return Trial(seconds_per_disk, seconds_of_runs=runs)
    solid = len(modes.axial) > 0  # its contacts are harder to solve with longer steps
    step = problem.scene.step if solid else max(problem.scene.step, MEASURED_STEP)
    scene = problem.scene._replace(scheme="exact_modal", step=step)
    # some speeds of the study; where it has few, lanes are idle here as they are there
    speeds, most = config.speeds.values_hz, WIDTH if solid else MEASURED_SPEEDS
    some = np.linspace(0, len(speeds) - 1, min(len(speeds), most)).round().astype(int)
    speeds, scene = _within_reason(modes, scene, speeds[some])
    started = time.perf_counter()
    rest = sweep.Motion.at_rest(len(speeds), modes.n_rows)  # integrated even if nothing touches
    result = sweep.run_sweep(modes, scene, speeds, motion=rest)
    rate = result.n_steps / (time.perf_counter() - started)
    until_steady = result.time.mean() if can_touch(problem.scene) else 0.0
    kept = _history_rate(modes, problem.scene, config) if histories else np.inf
    return Trial(seconds_per_disk, until_steady, rate, kept, result)


def _within_reason(modes: Modes, scene: Scene, speeds: Any) -> tuple[Any, Any]:
    """Return speeds and scene of a trial within LONGEST: fewer speeds, then less time at each."""
    steady, some = scene.steady, speeds[:: -(-len(speeds) // WIDTH)]
    short = steady._replace(first_check=MEASURED_TIME, max_time=MEASURED_TIME)
    rest = sweep.Motion.at_rest(len(some), modes.n_rows)
    started = time.perf_counter()
    short_sweep = sweep.run_sweep(modes, scene._replace(steady=short), some, motion=rest)
    steps = LONGEST * short_sweep.n_steps / (time.perf_counter() - started)
    points = steps / short_sweep.n_steps * short_sweep.time.sum() / steady.max_time
    if points >= len(speeds):
        return speeds, scene
    few = speeds[:: max(1, len(speeds) // max(WIDTHS[0], int(points)))]
    longest = max(steady.max_time * min(1.0, points / len(few)), MEASURED_TIME)
    first = min(steady.first_check, longest)
    return few, scene._replace(steady=steady._replace(first_check=first, max_time=longest))


def _seconds_of_runs(modes: Modes, scene: Scene, config: Config) -> float:
    """Time for all run-ups of a disk, from that of the longest one, faster where it takes long."""
    runs, asked = schedules(config), asked_of(config)
    longest, started = max(runs, key=lambda run: run.turned[-1]), time.perf_counter()
    begin = Runner(modes, scene, longest, asked)
    to_begin = time.perf_counter() - started
    begun = begin.go_on()
    n_first = next(begun)  # what is not compiled is compiled now
    started = time.perf_counter()
    while (seconds := time.perf_counter() - started) < MEASURED_TIME and next(begun, 0):
        pass
    per_period = seconds / max(begin.n_done - n_first, 1)
    faster = max(1.0, begin.n_periods * per_period / (OF_RUN_UP * LONGEST))
    if scene.over_time is not None:
        scene = scene._replace(over_time=tuple((t / faster, c) for t, c in scene.over_time))
    tried = Schedule(longest.time / faster, longest.speed_hz)
    runner, started = Runner(modes, scene, tried, asked), time.perf_counter()
    for _ in runner.go_on():
        pass
    of_longest = (time.perf_counter() - started) * begin.n_periods / runner.n_done
    share = sum(run.turned[-1] for run in runs) / longest.turned[-1]
    return float(of_longest * share + to_begin * len(runs))


def _history_rate(modes: Modes, scene: Scene, config: Config) -> float:
    """Time steps per second of all lanes together while the motion is kept."""
    speeds = config.speeds.values_hz
    group = speeds[history.groups(speeds)[0]]
    started, duration = time.perf_counter(), min(MEASURED_TIME, config.history.duration_s)
    for _ in history.integrate(modes, scene, group, duration):
        pass
    n_steps = len(history.LANES) * duration / scene.step
    return n_steps / (time.perf_counter() - started)
