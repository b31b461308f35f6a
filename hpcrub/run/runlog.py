"""A run → a line for people in NAME.log, and a line for accounting in NAME.runs.jsonl.

Both lie beside the result file and grow by one run after another. A run that was killed has its
start in the log and nothing more. What cannot be written does not stop a study.
"""

import datetime
import json
import os
import platform
import socket
import sys
import time
from pathlib import Path
from typing import NamedTuple

from hpcrub import __version__
from hpcrub.config.types import without_suffix
from hpcrub.errors import Interrupted

REASONS = {0: "done", 2: "wrong input", Interrupted.exit_code: "stopped"}


class Work(NamedTuple):
    """What all ranks together have done in one run."""

    n_done: int = 0  # samples or tasks
    n_steps: int = 0  # time steps of all speeds; 0 where they are not counted
    seconds: float = 0.0  # ranks were busy
    writing: float = 0.0  # of these, for writing samples [s]; lay-out and statistics are phases

    def __add__(self, other):
        return Work(*(a + b for a, b in zip(self, other, strict=True)))


class RunLog:
    """The log of one run, on rank 0."""

    def __init__(self, output, n_ranks, earlier="set-up", seconds=0.0):
        """output: result file; n_ranks: ranks of this run; earlier: phase of so many seconds that
        is over. Writes the first line."""
        self.output, self.path = str(output), Path(f"{without_suffix(output)}.log")
        self.n_ranks = n_ranks
        self.started, self.began = _now(), time.monotonic() - seconds
        self.phases, self.current = {earlier: seconds}, None
        self.place = {
            "host": socket.gethostname(),
            "job": os.environ.get("SLURM_JOB_ID", ""),
            "hpcrub": __version__,
            "python": platform.python_version(),
        }
        where = ", ".join(f"{name} {value}" for name, value in self.place.items() if value)
        self._append(self.path, f"{self.started} start: {n_ranks} ranks, {where}, {output}")
        self.phase("set-up")

    def phase(self, name):
        """The phase `name` begins, the last one ends; None: nothing begins."""
        now = time.monotonic()
        if self.current:
            last, since = self.current
            self.phases[last] = self.phases.get(last, 0.0) + now - since
        self.current = (name, now) if name else None

    def end(self, work, code, message=""):
        """The run ends with an exit code; work: Work; message: what was wrong. Writes the rest."""
        self.phase(None)
        wall = time.monotonic() - self.began
        reason = REASONS.get(code, "failed")
        summary = {
            "output": self.output,
            "start": self.started,
            "end": _now(),
            "exit_code": code,
            "exit_reason": reason,
            "message": message,
            "ranks": self.n_ranks,
            "wall_seconds": round(wall, 3),
            "core_seconds": round(wall * self.n_ranks, 3),
            "done_in_this_run": work.n_done,
            "steps": work.n_steps or None,  # only a contact study counts them
            "steps_per_second_and_core": round(_rate(work)) or None,
            "idle_share": round(max(0.0, 1.0 - work.seconds / max(wall * self.n_ranks, 1e-9)), 4),
            "writing_share": round(work.writing / max(work.seconds, 1e-9), 6),
            "phases": {name: round(seconds, 3) for name, seconds in self.phases.items()},
            **self.place,
        }
        phases = ", ".join(f"{name} {seconds:.2f} s" for name, seconds in self.phases.items())
        message = f" ({message})" if message else ""
        self._append(
            self.path,
            f"{summary['end']} {reason}{message}: {wall:.2f} s; {phases}; "
            f"{work.n_done} samples or tasks, {_steps(work)}"
            f"ranks idle {100 * summary['idle_share']:.1f} %",
        )
        self._append(self.path.with_suffix(".runs.jsonl"), json.dumps(summary))

    @staticmethod
    def _append(path, line):
        try:
            with open(path, "a", encoding="utf-8") as file:
                file.write(line + "\n")
        except OSError as error:
            print(f"hpcrub: no run log: {path}: {error.strerror}", file=sys.stderr, flush=True)


def _rate(work):
    return work.n_steps / max(work.seconds, 1e-9)


def _steps(work):
    if not work.n_steps:
        return ""
    return f"{work.n_steps} steps, {_rate(work) / 1e6:.2f} million per second and core, "


def _now():
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
