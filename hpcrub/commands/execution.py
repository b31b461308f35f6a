"""One run, from its configuration to its result file and figures, on all ranks."""

import contextlib
import os
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

from hpcrub import __version__, studies
from hpcrub.config.schema import Config
from hpcrub.errors import HpcrubError, InputError, Interrupted, WriteError, reason
from hpcrub.ranks import progress
from hpcrub.ranks.parallel import Team
from hpcrub.ranks.runlog import RunLog, Work
from hpcrub.results import ownership, storage
from hpcrub.results.storage import ResultFile
from hpcrub.studies import files, plausibility, size
from hpcrub.studies.study import Job


class Existing(NamedTuple):
    """What to do with a result file that is there already; refuse it when neither is wanted."""

    resume: bool = False
    overwrite: bool = False
    allow_mixed: bool = False  # go on with what another state of the program has begun


class Finished(NamedTuple):
    """A run that has ended well."""

    seconds: float  # wall time
    n_ranks: int


class Figures(NamedTuple):
    """Whether and how the figures of a run are drawn."""

    wanted: bool = True
    overwrite: bool = False  # pictures that are not of the same results

    def draw(self, paths: list[str]) -> None:
        """Draw the figures of one run, or those of several together, and name all files.

        The results are there: a figure that cannot be drawn is a line, and no failure of the run.
        """
        out = progress.console()
        if len(paths) == 1:
            out.print(f"results: {paths[0]}", soft_wrap=True)
        if not self.wanted:
            return
        try:
            from hpcrub.commands.plot import of_study  # matplotlib takes a second to import

            for found in of_study(paths, overwrite=self.overwrite):
                drawn = not isinstance(found, HpcrubError)
                out.print(f"figure:  {found}" if drawn else f"no figure: {found}", soft_wrap=True)
        except Exception as error:  # whatever a foreign matplotlib set-up raises
            out.print(f"no figure: {type(error).__name__}: {reason(error)}", soft_wrap=True)


def examine_all(runs: list[Config], existing: Existing) -> None:
    """Raises InputError for what is wrong with any of several runs, before all work (rank 0)."""
    made: set[str] = set()
    for config in runs:
        path = os.path.realpath(config.output)
        if path in made:
            raise InputError(f"runs: two runs have the output {config.output}")
        if made.isdisjoint(map(os.path.realpath, config.sources)):  # else they are not there yet
            examine(config, existing)
        made.add(path)


def examine(config: Config, existing: Existing) -> Any:
    """What a study computes with. Raises InputError for all that is wrong before work (rank 0)."""
    goes_on = check_output(config, existing)
    size.check(config, None if goes_on else config.output)
    return studies.find(config).prepare(config)


def check_output(config: Config, existing: Existing) -> bool:
    """Whether to go on with a sound result file, and not to make one. Raises InputError."""
    path = Path(config.output)
    if os.path.isdir(path):
        raise InputError(f"output: {path} is a folder")
    if os.path.realpath(path) in map(os.path.realpath, config.sources):
        raise InputError(f"output: {path} is one of the sources")
    if not os.path.lexists(path):
        return False
    if not (existing.resume or existing.overwrite):
        raise InputError(f"{path} exists: --resume goes on with it, --overwrite replaces it")
    if existing.resume:
        files.check_resumable(path, config, existing.allow_mixed)
    else:
        storage.refuse_foreign(path)
    return existing.resume


def warnings(config: Config, prepared: Any) -> list[str]:
    """What a study that integrates in time does not resolve, a line each.

    prepared: what its `prepare` returned.
    """
    study = studies.find(config)
    if not study.integrates:
        return []
    return list(plausibility.warnings(config, study.problem_of(prepared)))


def claim(
    config: Config, existing: Existing, warned: list[str], stack: contextlib.ExitStack
) -> tuple[str, float]:
    """Make sure that a sound result file is there, and nobody else's (rank 0).

    Returns what that was, and its seconds.
    """
    lock = ownership.Lock(config.output)  # first: another job may just have finished it
    stack.callback(lock.release)
    began = time.monotonic()
    if check_output(config, existing):
        return "check", time.monotonic() - began
    files.lay_out(config.output, config, {"warnings": "\n".join(warned)} if warned else None)
    return "lay-out", time.monotonic() - began


