"""Execution of one run on all ranks, from its configuration to its result file."""

import contextlib
import os
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from hpcrub import __version__
from hpcrub.config import checks
from hpcrub.config.text import counted
from hpcrub.errors import HpcrubError, InputError, Interrupted, WriteError
from hpcrub.ranks import progress
from hpcrub.ranks.parallel import Team
from hpcrub.ranks.runlog import RunLog
from hpcrub.results import ownership, storage
from hpcrub.results.storage import ResultFile
from hpcrub.runs import kept, memory, result_files
from hpcrub.runs.study import Run
from hpcrub.setup.laws import law_of


class Existing(NamedTuple):
    """Options for a result file that exists already; without resume and overwrite it is refused."""

    resume: bool = False
    overwrite: bool = False
    allow_mixed: bool = False  # resume also a file that another state of the program has begun


def examine_all(runs: list[Run], existing: Existing) -> list[Run]:
    """Examine several runs before any work (rank 0). Raises InputError for the first error.

    Returns those that were examined; another one starts from what a run before it computes.
    """
    made: set[str] = set()
    examined = []
    for run in runs:
        path = os.path.realpath(run.config.output)
        if path in made:
            raise InputError(f"runs: two runs have the output {run.config.output}")
        if made.isdisjoint(map(os.path.realpath, run.config.sources)):  # else sources are missing
            examine(run, existing)
            examined.append(run)
        made.add(path)
    return examined


def examine(run: Run, existing: Existing) -> tuple[Any, list[str]]:
    """Check a run before any work (rank 0). Raises InputError for any error.

    Returns what the study's `prepare` returns, and warnings: keys without effect, doubtful numbers,
    and what is not resolved.
    """
    check_output(run, existing)
    memory.check(run)
    prepared = run.prepare()
    warnings = [*checks.keys_without_effect(run.config), *checks.doubtful(run.config)]
    if run.study.integrates:
        warnings += run.study.warnings(run.config, prepared)
    return prepared, warnings


def check_output(run: Run, existing: Existing) -> bool:
    """Whether to resume an existing result file; False: create one. Raises InputError."""
    path = Path(run.config.output)
    if os.path.isdir(path):
        raise InputError(f"output: {path} is a folder")
    if os.path.realpath(path) in map(os.path.realpath, run.config.sources):
        raise InputError(f"output: {path} is one of the sources")
    if not os.path.lexists(path):
        return False
    if not (existing.resume or existing.overwrite):
        raise InputError(f"{path} exists: --resume goes on with it, --overwrite replaces it")
    if existing.resume:
        result_files.check_resumable(path, run, existing.allow_mixed)
    else:
        storage.refuse_foreign(path)
    return existing.resume


def make_sure(run: Run, existing: Existing, warnings: list[str]) -> None:
    """Make sure that a valid result file exists (rank 0). Raises InputError."""
    if not check_output(run, existing):  # again: another job may just have finished the file
        kept.forget_all(run.config.output)
        attributes = {"warnings": "\n".join(warnings)} if warnings else {}
        result_files.lay_out(run.config.output, run, attributes)
    elif existing.allow_mixed:
        result_files.register(run.config.output)


def execute(
    team: Team, run: Run, existing: Existing, draw: Callable[[list[str]], None] | None = None
) -> float:
    """Execute a run from its configuration to its figures, on all ranks; returns core seconds.

    draw: draws the figures of result files (rank 0), if given.
    Raises InputError before any work has begun; Interrupted after a stop signal, with all finished
    results in the file; HpcrubError when every sample has failed or the file cannot be written.
    """
    began = time.monotonic()
    path = run.config.output
    team.together(lambda: law_of(run.config))  # what rank 0 sends may hold an object of its class
    prepared, warnings = team.on_root(lambda: examine(run, existing))

    def go_on() -> None:
        if team.signal:
            raise Interrupted(f"{team.signal} came before {path} was opened")

    team.together(go_on)
    with contextlib.ExitStack() as stack:

        def lock() -> None:
            stack.callback(ownership.Lock(path).release)

        team.on_root(lock)
        with RunLog(path, team.size, writes=team.rank == 0) as log:
            team.on_root(lambda: make_sure(run, existing, warnings))
            log.phase("set-up")
            _compute(team, run, prepared, warnings, log)
            if draw and not run.config.is_part:
                log.phase("figures")
                team.on_root(partial(draw, [path]))
    return (time.monotonic() - began) * team.size


def _compute(team: Team, run: Any, prepared: Any, warnings: list[str], log: Any) -> None:
    """Open the result file, compute what it lacks, and close it."""
    check = partial(result_files.check, run=run)
    file = team.together(lambda: ResultFile(run.config.output, team.comm, "r+", check))
    try:
        _fill(team, run, prepared, warnings, file, log)
    except HpcrubError as error:
        # after an error of one rank, or of the disk, the job ends without closing the file
        if getattr(error, "shared", False) and not isinstance(error, WriteError):
            file.close()
        raise
    log.phase("close")
    file.close()
    team.on_root(lambda: ownership.require_kept(file.path))


def _fill(
    team: Team, run: Any, prepared: Any, warnings: list[str], file: ResultFile, log: Any
) -> None:
    """Compute what the open result file lacks, then print the summary."""
    began = time.monotonic()
    lines = progress.Progress(run.config) if team.rank == 0 else None
    job = log.job = run.study.job(run, team, prepared, file, lines, log.phase)
    if lines:
        ranks = counted(team.size, "rank")
        lines.say(f"hpcrub {__version__}: {run.amount()}, {ranks}, into {run.config.output}")
        for line in warnings:
            lines.say(f"warning: {line}")
    try:
        job.run()
    except Interrupted as error:
        n_done, n_all = team.on_root(job.n_done)
        there = progress.amount(n_done, n_all, job.expected, run.study.unit)
        error.args = (
            f"{error} came; {there} are in {run.config.output}, and the same command with "
            "--resume computes the others, on any number of ranks",
        )
        raise
    log.phase("summary")
    team.on_root(lambda: job.summary(time.monotonic() - began))
    team.on_root(job.require_results)
