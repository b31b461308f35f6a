"""What a study is, and how the ranks compute one of independent tasks.

A study is a module that ends with `STUDY = Study(...)`, and one line in `hpcrub.studies.STUDIES`.
"""

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.ranks.parallel import Team
from hpcrub.ranks.progress import Progress, console, print_line
from hpcrub.ranks.runlog import Work
from hpcrub.results.layout import DONE, MOST_PROGRAMS, PENDING, PROGRAMS, Dataset, computed_by
from hpcrub.results.storage import ResultFile
from hpcrub.studies.cost import Cost
from hpcrub.studies.problem import Problem
from hpcrub.studies.warmup import warm_up

STATUS = Dataset("status", ("task",), "1", "tasks: 0 pending, 1 done", "u1")
Poll = Callable[[], Any]  # called often by whatever takes long; what it raises ends the task
Values = tuple[str, Any, Any]  # dataset, where in it, values
Counts = dict[str, int]


class Job(Protocol):
    """A study on its way: some results may already be in its file."""

    what: str  # it is made of
    work: Work  # done so far, on rank 0

    def run(self) -> None:
        """Compute what is missing and write it; on all ranks."""

    def n_done(self) -> tuple[int, int]:
        """Finished parts of the job, and all (rank 0)."""

    def require_results(self) -> None:
        """Raise HpcrubError when all of the job has failed (rank 0)."""

    def summary(self, seconds: float) -> None:
        """Print what was found (rank 0)."""


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
    figures: str  # of the paper
    what: str
    layout: Callable[[Config], tuple[Dataset, ...]]
    scales: dict[str, str]  # dimension: the dataset with the values along it
    sizes: Callable[[Config], Counts]  # of every dimension, as far as the input tells it
    prepare: Callable[[Config], Any]  # what every rank needs; raises InputError (rank 0)
    report: Callable[[ResultFile], Iterable[str]] = lambda file: ()  # lines about the results
    headline: Callable[[ResultFile], str] | None = None  # its one line in a table of several runs
    # pieces of one task, from what `prepare` returned: (dataset, where in it, values)
    compute: Callable[[Config, Any, int, Poll], Iterator[Values]] | None = None
    n_tasks: Callable[[Config], int] = lambda config: 1
    constants: Callable[[Config], dict[str, Any]] = _nothing  # datasets known without computing
    source_sizes: Callable[[Config], Counts] = _nothing  # dimensions that only the sources tell
    problems: Callable[[Config], Iterable[str]] = lambda config: ()  # keys that do not fit it
    # what all tasks do together, when a point takes so many seconds until it is steady
    cost: Callable[[Config, float], Cost] = lambda config, until_steady: Cost()
    unit: str = "tasks"  # of the job
    # whether a file that lacks some of its parts is complete nevertheless
    is_enough: Callable[[ResultFile], bool] = lambda file: False
    n_sources: int = 0  # result files of contact studies that it starts from
    has_disk: bool = True  # of its own
    integrates: bool = False  # in time, with the contact kernel
    # of a study that integrates: the Problem in what `prepare` returned
    problem_of: Callable[[Any], Problem] = lambda prepared: prepared.problem
    histories: bool = False  # keeps the motion itself, and not only its amplitudes
    has_parts: bool = False  # can be computed in parts, each in a file of its own
    job: Callable[..., Job] = field(default=lambda *arguments: Tasks(*arguments))

    def lines(self, config: Config) -> tuple[Dataset, ...]:
        """Datasets of the result file, the index scales of its dimensions aside."""
        own = self.layout(config)
        if self.compute:
            own = (*own, computed_by("computed_by", ("task",)), STATUS)
        return (*own, PROGRAMS)

    def all_scales(self, config: Config) -> dict[str, str]:
        """{dimension: name of its scale}; {group}: a scale of its own in every group."""
        dimensions = {d: d for line in self.lines(config) for d in line.dimensions}
        return dimensions | self.scales

    def known_sizes(self, config: Config) -> Counts:
        """Length of every dimension that the configuration alone tells."""
        tasks = {"task": self.n_tasks(config)} if self.compute else {}
        return self.sizes(config) | tasks | {"program": MOST_PROGRAMS}

    def all_sizes(self, config: Config) -> Counts:
        """Length of every dimension; for this it may have to look into the sources."""
        return self.known_sizes(config) | self.source_sizes(config)

    def all_problems(self, config: Config) -> Iterator[str]:
        """Lines about keys that do not fit this study."""
        if len(config.sources) != self.n_sources and self.n_sources:
            n_given = len(config.sources)
            yield f"sources: {n_given} result files given, {self.name} needs {self.n_sources}"
        if config.is_part and not self.has_parts:
            key = "part.samples" if config.part.levels is None else "part.levels"
            yield f"{key}: only a contact study can be computed in parts, not {self.name}"
        yield from self.problems(config)

    def one_line(self, file: ResultFile) -> str:
        """The result in one line, for a table of several runs."""
        return self.headline(file) if self.headline else next(iter(self.report(file)), "")

    def check_file(self, file: ResultFile) -> None:
        """Refuse a result file that has not all that this study writes. Raises InputError."""
        length = self.known_sizes(file.config)
        for line in self.lines(file.config):
            if line.since > file.layout:
                continue
            shape, dtype = file.shape(line.name), file.dtype(line.name)
            # what only the sources told is here the same in all datasets
            length = dict(zip(line.dimensions, shape or (), strict=False)) | length
            wanted = tuple(length.get(d) for d in line.dimensions)
            if shape != wanted or dtype != np.dtype(line.dtype):
                raise InputError(
                    f"{file.path} was written by {file.written_by()}: {line.name} is "
                    f"{dtype}{list(shape or ())}, not {np.dtype(line.dtype)}{list(wanted)}"
                )


