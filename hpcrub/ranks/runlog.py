"""The log of all runs of a study: NAME.runs.jsonl beside its result file.

Each run adds two lines of JSON, one when it starts and one when it ends; a run that was killed has
the first only. A log that cannot be written does not stop a study.
"""

import datetime
import json
import operator
import os
import platform
import socket
import time
from pathlib import Path
from typing import Any, NamedTuple, Self

from hpcrub import __version__
from hpcrub.config.types import without_suffix
from hpcrub.errors import Interrupted, complain, reason

REASONS = {0: "done", 2: "wrong input", Interrupted.exit_code: "stopped"}


class Work(NamedTuple):
    """Work of all ranks together in one run."""

    n_done: int = 0  # samples, or other parts of a study
    n_steps: int = 0  # time steps of all speeds; 0 where they are not counted
    seconds: float = 0.0  # [s] in which ranks were busy, summed over the ranks
    writing: float = 0.0  # [s] of these, for writing samples; lay-out and statistics are phases

    def __add__(self, other: "Work") -> "Work":  # type: ignore[override]
        return Work(*map(operator.add, self, other))


class RunLog:
    """Log of one run, for a `with` statement; writes its last line however the block ends."""

    def __init__(self, output: str | Path, n_ranks: int, writes: bool = True) -> None:
        """Write the first line; writes: whether this rank writes, which only rank 0 does."""
        self.writes = writes
        self.job: Any = None  # a `runs.job.Job`, once there is one
        self.path = Path(f"{without_suffix(os.path.abspath(output))}.runs.jsonl")
        self.n_ranks = n_ranks
        self.began = time.monotonic()
        self.phases: dict[str, float] = {}  # seconds of the phases that are over
        self.current = "lay-out", self.began  # phase, and when it began
        self.about = {
            "output": str(output),
            "start": _now(),
            "ranks": n_ranks,
            "host": socket.gethostname(),
            "job": os.environ.get("SLURM_JOB_ID", ""),
            "hpcrub": __version__,
            "python": platform.python_version(),
        }
        self._append({"event": "start", **self.about})

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: Any, error: BaseException | None, trace: Any) -> None:
        code = getattr(error, "exit_code", 1) if error else 0
        done = self.job.work if self.job else Work()
        self.end(done, code, str(error or "").partition("\n")[0])

    def phase(self, name: str) -> None:
        """Begin the phase `name`, and end the one before it."""
        (last, since), now = self.current, time.monotonic()
        self.phases[last] = self.phases.get(last, 0.0) + now - since
        self.current = name, now

    def end(self, work: Work, code: int, message: str = "") -> None:
        """Write the last line: work, exit code, and a message that says what was wrong."""
        self.phase("end")
        wall = time.monotonic() - self.began
        busy = max(work.seconds, 1e-9)
        rate = round(work.n_steps / busy)
        self._append(
            {
                "event": "end",
                **self.about,
                "end": _now(),
                "exit_code": code,
                "exit_reason": REASONS.get(code, "failed"),
                "message": message,
                "wall_seconds": round(wall, 3),
                "core_seconds": round(wall * self.n_ranks, 3),
                "done_in_this_run": work.n_done,
                "steps": work.n_steps or None,  # only a contact study counts steps
                "steps_per_second_and_core": rate or None,
                "idle_share": round(max(0.0, 1.0 - work.seconds / (wall * self.n_ranks)), 4),
                "writing_share": round(work.writing / busy, 6),
                "phases": {name: round(seconds, 3) for name, seconds in self.phases.items()},
            }
        )

    def _append(self, line: dict[str, Any]) -> None:
        if not self.writes:
            return
        try:
            with open(self.path, "a", encoding="utf-8") as file:
                file.write(json.dumps(line) + "\n")
        except OSError as error:
            complain(f"hpcrub: no run log: {self.path}: {reason(error)}")


def _now() -> Any:
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
