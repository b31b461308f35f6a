"""What a study is, what one run of it is, and how the ranks compute independent tasks.

A study is a module that ends with `STUDY = Study(...)`, and one line in `hpcrub.studies.STUDIES`.
"""

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.config.text import counted
from hpcrub.errors import InputError
from hpcrub.ranks.parallel import Team
from hpcrub.ranks.progress import Progress, console, print_line
from hpcrub.ranks.runlog import Work
from hpcrub.results.layout import DONE, PENDING, SPEEDS, Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.runs.cost import Cost
from hpcrub.runs.verdict import Finding, block
from hpcrub.runs.warmup import warm_up
from hpcrub.setup import imported
from hpcrub.setup.problem import Problem

STATUS = Dataset("status", ("task",), "1", "tasks: 0 pending, 1 done", "u1")
Poll = Callable[[], Any]  # called often by whatever takes long; what it raises ends the task
Values = tuple[str, Any, Any]  # dataset, where in it, values
Counts = dict[str, int]


def _nothing(config: Config) -> dict[str, Any]:
    return {}


@dataclass(frozen=True)
class Study:
    """One kind of study: what its result file holds, and what computes it.

    `layout`, `sizes` and `constants` together say what the file is before anything is computed.
    A study of tasks gives `n_tasks` and `compute`; one whose parts are no independent tasks gives
    a `job` of its own, as `contact` does.
    """

    name: str
    what: str
    layout: Callable[[Config], tuple[Dataset, ...]]
    prepare: Callable[[Config], Any]  # what every rank needs; raises InputError (rank 0)
    # dimension: the dataset with the values along it; of `speed` it is `speeds_hz`
    scales: dict[str, str] = field(default_factory=dict)
    # of dimensions that `Run.known_sizes` does not know, as far as the input tells them
    sizes: Callable[[Config], Counts] = _nothing
    figures: str = ""  # of the paper
    sections: tuple[str, ...] = ()  # of the input, in `config.study_keys`, that it reads
    mistunes: bool = True  # draws the blades of its disks; one that does not takes a pattern alone
    # periods around the disk of the loads whose linear responses it computes
    loads: Callable[[Config], tuple[int, ...]] = lambda config: (config.engine_order or 1,)
    # lines about the results; the first one stands in a table of several runs
    report: Callable[[ResultFile], Iterable[str]] = lambda file: ()
    # what speaks against the results, of which the verdict is made
    findings: Callable[[ResultFile], Iterable[Finding]] = lambda file: ()
    # pieces of one task, from what `prepare` returned: (dataset, where in it, values)
    compute: Callable[[Config, Any, int, Poll], Iterator[Values]] | None = None
    n_tasks: Callable[[Config], int] = lambda config: 1
    constants: Callable[[Config], dict[str, Any]] = _nothing  # datasets known without computing
    source_sizes: Callable[[Config], Counts] = _nothing  # dimensions that only files tell
    problems: Callable[[Config], Iterable[str]] = lambda config: ()  # keys that do not fit it
    # what all tasks do together, when a point takes so many seconds until it is steady
    cost: Callable[[Config, float], Cost] = lambda config, until_steady: Cost()
    unit: str = "tasks"  # of the job, what it is made of
    # whether a file that lacks some of its parts is complete nevertheless
    is_enough: Callable[[ResultFile], bool] = lambda file: False
    n_sources: int = 0  # result files of contact studies that it starts from
    integrates: bool = False  # in time, with the contact kernel
    # of a study that integrates: the Problem in what `prepare` returned
    problem_of: Callable[[Any], Problem] = lambda prepared: prepared.problem
    histories: bool = False  # keeps the motion itself, and not only its amplitudes
    job: Callable[..., "Job"] = field(default=lambda *arguments: Job(*arguments))


