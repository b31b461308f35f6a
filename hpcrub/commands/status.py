"""`hpcrub run INPUT.yaml --status`: how far result files are, and how long the rest will take."""

import contextlib
import datetime
import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hpcrub.config.text import counted
from hpcrub.config.types import without_suffix
from hpcrub.errors import Interrupted
from hpcrub.ranks import progress
from hpcrub.results.layout import PENDING
from hpcrub.results.storage import ResultFile
from hpcrub.runs import kept
from hpcrub.runs.study import Run, Study
from hpcrub.studies import open_result


def status(runs: Sequence[Run]) -> int:
    """Print how far every result file is; returns 0 when all are complete, 75 otherwise."""
    complete = True
    for study, config in runs:
        if not os.path.lexists(config.output):
            progress.say(f"{config.output}: not there yet")
            complete = False
            continue
        with open_result(config.output, config) as file:
            done = study.parts(file) != PENDING
            enough, n_done = bool(done.all()), int(np.count_nonzero(done))
            text = f"{config.output}: {study.amount_done(file, n_done)}"
            if not enough and study.is_enough(file):
                enough, text = True, f"{text}, converged"
            elif not enough:
                text += _left(study, file, n_done) + _kept(config.output)
        progress.say(text)
        complete = complete and enough
    return 0 if complete else Interrupted.exit_code


def _left(study: Study, file: ResultFile, n_done: int) -> str:
    """Time that the rest takes at the rate of the last run, in words; "" if that is not known."""
    goal = study.next_round(file).expected
    n_left = (study.parts(file).size if goal is None else goal) - n_done
    runs = [line for line in log_lines(file.path) if line["event"] == "start"]
    ends = {line["start"]: line for line in log_lines(file.path) if line["event"] == "end"}
    if not runs or n_left <= 0 or any(run["start"] not in ends for run in runs[:-1]):
        return ""
    began = datetime.datetime.fromisoformat(runs[-1]["start"]).timestamp()
    n_before = sum(ends[run["start"]]["done_in_this_run"] for run in runs[:-1])
    n_now, seconds = n_done - n_before, os.path.getmtime(file.path) - began
    if n_now <= 0 or seconds <= 0.0:
        return ""
    ranks = counted(runs[-1]["ranks"], "rank")
    return f", about {progress.duration(n_left * seconds / n_now)} left on {ranks}"


def _kept(output: str) -> str:
    """How many tasks go on from their own state, in words; "" if none does."""
    if not (states := kept.states_of(output)):
        return ""
    where = f"{without_suffix(output)}.task-*.npz"
    return f"; the state of {counted(len(states), 'run')} in progress is in {where}"


def log_lines(output: str | Path) -> Iterator[dict[str, Any]]:
    """Yield the lines of the log of all runs of a result file; none where it cannot be read."""
    path = f"{without_suffix(output)}.runs.jsonl"
    with contextlib.suppress(OSError), open(path, encoding="utf-8") as log:
        for line in log:
            with contextlib.suppress(ValueError):  # of a run that was killed while it wrote
                yield json.loads(line)
