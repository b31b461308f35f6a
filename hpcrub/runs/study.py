"""Base classes of studies, and their runs.

A study is a module of `hpcrub/studies` with a subclass of `Study` and an instance of it, `STUDY`.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from rich.table import Table

from hpcrub import effects
from hpcrub.config import run_up
from hpcrub.config.schema import Config
from hpcrub.config.text import counted
from hpcrub.errors import InputError
from hpcrub.ranks.progress import amount, print_item
from hpcrub.response import history
from hpcrub.response.wear import N_ANGLES
from hpcrub.results.layout import ANGLE, PENDING, SPEEDS, Dataset, Values
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import Finding, Verdict
from hpcrub.runs import findings
from hpcrub.runs.cost import Cost
from hpcrub.runs.job import Job, Round
from hpcrub.setup import imported, plausibility
from hpcrub.setup.disks import Disks, fixed_disks, rubbing_modes
from hpcrub.setup.problem import Problem, build_problem

STATUS = Dataset("status", ("task",), "1", "tasks: 0 pending, 1 done", "u1")
Poll = Callable[[], Any]  # long computations call it often; an exception from it ends the task
Counts = dict[str, int]


class Study:
    """One kind of study: the contents of its result file, and their computation.

    A subclass defines `name`, `what`, `datasets` or `layout`, and `compute`; the rest has defaults.
    `layout`, `sizes` and `constants` describe the file before anything is computed.
    A study whose results tell what to compute next has a `next_round`; `contact` has its own `job`.
    """

    name: str
    what: str  # description in a few words
    datasets: tuple[Dataset, ...] = ()  # of the result file, unless `layout` returns others
    sections: tuple[str, ...] = ()  # sections of `config.study_keys` that it reads
    # {dimension: dataset with its values}; `Run.scales` adds `speed` and `angle`
    scales: Mapping[str, str] = {}
    mistunes = True  # whether it draws disks at random; else only a pattern mistunes them
    n_sources = 0  # number of contact studies' result files from which it starts
    integrates = False  # whether it integrates in time, with the contact kernel
    to_second_order = False  # whether it may compute some of its disks to second order as well
    histories = False  # whether it keeps whole motions, not only amplitudes
    job: type[Job] = Job  # class that computes a run on all ranks
    of_tasks = True  # whether it consists of independent tasks; else `layout` has the status
    unit = "tasks"  # name of the parts of the job

    def layout(self, config: Config) -> tuple[Dataset, ...]:
        """Datasets of the result file."""
        return *self.datasets, *self.of_effects(config)

    def of_effects(self, config: Config) -> tuple[Dataset, ...]:
        """Datasets that the effects of an input add."""
        return tuple(d for e in effects.of(config) for d in e.datasets.get(self.name, ()))

    def sizes(self, config: Config) -> Counts:
        """Lengths of dimensions that `Run.known_sizes` lacks, as far as the input tells them."""
        return {}

    def source_sizes(self, config: Config) -> Counts:
        """Lengths of dimensions that only the sources tell."""
        return {}

    def constants(self, config: Config) -> dict[str, Any]:
        """Values of datasets that need no computing. Raises InputError for a bad source."""
        return {}

    def problems(self, config: Config) -> Iterable[str]:
        """Error lines about keys that do not fit the study."""
        return ()

    def prepare(self, config: Config) -> Any:
        """Prepare the data for all ranks (rank 0): by default a Problem. Raises InputError."""
        return build_problem(config)

    def problem_of(self, prepared: Any) -> Problem:
        """Problem in the result of `prepare`, if the study integrates."""
        return getattr(prepared, "problem", prepared)

    def warnings(self, config: Config, prepared: Any) -> Iterator[str]:
        """Warnings about what a study that integrates does not resolve; prepared: by `prepare`."""
        problem = self.problem_of(prepared)
        yield from plausibility.warnings(config, problem)
        yield from (w for e in effects.of(config) for w in e.warnings(config, problem))

    def loads(self, config: Config) -> tuple[int, ...]:
        """Numbers of periods around the disk of the loads whose linear responses it computes."""
        return (config.engine_order or 1,)

    def n_tasks(self, config: Config) -> int:
        """Number of independent tasks."""
        return 1

    def compute(self, config: Config, prepared: Any, task: Any, poll: Poll) -> Iterator[Values]:
        """Yield the results of one task: (dataset, where in it, values).

        prepared: by `prepare`; task: its index in the dataset `status`.
        """
        raise NotImplementedError

    def n_together(self, prepared: Any) -> int:
        """Most tasks that are worth computing together; prepared: as `prepare` returns it."""
        return 1

    def compute_all(
        self, config: Config, prepared: Any, tasks: Sequence[Any], poll: Poll
    ) -> Iterator[tuple[Any, list[Values]]]:
        """Compute tasks together, and yield (task, its values) for each that is complete."""
        for task in tasks:
            yield task, list(self.compute(config, prepared, task, poll))

    def compute_to_second_order(
        self, file: ResultFile, tasks: Sequence[Any], poll: Poll
    ) -> Iterator[tuple[Any, list[Values]]]:
        """Compute tasks once more, of a round to second order, as `compute_all`."""
        raise NotImplementedError

    def cost(self, config: Config) -> Cost:
        """Amount of work in all tasks together."""
        return Cost()

    def tried(self, config: Config) -> list[Config]:
        """Inputs of which a dry run tries a disk each; a disk of the study costs their mean."""
        return [config]

    def needs(self, config: Config) -> str:
        """How much the study will compute, in words, if that depends on its results; else ""."""
        return ""

    def parts(self, file: ResultFile) -> np.ndarray:
        """Status of all parts of a file, of any shape."""
        return file.status

    def n_parts(self, status: np.ndarray, task: Any) -> int:
        """Number of parts that a task has; status: of all parts, as `parts`."""
        return int(np.size(status[task]))

    def next_round(self, file: ResultFile) -> Round:
        """Tasks that are computed next, and what the results in the file tell so far (rank 0)."""
        return Round(np.flatnonzero(file.status == PENDING).tolist())

    def is_enough(self, file: ResultFile) -> bool:
        """Whether a file is complete, although some of its parts may be missing."""
        last = self.next_round(file)
        there = (np.allclose(file.read(n), v, equal_nan=True) for n, v in last.known.items())
        return not last.tasks and all(there)  # written, perhaps with another rounding

    def amount_done(self, file: ResultFile, n_done: int) -> str:
        """How many parts of a file are done, of those that are expected, in words."""
        expected = self.next_round(file).expected
        if expected and self.is_enough(file):
            expected = 0
        return amount(n_done, self.parts(file).size, expected, self.unit)

    def report(self, file: ResultFile) -> Iterable[str]:
        """Lines about the results; the first line stands in a table of several runs."""
        return ()

    def findings(self, file: ResultFile) -> Iterable[Finding]:
        """Findings against the results, for the verdict."""
        return ()

    def verdict(self, file: ResultFile) -> Verdict:
        """Verdict on the results."""
        doubts = findings.not_resolved(file.warnings)
        return Verdict.of([*doubts, *effects.findings(file), *self.findings(file)])

    def answer(self, file: ResultFile, usable: bool) -> Iterable[str | Table]:
        """Lines and tables of the results; usable: whether the verdict calls them usable."""
        return self.report(file)

    def conclusion(self, file: ResultFile, usable: bool) -> Iterable[str]:
        """Lines, of `report` or `answer`, that answer what was asked; usable: as in `answer`."""
        return list(self.report(file))[:1]

    # of a study that can be computed in parts, which has the section `part`

    derived: tuple[str, ...] = ()  # datasets of samples that follow from others, or from the input

    def has_tuned(self, file: ResultFile) -> bool:
        """Whether the tuned disk is complete."""
        raise NotImplementedError

    def complete(self, run: "Run", file: ResultFile) -> None:
        """Write what follows from all samples of a file."""

    def print_results(self, file: ResultFile) -> None:
        """Print verdict and results."""
        verdict = self.verdict(file)
        for item in (*verdict.printed(), *self.answer(file, verdict.usable)):
            print_item(item)


class StudyInTime(Study):
    """A study of histories of every disk and group of speeds, `history.duration_s` long."""

    mistunes = False
    integrates = histories = True

    @property
    def time_key(self) -> str:
        """Key of the time after which a motion that has not settled ends."""
        return "history.duration_s" if "history" in self.sections else findings.TIME_KEY

    def prepare(self, config: Config) -> Any:
        """Prepare the Problem and the modes of all disks. Raises InputError."""
        problem = build_problem(config)
        disks = fixed_disks(config)
        return Disks(problem, [rubbing_modes(config, problem, blades) for blades in disks])

    def n_tasks(self, config: Config) -> int:
        """Number of disks times number of groups of speeds."""
        return len(fixed_disks(config)) * len(history.groups(config.speeds.values_hz))

    def cost(self, config: Config) -> Cost:
        """Histories of every disk over the whole duration."""
        n_disks = len(fixed_disks(config))
        return Cost(histories=n_disks * config.history.duration_s, disks=n_disks)


class Run(NamedTuple):
    """One study of one configuration."""

    study: Study
    config: Config

    @property
    def n_tasks(self) -> int:
        """Number of independent tasks; 0 for a study with a job of its own."""
        return self.study.n_tasks(self.config) if self.study.of_tasks else 0

    def datasets(self) -> tuple[Dataset, ...]:
        """Datasets of the result file, without the index scales of its dimensions."""
        own = self.study.layout(self.config)
        return (*own, STATUS) if self.study.of_tasks else own

    def scales(self) -> dict[str, str]:
        """{dimension: name of its scale}."""
        dimensions = {d for line in self.datasets() for d in line.dimensions}
        named = {"speed": SPEEDS.name, "angle": ANGLE.name} | dict(self.study.scales)
        return {d: named.get(d, d) for d in dimensions}

    def known_sizes(self) -> Counts:
        """Lengths of the dimensions that the configuration alone tells."""
        config = self.config
        of_all = {
            "level": len(config.levels),
            "sample": len(config.samples),
            "speed": config.speeds.n_values,
            "blade": config.disk.n_blades,
            "mode": config.n_coordinates,
            "strip": config.disk.n_strips,
            "angle": N_ANGLES,
            "task": self.n_tasks,
        }
        for effect in effects.of(config):
            of_all |= effect.sizes(config)
        return of_all | self.study.sizes(config)

    def constants(self) -> dict[str, Any]:
        """Values of datasets that need no computing. Raises InputError for a bad source."""
        there = {line.name for line in self.datasets()} | set(self.scales().values())
        angles = np.arange(N_ANGLES) * (360.0 / N_ANGLES)
        of_all = {SPEEDS.name: self.config.speeds.values_hz, ANGLE.name: angles}
        known = of_all | self.study.constants(self.config)
        return {name: values for name, values in known.items() if name in there}

    def sizes(self) -> Counts:
        """Lengths of all dimensions; source files may have to be read for them."""
        return self.known_sizes() | self.study.source_sizes(self.config)

    def problems(self) -> Iterator[str]:
        """Error lines about keys that do not fit the study."""
        study, config = self
        if len(config.sources) != study.n_sources and study.n_sources:
            n_given = len(config.sources)
            yield f"sources: {n_given} result files given, {study.name} needs {study.n_sources}"
        if config.is_part and "part" not in study.sections:
            yield f"part.samples: a {study.name} study cannot be computed in parts"
        if study.integrates and not ("history" in study.sections or run_up.runs_up(config)):
            yield from plausibility.steady_problems(config)
        yield from study.problems(config)

    def checked(self) -> "Run":
        """Return the run itself if its keys fit the study. Raises InputError."""
        if lines := list(self.problems()):
            more = f" (and {len(lines) - 1} more)" if len(lines) > 1 else ""
            raise InputError(lines[0] + more)
        return self

    def prepare(self) -> Any:
        """Prepare the data for all ranks (rank 0). Raises InputError."""
        imported.require_blade_stiffness(self.config, self.study.mistunes)
        return self.study.prepare(self.config)

    def amount(self) -> str:
        """Amount of computation, in words."""
        config = self.config
        if self.study.of_tasks:
            return f"{self.study.name}, {counted(self.n_tasks, 'task')}"
        levels, samples, speeds = len(config.levels), config.samples, config.speeds.n_values
        at, n = "speeds", f"{speeds}"
        if run_up.runs_up(config):
            at, n = "runs x repeats", f"{len(run_up.schedules(config))} x {config.run_up.repeats}"
        what = f"levels x samples x {at} = {levels} x {len(samples):,} x {n}"
        if config.is_part:
            what += f" (samples {samples[0]} to {samples[-1]})"
        needs = self.study.needs(config)
        return f"{self.study.name}, {what}" + (f" at most; {needs}" if needs else "")