class Run(NamedTuple):
    """One study of one configuration."""

    study: Study
    config: Config

    @property
    def n_tasks(self) -> int:
        """Independent tasks; 0 of a study with a job of its own."""
        return self.study.n_tasks(self.config) if self.study.compute else 0

    def datasets(self) -> tuple[Dataset, ...]:
        """Datasets of the result file, the index scales of its dimensions aside."""
        own = self.study.layout(self.config)
        return (*own, STATUS) if self.study.compute else own

    def scales(self) -> dict[str, str]:
        """{dimension: name of its scale}."""
        found = {d for line in self.datasets() for d in line.dimensions}
        named = {"speed": SPEEDS.name} | self.study.scales
        return {d: named.get(d, d) for d in found}

    def known_sizes(self) -> Counts:
        """Length of every dimension that the configuration alone tells."""
        config = self.config
        of_all = {
            "speed": config.speeds.n_values,
            "blade": config.disk.n_blades,
            "mode": config.n_coordinates,
            "strip": config.disk.n_strips,
            "task": self.n_tasks,
        }
        return of_all | self.study.sizes(config)

    def constants(self) -> dict[str, Any]:
        """Datasets that are known without computing. Raises InputError for a source."""
        speeds = {SPEEDS.name: self.config.speeds.values_hz}
        there = {line.name for line in self.datasets()} | set(self.scales().values())
        found = speeds | self.study.constants(self.config)
        return {name: values for name, values in found.items() if name in there}

    def sizes(self) -> Counts:
        """Length of every dimension; for this it may have to look into other files."""
        return self.known_sizes() | self.study.source_sizes(self.config)

    def problems(self) -> Iterator[str]:
        """Lines about keys that do not fit the study."""
        study, config = self
        if len(config.sources) != study.n_sources and study.n_sources:
            n_given = len(config.sources)
            yield f"sources: {n_given} result files given, {study.name} needs {study.n_sources}"
        if config.is_part and study.compute:
            yield f"part.samples: only a contact study can be computed in parts, not {study.name}"
        yield from study.problems(config)

    def checked(self) -> "Run":
        """Itself, if its keys fit the study. Raises InputError."""
        found = list(self.problems())
        if found:
            more = f" (and {len(found) - 1} more)" if len(found) > 1 else ""
            raise InputError(found[0] + more)
        return self

    def prepare(self) -> Any:
        """What every rank needs (rank 0). Raises InputError."""
        imported.require_blade_stiffness(self.config, self.study.mistunes)
        return self.study.prepare(self.config)

    def amount(self) -> str:
        """How much there is to compute, in words."""
        config = self.config
        if self.study.compute:
            return f"{self.study.name}, {counted(self.n_tasks, 'task')}"
        levels, samples, speeds = len(config.levels), config.samples, config.speeds.n_values
        what = f"levels x samples x speeds = {levels} x {len(samples):,} x {speeds}"
        if config.is_part:
            what += f" (samples {samples[0]} to {samples[-1]})"
        return f"{self.study.name}, {what}"


class Job:
    """A run on its way: some results may already be in its file; here of independent tasks."""

    def __init__(
        self,
        run: Run,
        team: Team,
        prepared: Any,
        file: ResultFile,
        progress: Progress | None = None,
        phase: Callable[[str], None] = lambda name: None,
    ) -> None:
        """A job that has not begun.

        prepared: what the study's `prepare` returned; file: open to write on all ranks; progress:
        on rank 0, None elsewhere; phase: called with the name of every phase that begins.
        """
        self.study, self.config = run
        self.team, self.prepared, self.file = team, prepared, file
        self.progress, self.phase = progress, phase
        self.work = Work()  # done so far, on rank 0
        self.status = np.zeros(0, dtype=np.uint8)  # of every task, (T,) on rank 0

    def run(self) -> None:
        """Compute what is missing and write it; on all ranks.

        Raises Interrupted on all ranks after a stop signal; what is finished is in the file.
        """
        pending = self.team.on_root(self._take_stock)
        if pending and self.study.integrates:
            self.phase("loading the kernel")
            problem = self.study.problem_of(self.prepared)
            warm_up(self.team, self.config, problem, self.study.histories, self.progress)
        self.phase("tasks")
        tasks = map(int, np.flatnonzero(self.status == PENDING)) if self.team.rank == 0 else ()
        self.team.run_tasks(tasks, self._compute, self._collect)

    def n_done(self) -> tuple[int, int]:
        """Finished parts of the job, and all (rank 0)."""
        return int(np.count_nonzero(self.status == DONE)), len(self.status)

    def require_results(self) -> None:
        """Raise HpcrubError when all of the job has failed (rank 0): a task never does."""

    def summary(self, seconds: float) -> None:
        """Print what was found (rank 0); seconds: wall time of this run."""
        out = console()
        for place, line in enumerate(block(self.study.findings(self.file))):
            print_line(out, f"- {line}" if place else f"Verdict: {line}.")
        for line in self.study.report(self.file):
            print_line(out, line)

    def _take_stock(self):
        self.status = self.file.read("status")
        return int(np.count_nonzero(self.status == PENDING))

    def _compute(self, task, poll):
        """Compute and write one task; returns the seconds it took."""
        start = time.perf_counter()
        for name, where, values in self.study.compute(self.config, self.prepared, task, poll):
            self.file.write({name: values}, where)
        self.file.write({"status": DONE}, task)
        return time.perf_counter() - start

    def _collect(self, task, seconds):
        self.status[task] = DONE
        self.work += Work(1, 0, seconds)
        if self.progress:
            self.progress.part("tasks", *self.n_done())