class Tasks:
    """The job of independent tasks."""

    what = "tasks"

    def __init__(
        self,
        study: Study,
        team: Team,
        config: Config,
        problem: Any,
        file: ResultFile,
        progress: Progress | None = None,
        phase: Callable[[str], None] = lambda name: None,
    ) -> None:
        """A job that has not begun.

        Parameters
        ----------
        study
            What is computed.
        team, config
            The ranks, and the input.
        problem
            What the study's `prepare` returned.
        file
            Open to write on all ranks.
        progress
            On rank 0, None elsewhere.
        phase
            Called with the name of every phase that begins.
        """
        self.study, self.team, self.config, self.problem = study, team, config, problem
        self.file, self.progress, self.phase = file, progress, phase
        self.work = Work()  # rank 0
        self.status = np.zeros(0, dtype=np.uint8)  # (T,) on rank 0

    def run(self) -> None:
        """Compute what is missing and write it.

        Raises Interrupted on all ranks after a stop signal; what is finished is in the file.
        """
        pending = self.team.on_root(self._take_stock)
        if pending and self.study.integrates:
            self.phase("loading the kernel")
            warm_up(self.team, self.config, self.study.histories, self.progress)
        self.phase("tasks")
        tasks = map(int, np.flatnonzero(self.status == PENDING)) if self.team.rank == 0 else ()
        self.team.run_tasks(tasks, self._compute, self._collect)

    def n_done(self) -> tuple[int, int]:
        """Finished tasks and all (rank 0)."""
        return int(np.count_nonzero(self.status == DONE)), len(self.status)

    def require_results(self) -> None:
        """A task cannot fail: what it finds may be that all has diverged."""

    def summary(self, seconds: float) -> None:
        """Print what was found (rank 0); seconds: wall time of this run."""
        out = console()
        for line in self.study.report(self.file):
            print_line(out, line)

    def _take_stock(self):
        self.status = self.file.read("status")
        return int(np.count_nonzero(self.status == PENDING))

    def _compute(self, task, poll):
        """Compute and write one task; returns the seconds it took."""
        start = time.perf_counter()
        for name, where, values in self.study.compute(self.config, self.problem, task, poll):
            self.file.write({name: values}, where)
        self.file.write({"computed_by": self.file.program, "status": DONE}, task)
        return time.perf_counter() - start

    def _collect(self, task, seconds):
        self.status[task] = DONE
        self.work += Work(1, 0, seconds)
        if self.progress:
            self.progress.tasks(*self.n_done())
