"""`Config` → the contact study: the tuned disk, then all samples of all mistuning levels.

A task is one sample of one level. Tasks go by sample, then by level, so that all levels are equally
far at any moment. What a task computes depends on nothing but (configuration, level, sample).
"""

import time
from typing import NamedTuple

import numpy as np

from hpcrub import progress as progress_text
from hpcrub import sweep
from hpcrub.disk import Disk, build_disk
from hpcrub.errors import HpcrubError, InputError, Interrupted
from hpcrub.layout import DONE, FAILED, KINDS, NOT_STEADY, PENDING, STEADY, TUNED_REPEATS
from hpcrub.linear import linear_peak
from hpcrub.mistuning import stiffness_deviation
from hpcrub.reduction import ReducedModel, craig_bampton, mistuned_modes, per_sample_modes
from hpcrub.statistics import first_converged, running_intervals, running_percentiles
from hpcrub.steady import SteadyCriteria

NUDGE = 1e-12  # relative change of stiffness, as small as rounding
TUNED_PART = 4  # speeds of the tuned disk that are worth a task: they march together
LOOK_AGAIN = 1.01  # growth of the finished samples after which convergence is checked again


class Problem(NamedTuple):
    """What every rank needs in order to compute any sample."""

    disk: Disk
    reduced: ReducedModel
    scene: sweep.Scene
    stability_limit: float  # of the time step, for the stiffest sample [s]


class Outcome(NamedTuple):
    """What rank 0 needs to know of one finished sample."""

    status: int
    amplification: float
    linear_amplification: float
    point_status: np.ndarray  # (S,)
    n_steps: int
    seconds: float
    message: str = ""


def build_model(config):
    """Tuned Disk and ReducedModel of a configuration.

    Raises InputError for an impossible geometry.
    """
    try:
        disk = build_disk(config.disk, config.material)
        return disk, craig_bampton(disk, config.reduction.n_modes)
    except (ValueError, np.linalg.LinAlgError) as error:
        raise InputError(f"disk: {error}") from None


def build_problem(config):
    """Tuned disk, reduced model and scene of a configuration.

    Raises InputError for an impossible geometry and for a time step above the stability limit.
    """
    disk, reduced = build_model(config)
    # K = K0 + sum_i d_i K_i <= (1 + max d) K0, hence omega <= omega_tuned sqrt(1 + max d)
    pattern = config.pattern_deviation
    stiffest = max(0.0, np.max(config.mistuning.half_range if pattern is None else pattern))
    limit = 2.0 / np.sqrt(reduced.tuned_eigenvalues[-1] * (1.0 + stiffest))
    if config.time.scheme == "central_difference" and not config.time.step < limit:
        raise InputError(
            f"time.step_s: {config.time.step:g} is not below {limit:.4g} s, the stability limit "
            "of central_difference for this model"
        )
    return Problem(disk, reduced, _scene(config, reduced), float(limit))


def _scene(config, reduced):
    steady = config.steady_state
    return sweep.Scene(
        contact_angle=reduced.contact_angle,
        contact_radius=float(reduced.contact_radius[0]),
        damping_ratio=config.material.damping_ratio,
        n_bumps=config.casing.n_bumps,
        bump_height=config.casing.bump_height,
        clearance=config.casing.clearance,
        growth_time=config.casing.growth_time,
        friction=config.contact.friction,
        kinematics=config.contact.kinematics,
        scheme=config.time.scheme,
        step=config.time.step,
        audit=config.debug.energy_audit,
        steady=SteadyCriteria(
            first_check=steady.first_check,
            window_revolutions=steady.window_revolutions,
            extend_revolutions=steady.extend_revolutions,
            min_correlation=steady.min_correlation,
            max_amplitude_change=steady.max_amplitude_change,
            max_time=steady.max_time,
            confirmations=steady.confirmations,
        ),
    )


