"""Amount and cost of a study, estimated by computing a small part of it; table of several runs."""

import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from rich import box
from rich.table import Table

from hpcrub.config.schema import PROFILE, Config
from hpcrub.config.text import counted, is_table, show
from hpcrub.contact import status
from hpcrub.effects import casing_motion
from hpcrub.errors import HpcrubError
from hpcrub.ranks import progress
from hpcrub.ranks.parallel import Team
from hpcrub.ranks.progress import say
from hpcrub.response.scene import can_touch
from hpcrub.results.layout import PENDING
from hpcrub.runs import cost, memory, result_files
from hpcrub.runs.execution import Existing, examine, examine_all
from hpcrub.runs.study import Run
from hpcrub.runs.warmup import warm_up
from hpcrub.setup.problem import Problem, build_problem
from hpcrub.studies import open_result

LONGEST_WORD = 48  # letters of the longest unbroken word, a key with its value, in a table of runs


def report(runs: Sequence[Run], existing: Existing, n_ranks: int) -> None:
    """Print what runs would compute and cost (rank 0). Raises InputError as the runs would."""
    if len(runs) == 1:
        _one(runs[0], existing, n_ranks)
        return
    examined = examine_all(list(runs), existing)
    total = 0.0
    for number, run in enumerate(runs, 1):
        say(f"\nrun {number} of {len(runs)}")
        if run in examined:
            total += _one(run, existing, n_ranks)
        else:
            say(f"computes:             {run.amount()}, not estimated: from a run before it")
    say(f"\nall {counted(len(examined), 'run')}:          {_estimate(total, n_ranks)}")


def _one(run: Any, existing: Existing, n_ranks: int) -> Any:
    """Print what one study would compute and cost; returns its time on one core [s]."""
    study, config = run
    prepared, warnings = examine(run, existing)
    problem: Any = study.problem_of(prepared) if study.integrates else None
    say(f"computes:             {run.amount()}")
    say(f"output:               {result_files.file_size(run) / 1e6:,.4g} MB in {config.output}")
    say(f"memory:               {memory.estimate(run) / 1e6:,.4g} MB of each rank, at most")
    for line in warnings:
        say(f"warning:              {line}")
    if study.integrates and problem.reduced.casing is not None:
        casing = problem.reduced.casing
        crossings = casing_motion.interactions(config, problem.reduced, casing)
        for line in casing_motion.wave_lines(config, casing, crossings):
            say(line)
    if not study.cost(config).disks:
        return 0.0
    seconds = _try(run, problem) * _share_left(run, existing)
    n_ranks = min(n_ranks, run.n_tasks or n_ranks)
    say(f"estimated run time:   {_estimate(seconds, n_ranks)}")
    return seconds


def _share_left(run: Any, existing: Existing) -> Any:
    """Share of a study that its result file lacks; 1 without a file that is resumed."""
    if not existing.resume or not os.path.lexists(run.config.output):
        return 1.0
    with open_result(run.config.output) as file:
        parts = run.study.parts(file)
        n_done = np.count_nonzero(parts != PENDING)
        expected = run.study.next_round(file).expected or 0
        goal = expected if n_done < expected else parts.size
        there = 1.0 if run.study.is_enough(file) else n_done / goal
    say(f"already there:        {100 * there:.3g} %")
    return 1.0 - there


def _try(run: Any, problem: Problem) -> float:
    """Compute a small part of a study; returns the time of all of it on one core [s]."""
    study, config = run
    problem, inputs = problem or build_problem(config), study.tried(config)
    if study.integrates:
        warm_up(Team(), config, problem, study.histories)
        disks = "one disk" if len(inputs) == 1 else f"one disk at {len(inputs)} values of the key"
        say(f"trial:                {disks}, for about {len(inputs) * cost.LONGEST:g} s at most")
    seconds, touch = [], not study.integrates
    for here in inputs:
        own = problem if here is config else build_problem(here)
        touch = touch or can_touch(own.scene)
        tried = cost.trial(here, own, study.loads(here), study.integrates, study.histories)
        if tried.result:
            rate = f"{tried.steps_per_second / 1e6:.3g} million steps per second and core"
            say(f"measured:             {rate}, {tried.until_steady:.3g} s simulated per point")
            counts = status.count(tried.result.point_reason)
            for line in status.lines(counts, len(tried.result.point_reason)):
                say(f"tried, one disk:      {line}")
        if tried.seconds_of_runs:
            runs = progress.duration(tried.seconds_of_runs)
            say(f"measured:             {runs} for all run-ups of a disk")
        seconds.append(tried.seconds(study.cost(here), here))
    if not touch:
        say("contact:              none, the bumps do not reach the blades")
    if len(inputs) > 1:
        n_disks = study.cost(config).disks
        ends = (progress.duration(end(seconds) / n_disks) for end in (min, max))
        say(f"one disk takes:       {' to '.join(ends)}; the estimate takes the mean")
    return float(np.mean(seconds))


def _estimate(seconds: Any, n_ranks: int) -> str:
    ranks = counted(n_ranks, "rank")
    return f"{progress.duration(seconds / n_ranks)} on {ranks}, {seconds / 3600:,.3g} core hours"


def table(runs: Sequence[Run], outcomes: Sequence[float | HpcrubError]) -> Table:
    """Table of several runs, a row for each: keys of its own, core hours, result in one line.

    outcomes: core seconds of every run, or its error.
    """
    rows = Table(box=box.SIMPLE_HEAD, title="Runs")
    for heading in ("run", "its own keys", "core hours", "result"):
        rows.add_column(heading, overflow="fold")
    for number, (run, outcome) in enumerate(zip(runs, outcomes, strict=True), 1):
        hours, result = "-", f"failed: {outcome}"
        if isinstance(outcome, float):
            hours = f"{outcome / 3600:.3g}"
            with open_result(run.config.output) as file:
                result = next(iter(run.study.report(file)), "")
        rows.add_row(str(number), _own_keys(runs, run.config), hours, result)
    for column in rows.columns[:3]:  # no number is broken
        words = " ".join(str(cell) for cell in column.cells).split()
        column.min_width = min(LONGEST_WORD, max(map(len, words)))
    return rows


def _own_keys(runs: Any, config: Config) -> Any:
    """Text of the keys, with values, in which one of several runs differs from any other."""
    values = config.by_path()
    rows = [run.config.by_path() for run in runs]
    keys = {key for row in rows for key in row if row[key] != values[key]} - {"output"}
    if not keys.isdisjoint(PROFILE):
        keys, values = keys - {*PROFILE} | {"casing"}, values | {"casing": config.casing.words}
    keys = {key for key in keys if values[key] is not None and not is_table(values[key])}
    return ", ".join(f"{key}={show(values[key])}" for key in sorted(keys)) or config.output