def execute(team: Team, config: Config, existing: Existing, figures: Figures) -> Finished:
    """One study from its configuration to its figures, on all ranks.

    Raises
    ------
    InputError
        Something is wrong with the input; no work has begun.
    Interrupted
        A stop signal came; what is finished is in the file.
    HpcrubError
        Every sample has failed, or the file cannot be written.
    """
    began = time.monotonic()
    problem = team.on_root(lambda: examine(config, existing))
    team.stop_if_asked(config.output)
    with contextlib.ExitStack() as stack:
        earlier = team.on_root(lambda: claim(config, existing, warnings(config, problem), stack))
        with Accounting(config, team, earlier) as log:
            _compute(team, config, problem, log)
            if figures and not config.is_part:
                log.phase("figures")
                team.on_root(lambda: figures.draw([config.output]))
    return Finished(time.monotonic() - began, team.size)


class Accounting:
    """Writes the log of a run on rank 0, however the run ends."""

    def __init__(self, config: Config, team: Team, earlier: tuple[str, float]) -> None:
        """earlier: name and seconds of what came before the log could be written."""
        self.job: Job | None = None
        self.log = RunLog(config.output, team.size, *earlier) if team.rank == 0 else None

    def phase(self, name: str) -> None:
        """The phase `name` begins."""
        if self.log:
            self.log.phase(name)

    def __enter__(self) -> "Accounting":
        return self

    def __exit__(self, kind: Any, error: BaseException | None, trace: Any) -> None:
        if self.log:
            code = getattr(error, "exit_code", 1) if error else 0
            done = self.job.work if self.job else Work()
            self.log.end(done, code, str(error or "").partition("\n")[0])


def _compute(team, config, problem, log):
    """Compute what the result file lacks, then print the summary."""
    file = team.together(lambda: ResultFile(config.output, team.comm, "r+"))
    file.program = team.on_root(lambda: files.register(file))
    try:
        _fill(team, config, problem, file, log)
    except HpcrubError as error:
        # an error of one rank, or of the disk, ends the job, closed or not
        if getattr(error, "shared", False) and not isinstance(error, WriteError):
            file.close()
        raise
    log.phase("close")
    file.close()
    team.on_root(lambda: storage.require_kept(file.path))


def _fill(team, config, problem, file, log):
    """Compute what an open result file lacks, then print the summary."""
    began = time.monotonic()
    study = studies.find(config)
    bar = progress.Progress(config) if team.rank == 0 else None
    job = log.job = study.job(study, team, config, problem, file, bar, log.phase)
    team.on_root(lambda: announce(bar, config, team.size, warnings(config, problem)))
    try:
        job.run()
    except Interrupted as error:
        n_done, n_all = team.on_root(lambda: _stop(bar, job))
        error.args = (
            f"{error} came; {n_done} of {n_all} {job.what} are in {config.output}, and the "
            "same command with --resume computes the others, on any number of ranks",
        )
        raise
    log.phase("summary")
    team.on_root(lambda: _stop(bar, job))
    team.on_root(lambda: job.summary(time.monotonic() - began))
    team.on_root(job.require_results)


def _stop(bar, job):
    bar.stop()
    return job.n_done()


def announce(bar: progress.Progress, config: Config, n_ranks: int, warned: list[str]) -> None:
    """Say what will be computed."""
    ranks = f"{n_ranks} rank{'s'[: n_ranks > 1]}"
    what = ", ".join(amount(config))
    bar.say(f"hpcrub {__version__}: {what}, {ranks}, into {config.output}")
    for line in warned:
        bar.say(f"warning: {line}")


def amount(config: Config) -> Iterable[str]:
    """How much there is to compute, in words."""
    study = studies.find(config)
    yield study.name
    if study.compute:
        n_tasks = study.n_tasks(config)
        yield f"{n_tasks:,} task{'s'[: n_tasks > 1]}"
        return
    levels, samples, speeds = len(config.levels), config.samples, config.speeds.n_values
    what = f"levels x samples x speeds = {levels} x {len(samples):,} x {speeds}"
    if config.is_part:
        which = ", ".join(map(str, config.levels))
        what += f" (levels {which}; samples {samples[0]} to {samples[-1]})"
    yield what
