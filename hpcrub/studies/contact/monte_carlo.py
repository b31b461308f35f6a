"""The job of a contact study: the tuned disk and all samples of all levels, on all ranks.

Samples go by number, then by level, so that all levels are equally far at any moment. The results
of a sample depend on nothing but (configuration, level, sample).

The tuned disk comes first, on all ranks: amplifications of the samples are relative to it.
"""

import time
from collections.abc import Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from hpcrub import effects
from hpcrub.config.text import counted
from hpcrub.errors import HpcrubError, Interrupted
from hpcrub.model.reduction import Modes
from hpcrub.ranks.progress import console, duration
from hpcrub.ranks.runlog import Work
from hpcrub.response import sweep
from hpcrub.response.scene import Scene
from hpcrub.response.sweep import Disk
from hpcrub.results.layout import DONE, FAILED, PENDING
from hpcrub.runs.job import Job
from hpcrub.setup.disks import deviation, own_modes_of, rubbing_modes
from hpcrub.statistics import percentiles
from hpcrub.studies.contact import amplification, findings, layout, second_order
from hpcrub.studies.contact.layout import kinds
from hpcrub.studies.contact.tasks import ContactTasks, Part, most_parts, n_parts, together

LOOK_AGAIN = 1.01  # growth of the finished samples after which convergence is checked again
BAD_NUMBERS = (np.linalg.LinAlgError, ArithmeticError, ValueError)  # fail a sample, not the study


class Outcome(NamedTuple):
    """Report to rank 0 on one finished sample."""

    status: int
    numbers: tuple[float, ...]  # one of each kind
    work: Work
    message: str = ""


