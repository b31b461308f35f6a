"""State of a long task beside its result file, from which it goes on with the same bits."""

import contextlib
import glob
import hashlib
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.config.types import without_suffix
from hpcrub.errors import Interrupted
from hpcrub.response.run_up import Runner
from hpcrub.results import ownership, provenance

EVERY = 60.0  # [s] between two states of a task


def states_of(output: str | Path) -> list[Path]:
    """Files with the kept states of all tasks of a result file."""
    whole = without_suffix(output)
    return sorted(whole.parent.glob(f"{glob.escape(whole.name)}.task-*.npz"))


def forget_all(output: str | Path) -> None:
    """Remove the states beside a result file that begins anew."""
    for path in states_of(output):
        with contextlib.suppress(OSError):
            path.unlink(missing_ok=True)


class Kept:
    """The kept state of one task, in a file that is replaced in one step."""

    def __init__(self, config: Config, task: Iterable[Any]) -> None:
        """task: numbers that name the task."""
        name = "-".join(map(str, task))
        self.path = Path(f"{without_suffix(config.output)}.task-{name}.npz")
        anywhere = config.replace({"output": "moved.h5"})  # it may be moved with its result
        words = f"{anywhere.to_yaml()} {provenance.program_text()}"
        self.origin = np.array(hashlib.sha256(words.encode()).hexdigest())
        self.saved = time.monotonic()

    def finish(self, work: Runner, poll: Any) -> Any:
        """Go on from the kept state, if there is one, to the end; keep the state in between.

        poll: called often. Raises what it raises, after the state is kept. Returns the result.
        """
        damage = OSError, ValueError, KeyError, BadZipFile
        with contextlib.suppress(*damage), np.load(self.path) as state:
            if state["origin"] == self.origin:
                work.restore(state)
        for _ in work.go_on():
            try:
                poll()
            except Interrupted:
                self._save(work)
                raise
            if time.monotonic() - self.saved > EVERY:
                self._save(work)
        return work.result()

    def _save(self, work: Runner) -> None:
        self.saved = time.monotonic()
        parts: dict[str, Any] = work.state()
        with (
            contextlib.suppress(OSError),  # without it a later run begins the task anew
            ownership.replacing(self.path) as part,
            open(part, "wb") as file,
        ):
            np.savez(file, origin=self.origin, **parts)

    def forget(self) -> None:
        """Remove the state of a task that is in the result file, and what a kill left of one."""
        for path in (self.path, ownership.part_of(self.path)):
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)