def peak(result, speeds_hz):
    """Largest amplitude of a SweepResult [m] and its speed [Hz]; NaN when all points diverged."""
    usable = np.isin(result.point_status, (STEADY, NOT_STEADY)) & np.isfinite(result.amplitude)
    if not usable.any():
        return np.nan, np.nan
    best = np.argmax(np.where(usable, result.amplitude, -np.inf))
    return float(result.amplitude[best]), float(speeds_hz[best])


def deviation(config, level, sample):
    """Relative stiffness change of every blade (N,) in one sample of one level of the file.

    In the file of a part they have the numbers that they have in the whole study.
    """
    if config.pattern_deviation is not None:
        return config.pattern_deviation
    level, sample = config.levels[level], config.samples[sample]
    half_range = config.mistuning.half_range[level]
    return stiffness_deviation(
        config.mistuning.seed, level, sample, config.disk.n_blades, half_range
    )


def modes_of(config, problem, deviation):
    """Modes of one disk (deviation (N,) of its blades) on the basis that the input asks for."""
    if config.reduction.basis == "per_sample":
        return per_sample_modes(problem.disk, config.reduction.n_modes, deviation)
    return mistuned_modes(problem.reduced, deviation)


class Study:
    """A contact study of which some results may already be in the file."""

    what = "samples"

    def __init__(self, team, config, problem, file, progress=None):
        """team: Team; config: Config; problem: Problem; file: ResultFile open to write on all
        ranks; progress: Progress on rank 0, None elsewhere."""
        self.team, self.config, self.problem, self.file = team, config, problem, file
        self.progress = progress
        self.speeds_hz = config.speeds.values_hz
        self.shape = len(config.levels), len(config.samples)
        self.tuned_peak = self.tuned_linear = np.nan
        self._march = sweep.find_peak if config.speeds.search == "peak" else sweep.run_sweep
        self.n_steps, self.seconds = 0, 0.0  # in the contact sweeps of this run, all ranks (rank 0)
        self.finished = 0  # samples 0 ... finished - 1 are finished on all levels (rank 0)
        self.looked_at = 0  # so many of them when convergence was checked last
        self.status = self.amplification = self.tasks = None  # (V, n), (2, V, n), (T,) on rank 0

    def run(self):
        """Compute what is missing and write it, with the statistics of what is there.

        Raises Interrupted on all ranks after a stop signal; what is finished is in the file.
        """
        tuned, n_pending = self.team.on_root(self._take_stock)
        if tuned is None or n_pending:
            self.team.on_root(self._warm_up)
            sweep.warm_up()  # the other ranks find it compiled; now every rank can stop promptly
        try:
            tuned = tuned or self._compute_tuned()
            self.tuned_peak = tuned["reference_amplitude_m"]
            self.tuned_linear = tuned["linear_amplitude_m"]
            if not self.tuned_peak > 0.0:
                self.team.on_root(lambda: _no_reference(self.tuned_peak))
            if self.progress:
                self.progress.start(self.status)
            tasks = map(int, self.tasks) if self.team.rank == 0 else ()
            self.team.run_tasks(tasks, self._compute, self._collect)
        except Interrupted:
            self.team.on_root(self._write_statistics)
            raise
        self.team.on_root(self._write_statistics)

    def update_statistics(self):
        """Write the statistics of the samples that are there (rank 0)."""
        self._take_stock()
        self._write_statistics()

    def n_done(self):
        """Finished samples and all (rank 0)."""
        status = self.file.status()
        return int(np.count_nonzero(status != PENDING)), status.size

    def summary(self, seconds):
        """Print what was found (rank 0); seconds: wall time of this run."""
        progress_text.summary(self.file, self, seconds)

    def _take_stock(self):
        """Take up the results that are there (rank 0).

        Returns the tuned disk's, None when missing, and the number of samples to compute.
        """
        self.status = self.file.status()
        names = "samples/amplification", "samples/linear_amplification"
        known = [self.file.read(name) for name in names]
        self.amplification = np.where(self.status == DONE, known, np.nan)
        sample, level = np.nonzero(self.status.T == PENDING)
        self.tasks = sample * self.shape[0] + level
        if self._is_enough():
            self.tasks = self.tasks[:0]
        return self.file.tuned(), len(self.tasks)

    def _warm_up(self):
        """Compile what will be needed; statistics too, as a stop leaves little time for them."""
        if self.progress:
            self.progress.say("loading the kernel (on first use it is compiled: half a minute)")
        sweep.warm_up()
        running_percentiles(np.ones(1), [50.0], 1, 1.0)

    # the tuned disk

    def _compute_tuned(self):
        modes = self.team.on_root(lambda: self._modes(np.zeros(self.config.disk.n_blades)))
        n_speeds = len(self.speeds_hz)
        n_parts = max(1, min(self.team.size, n_speeds // TUNED_PART))
        whole, repeats = sweep.SweepResult.empty(n_speeds), np.full(TUNED_REPEATS, np.nan)

        def compute(task, poll):
            start = time.perf_counter()
            part = range(task, n_speeds, n_parts) if task < n_parts else None
            tuned = modes if task < n_parts else self._nudged(task - n_parts)
            result = sweep.run_sweep(
                tuned, self.problem.scene, self.speeds_hz, poll, selection=part
            )
            return result, time.perf_counter() - start

        def collect(task, answer):
            result, seconds = answer
            if task >= n_parts:
                repeats[task - n_parts] = peak(result, self.speeds_hz)[0]
                return
            mine = slice(task, None, n_parts)
            for values, part in zip(whole[:-1], result[:-1], strict=True):
                values[mine] = part[mine]
            self._count(result.n_steps, seconds)
            if self.progress:
                self.progress.tuned(np.count_nonzero(whole.point_status), n_speeds)

        self.team.run_tasks(range(n_parts + TUNED_REPEATS), compute, collect)
        return self.team.on_root(lambda: self._finish_tuned(modes, whole, repeats))

    def _nudged(self, repeat):
        """Modes of the tuned disk but for rounding: where its motion is not periodic, its
        amplitude is one draw of many. All amplifications are relative to the median."""
        return self._modes(np.full(self.config.disk.n_blades, NUDGE * (repeat + 1)))

    def _finish_tuned(self, modes, result, repeats):
        values = _point_values(result) | {"frequencies_hz": modes.omega / (2.0 * np.pi)}
        values["peak_repeats_m"] = repeats
        values["peak_amplitude_m"], values["peak_speed_hz"] = peak(result, self.speeds_hz)
        known = np.array([values["peak_amplitude_m"], *repeats])
        known = known[np.isfinite(known)]
        values["reference_amplitude_m"] = np.median(known) if known.size else np.nan
        values["linear_amplitude_m"] = self._linear_peak(modes)
        self.file.write_tuned(values)
        return values

    # samples

    def _compute(self, task, poll):
        """Compute and write one sample; returns its Outcome."""
        sample, level = divmod(task, self.shape[0])
        start = time.perf_counter()
        values = {"deviation": deviation(self.config, level, sample), "status": FAILED}
        result, message = None, ""
        try:
            modes = self._modes(values["deviation"])
            result = self._march(modes, self.problem.scene, self.speeds_hz, poll)
            seconds = time.perf_counter() - start
            values |= _point_values(result) | self._amplifications(modes, result)
            message = "" if values["status"] == DONE else "all its points diverged"
        except (np.linalg.LinAlgError, ArithmeticError, ValueError) as error:
            seconds = time.perf_counter() - start
            message = f"{type(error).__name__}: {error}"
        self.file.write_sample(level, sample, values)
        return Outcome(
            status=values["status"],
            amplification=values.get("amplification", np.nan),
            linear_amplification=values.get("linear_amplification", np.nan),
            point_status=result.point_status if result else np.empty(0, np.uint8),
            n_steps=result.n_steps if result else 0,
            seconds=seconds,
            message=message,
        )

    def _modes(self, deviation):
        return modes_of(self.config, self.problem, deviation)

    def _amplifications(self, modes, result):
        """Peaks of one sample beside the tuned disk's, and its status."""
        amplitude, speed = peak(result, self.speeds_hz)
        linear = self._linear_peak(modes)
        return {
            "peak_amplitude_m": amplitude,
            "peak_speed_hz": speed,
            "amplification": amplitude / self.tuned_peak,
            "linear_amplitude_m": linear,
            "linear_amplification": linear / self.tuned_linear,
            "status": DONE if np.isfinite([amplitude, linear]).all() else FAILED,
        }

    def _linear_peak(self, modes):
        scene = self.problem.scene
        load = self.config.forcing.amplitude, scene.n_bumps, scene.contact_angle
        return linear_peak(modes, scene.damping_ratio, *load, self.config.disk.n_blades)[0]

    def _collect(self, task, outcome):
        """Take note of a finished sample (rank 0). True when the study has converged."""
        sample, level = divmod(task, self.shape[0])
        self.status[level, sample] = outcome.status
        if outcome.status == DONE:
            both = outcome.amplification, outcome.linear_amplification
            self.amplification[:, level, sample] = both
        self._count(outcome.n_steps, outcome.seconds)
        if self.progress:
            self.progress.sample(level, sample, outcome, self.amplification[0])
        return self._is_enough()

    def _count(self, n_steps, seconds):
        self.n_steps += n_steps
        self.seconds += seconds

    # statistics

    def _is_enough(self):
        """Whether every level and percentile has converged, if that ends the study (rank 0)."""
        convergence = self.config.convergence
        while self.finished < self.shape[1] and (self.status[:, self.finished] != PENDING).all():
            self.finished += 1
        due = max(self.looked_at + convergence.step, self.looked_at * LOOK_AGAIN)
        if not convergence.stop_when_converged or self.finished < due:
            return False
        self.looked_at = self.finished
        return self._converged_at(self._running("contact")) is not None

    def _running(self, kind, compute=running_percentiles):
        """RunningPercentiles of every level over the leading samples that are finished."""
        c = self.config.convergence
        values = self.amplification[KINDS.index(kind)]
        n_finished = [_leading(status != PENDING) for status in self.status]
        return [
            compute(values[level, :n], c.percentiles, c.step, c.z)
            for level, n in enumerate(n_finished)
        ]

    def _converged_at(self, running):
        """First number of percentile values at which all levels are converged, or None."""
        shortest = min(len(r.samples_seen) for r in running)
        error = np.stack([r.convergence_error[:, :shortest] for r in running])
        return first_converged(error, self.config.convergence.target_error)

    def _write_statistics(self):
        """Statistics of the finished samples (rank 0).

        A study that stops when it has converged has some samples more, depending on the ranks;
        its statistics end where it converged.
        """
        length = None
        if self.config.convergence.stop_when_converged:
            length = self._converged_at(self._running("contact"))
        for kind in KINDS:
            both = zip(self._running(kind), self._running(kind, running_intervals), strict=True)
            for level, parts in enumerate(both):
                cut = (type(part)(*(values[..., :length] for values in part)) for part in parts)
                self.file.write_statistics(kind, level, *cut)


def _point_values(result):
    return {
        "amplitude_m": result.amplitude,
        "time_s": result.time,
        "localisation": result.localisation,
        "point_status": result.point_status,
        "point_reason": result.point_reason,
        "max_sweeps": result.max_sweeps,
        "energy_j": result.energy,
    }


def _leading(flags):
    """Number of true values before the first false one."""
    return len(flags) if flags.all() else int(np.argmin(flags))


def _no_reference(tuned_peak):
    """Raise the error of a tuned disk without a peak."""
    if np.isnan(tuned_peak):
        raise HpcrubError("the tuned disk diverges at every speed: nothing to compare samples with")
    raise HpcrubError(
        "the tuned disk is not excited: the bumps never reach the blades "
        "(casing.clearance_mm, casing.bump_height_mm)"
    )