class MonteCarlo(Job):
    """The job of a contact study."""

    def __init__(self, *arguments: Any) -> None:
        """A job that has not begun; arguments as for `Job`, no Problem where parts are merged."""
        super().__init__(*arguments)
        config = self.config
        self.speeds_hz = config.speeds.values_hz
        self.reference: Any = None  # Reference, once known to this rank
        self.looked_at = 0  # samples finished on all levels when convergence was checked last
        self.kinds = kinds(config)
        self.observers: dict[str, Any] = {}  # of the effects
        for effect in effects.of(config):
            self.observers |= effect.observers(config)
        self.numbers: Any = None  # of the samples (kinds, V, n), on rank 0
        self.tasks: Any = ()  # on rank 0
        self.parts: dict[tuple, dict[int, Any]] = {}  # of samples that are cut (rank 0)
        self.failure = ""  # message of the last sample that failed (rank 0)

    def run(self) -> None:
        """Compute and write the tuned disk and all missing samples, then write the statistics.

        Raises Interrupted on all ranks after a stop signal; finished samples are in the file.
        """
        self.reference, n_tasks = self.team.on_root(self._take_stock)
        if n_tasks or not self.reference:
            self.load_kernel()
        try:
            if not self.reference:
                self.phase("tuned disk")
                self.reference = self._tuned_disk()
            self.team.on_root(lambda: amplification.check_reference(self.reference, self.file))
            if self.reference.usable:
                self.phase("samples")
                self.team.on_root(lambda: self.progress.start(self.status))
                self.team.run_tasks(self.tasks, self._compute, self._collect)
        except Interrupted:
            self.team.on_root(self._write_statistics)
            raise
        self.team.on_root(self._write_statistics)

    def update_statistics(self) -> None:
        """Write the statistics of the finished samples (rank 0)."""
        self._take_stock()
        self._write_statistics()

    def n_done(self) -> tuple[int, int]:
        """Finished samples in the file, which rank 0 may not know of yet, and all (rank 0)."""
        status = self.file.status
        return int(np.count_nonzero(status != PENDING)), status.size

    def require_results(self) -> None:
        """Raise HpcrubError when every sample has failed (rank 0)."""
        if (self.status == FAILED).all():
            why = f", the last one: {self.failure}" if self.failure else ""
            raise HpcrubError(f"all {self.status.size} samples have failed{why}")

    def summary(self, seconds: float) -> None:
        """Print the results (rank 0); seconds: wall time of this run."""
        self.study.print_results(self.file)
        text = f"wall time {duration(seconds)} on {counted(self.team.size, 'rank')}"
        if self.work.seconds > 0.0:
            rate = self.work.n_steps / self.work.seconds
            text += f", {rate / 1e6:.3g} million steps per second and core"
        console().print(text)

    def _take_stock(self) -> Any:
        """Read the results in the file, and plan the tasks (rank 0).

        Returns the Reference, None if it is missing, and the number of the samples' tasks.
        """
        self.status = self.file.status
        self.reference = amplification.reference_of(self.file, self.prepared)
        self.numbers = np.stack([self.file.read(f"samples/{kind.of}") for kind in self.kinds])
        self.numbers[:, self.status != DONE] = np.nan
        n_pending = int(np.count_nonzero(self.status == PENDING))
        if self._is_enough():
            n_pending = 0
        n_together = 1
        if self.prepared and self.prepared.basis:
            n_together = together(len(self.speeds_hz), max(self.prepared.scene.lanes))
        most = most_parts(len(self.speeds_hz))
        places = np.argwhere(self.status.T == PENDING)[:, ::-1]
        pending = (tuple(place) for place in places.tolist())
        self.tasks = ContactTasks(pending, n_pending, most, n_together)
        return self.reference, len(self.tasks)

    def _tuned_disk(self) -> Any:
        """Compute and write the runs of the tuned disk (all ranks); returns the Reference.

        Some disks follow with displacements to second order, where these make a difference.
        """
        config, problem, n = self.config, self.prepared, amplification.n_runs(self.config)
        run = partial(amplification.tuned_run, config, problem)
        runs = self._sweeps(n, run, "speeds of the tuned disk", first_checked=True)
        bent: list[Any] = []

        def matters() -> bool:
            peak, _ = runs[0].peak(self.speeds_hz)
            return second_order.matters(config, second_order.FURTHER * peak)

        def write() -> Any:
            more = second_order.values_of(config, bent)
            amplification.write_tuned(config, problem, self.file, runs, more)
            return amplification.reference_of(self.file, problem)

        if self.team.on_root(matters):
            further = self.load_kernel(of_second_order=True)
            self.phase("disks to second order")
            disk = partial(second_order.disk, config, further)
            bent = self._sweeps(second_order.n_disks(config), disk, "speeds to second order")
        return self.team.on_root(write)

    def _sweeps(self, n: int, disk_of: Any, what: str, first_checked: bool = False) -> list[Any]:
        """Sweep n disks on all ranks, before the samples; returns an Integrated of each (rank 0).

        disk_of: gives modes and scene of a disk by its number; what: is counted.
        """
        n_speeds, n_done = len(self.speeds_hz), 0
        cut = n_parts(n, self.team.size, most_parts(n_speeds))
        wholes: dict[int, Any] = {}

        def compute(task: Part, poll: Any) -> Any:
            (disk,) = task.places
            modes, scene = disk_of(disk)
            checked = [first_checked and disk == 0]
            ((_, found),) = self._integrate([Disk(modes, self._part(task))], scene, poll, checked)
            return found

        def collect(task: Part, found: Any) -> None:
            nonlocal n_done
            self.work += Work(0, found.n_steps, found.seconds)
            wholes[task.places[0]] = self._whole(task, found)
            n_done += int(np.count_nonzero(found.result.point_status))
            self.progress.part(what, n_done, n * n_speeds)

        tasks = [Part((disk,), part, cut) for disk in range(n) for part in range(cut)]
        self.team.run_tasks(tasks, compute, collect)
        return [wholes[disk] for disk in sorted(wholes)]

    def _whole(self, task: Part, found: Any) -> Any:
        """The Integrated of a disk after its last part; None after others (rank 0)."""
        parts = self.parts.setdefault(task.places, {})
        parts[task.part] = found
        is_whole = len(parts) == task.n_parts
        return amplification.join(self.parts.pop(task.places)) if is_whole else None

    # any rank

    def _compute(self, task: Any, poll: Any) -> Any:
        """Write whole samples and return their Outcomes; of a part of one return the Integrated."""
        responses = self._responses(task, poll)
        if task.n_parts > 1:
            return next(responses)[1]
        return [(place, self._finish(place, *found)) for place, *found in responses]

    def _part(self, task: Any) -> range:
        """Speeds of a task."""
        return range(task.part, len(self.speeds_hz), task.n_parts)

    def _responses(self, task: Any, poll: Any) -> Iterator[tuple[Any, Any, Modes | None]]:
        """Integrate the samples of a task: (place, Integrated, modes) as they end."""
        disks, checked, left = [], [], set(range(len(task.places)))
        try:
            for level, sample in task.places:
                blades = deviation(self.config, level, sample)
                modes = rubbing_modes(self.config, self.prepared, blades)
                disks.append(Disk(modes, self._part(task)))
                # the first samples of the last level are checked, wherever a part begins
                first = self.config.samples[sample] < self.config.mistuning.checked_samples
                checked.append(first and level == self.config.levels[-1])
            for k, response in self._integrate(disks, self.prepared.scene, poll, checked):
                left.remove(k)
                yield task.places[k], response, disks[k].modes
        except BAD_NUMBERS as error:
            failed = amplification.Integrated(None, 0.0, _words(error))
            yield from ((task.places[k], failed, None) for k in sorted(left))

    def _integrate(
        self, disks: Any, scene: Scene, poll: Any, checked: list[bool]
    ) -> Iterator[tuple[int, Any]]:
        """Integrate disks together: (number, Integrated) as they end; checked: once more, too."""
        start, speeds_hz, seen = time.perf_counter(), self.speeds_hz, self.observers
        others = amplification.checks(scene) if self.config.mistuning.checked_samples else {}
        for k, result in sweep.run_sweeps(disks, scene, speeds_hz, poll, observers=seen):
            checks = {}
            for name, other in others.items() if checked[k] else ():
                ((_, checks[name]),) = sweep.run_sweeps([disks[k]], other, speeds_hz, poll)
            now = time.perf_counter()
            yield k, amplification.Integrated(result, now - start, checks=checks)
            start = now

    def _finish(self, place: tuple[int, int], response: Any, rubbing: Modes | None) -> Any:
        """Write a sample that has been integrated, in these modes; returns its Outcome."""
        start, blades = time.perf_counter(), deviation(self.config, *place)
        values: dict[str, Any] = {"deviation": blades, "status": FAILED}
        message = response.message
        try:
            if response.result:
                values |= amplification.values_of(self.config, response)
                modes = own_modes_of(self.config, self.prepared, rubbing, blades)
                values |= self._amplifications(modes, blades, values["peak_amplitude_m"])
                message = "" if values["status"] == DONE else "all its points diverged"
        except BAD_NUMBERS as error:
            message = _words(error)
        began = time.perf_counter()
        layout.write_sample(self.file, *place, values)
        ended = time.perf_counter()
        work = Work(1, response.n_steps, response.seconds + ended - start, ended - began)
        numbers = tuple(values.get(kind.of, np.nan) for kind in self.kinds)
        return Outcome(values["status"], numbers, work, message)

    def _amplifications(self, modes: Modes, blades: Any, amplitude: Any) -> dict[Any, Any]:
        """Amplifications of one sample, and its status."""
        linear = amplification.linear_amplitude(self.config, self.prepared, modes, blades)
        stable = np.isfinite(linear) and np.isfinite(self.reference.linear)  # else in flutter
        return {
            "amplification": amplitude / self.reference.contact,
            "linear_amplitude_m": linear,
            "linear_amplification": linear / self.reference.linear if stable else np.nan,
            "status": DONE if np.isfinite(amplitude) and not np.isnan(linear) else FAILED,
        }

    # rank 0

    def _collect(self, task: Any, result: Any) -> Any:
        """Record a finished task; returns whether no further task is needed.

        After the last part of a sample, the whole is written here.
        """
        if task.n_parts > 1:
            whole = self._whole(task, result)
            if whole is None:
                return False
            result = [(task.places[0], self._finish(task.places[0], whole, None))]
        for where, outcome in result:
            self.work += outcome.work
            self.status[where] = outcome.status
            self.failure = outcome.message or self.failure
            if outcome.status == DONE:
                self.numbers[:, *where] = outcome.numbers
            self.progress.sample(*where, outcome, self.numbers[0])
        return self._is_enough()

    # statistics

    def _is_enough(self) -> bool:
        """Whether every level and percentile has converged, if that ends the study (rank 0)."""
        convergence = self.config.convergence
        if not convergence.stop_when_converged:
            return False
        finished = _leading((self.status != PENDING).all(axis=0))
        if finished < max(self.looked_at + convergence.step, self.looked_at * LOOK_AGAIN):
            return False
        self.looked_at = finished
        return self._converged_at() is not None

    def _running(self, values: Any, n: int | None = None) -> list[Any]:
        """RunningPercentiles of numbers (V, n) for every level, up to its first pending sample.

        n: number of samples after which they end; None: none.
        """
        c = self.config.convergence
        how = c.percentiles, c.step, c.z
        return [
            percentiles.running_percentiles(numbers[: _leading(status != PENDING)][:n], *how)
            for numbers, status in zip(values, self.status, strict=True)
        ]

    def _converged_at(self) -> Any:
        """First number of percentile values at which all levels are converged, or None."""
        c = self.config.convergence
        running = self._running(self.numbers[0])
        errors = [percentiles.judged_error(c.criterion, level._asdict()) for level in running]
        shortest = min(error.shape[-1] for error in errors)
        known = np.stack([error[:, :shortest] for error in errors])
        return percentiles.first_converged(known, c.target_error)

    def _write_statistics(self) -> None:
        """Statistics of the finished samples (rank 0).

        A study that stops when it has converged computes some samples more; their number depends
        on the ranks. Its statistics end where it converged.
        """
        self.phase("statistics")
        length = self._converged_at() if self.config.convergence.stop_when_converged else None
        n = length and length * self.config.convergence.step
        for kind, numbers in zip(self.kinds, self.numbers, strict=True):
            for level, running in enumerate(self._running(numbers, n)):
                layout.write_statistics(self.file, kind, level, running)
        if self.reference and self.reference.usable:
            layout.write_verdict(self.file, findings.verdict(self.file))


def _words(error: Any) -> str:
    return f"{type(error).__name__}: {error}"


def _leading(flags: Any) -> int:
    """Number of true values before the first false one."""
    return int(np.argmin(np.append(flags, False)))
