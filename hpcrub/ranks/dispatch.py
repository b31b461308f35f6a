"""The two sides of `parallel.Team.run_tasks`: rank 0 hands out tasks, the others compute them.

All messages go through the communicator of the team.
"""

import contextlib
import time
from collections import deque
from typing import Any

from hpcrub.errors import Interrupted
from hpcrub.ranks.schedule import Assignments

PAUSE = 1e-3  # [s] between two polls of a waiting rank, which would else take the core of another
TO_ROOT, FROM_ROOT = 1, 2  # message tags


class Dispatcher:
    """Rank 0's side of `run_tasks`: it exchanges the messages, `Assignments` decides."""

    def __init__(self, team: Any, assignments: Assignments, compute: Any, on_result: Any) -> None:
        self.team, self.assignments = team, assignments
        self.compute, self.on_result = compute, on_result
        self.present = team.size - 1  # number of ranks that have not said good-bye
        self.stopped_by: Any = None

    def run(self) -> Any:
        """Work until all tasks are done or a signal came; returns the signal's name, else None."""
        self._serve()
        while not self.stopped_by and not self.assignments.finished():
            task = self.assignments.own()
            if task is None:
                time.sleep(PAUSE)
            else:
                with contextlib.suppress(Interrupted):
                    self._collect(0, [self.compute(task, self.poll)])
            self._serve()
        # tell all ranks to end, and receive their messages until each has said good-bye
        for rank in range(1, self.team.size):
            self.team.comm.send(("end", None), rank, FROM_ROOT)
        self._receive()
        while self.present:
            time.sleep(PAUSE)
            self._receive()
        return self.stopped_by

    def poll(self) -> None:
        """Answer the other ranks. Raises Interrupted after a signal."""
        self._serve()
        if self.stopped_by:
            raise Interrupted(self.stopped_by)

    def _serve(self) -> None:
        if self.team.signal:
            self.stopped_by = self.team.signal
        self._receive()
        if not self.stopped_by:
            for rank, tasks in self.assignments.answers():
                self.team.comm.send(("tasks", tasks), rank, FROM_ROOT)

    def _receive(self) -> None:
        """Receive all messages that have arrived."""
        comm = self.team.comm
        while self.team.size > 1 and comm.iprobe(tag=TO_ROOT):
            rank, kind, content = comm.recv(tag=TO_ROOT)
            if kind == "stop":
                self.stopped_by = content
                continue
            self._collect(rank, content)
            if kind == "ask":
                self.assignments.ask(rank)
            self.present -= kind == "bye"

    def _collect(self, rank: Any, results: Any) -> None:
        for task, result in zip(self.assignments.done(rank, len(results)), results, strict=True):
            if self.on_result(task, result):
                self.assignments.closed = True


class Worker:
    """Side of every other rank in `run_tasks`.

    Every message carries the results finished since the last one. A rank sends one to ask for tasks
    when it begins its last task, and again when it has none, and one to say good-bye.
    """

    def __init__(self, team: Any, compute: Any) -> None:
        self.team, self.compute = team, compute
        self.tasks: deque[Any] = deque()
        self.results: list[Any] = []
        self.told = False  # whether rank 0 knows of the signal that came here
        self.ended = False

    def run(self) -> None:
        """Compute tasks until rank 0 tells this rank to end."""
        with contextlib.suppress(Interrupted):  # which drops the running task
            self._tell("ask")
            while self._wait():
                task = self.tasks.popleft()
                if not self.tasks:
                    self._tell("ask")
                self.results.append(self.compute(task, self.poll))
                if not self.tasks:
                    self._tell("ask")
                self.poll()
        while not self.ended:
            self._look()
            time.sleep(PAUSE)
        self._tell("bye")

    def poll(self) -> None:
        """Receive from rank 0. Raises Interrupted at the end."""
        self._look()
        if self.ended or self.told:
            raise Interrupted("stopped")

    def _wait(self) -> bool:
        """Wait for tasks; returns False at the end."""
        while not self.tasks and not self.ended:
            self._look()
            if not self.tasks and not self.ended:
                time.sleep(PAUSE)
        return not self.ended

    def _look(self) -> None:
        """Pass a signal on to rank 0, and receive all its messages."""
        if self.team.signal and not self.told:
            self.told = True
            self._tell("stop", self.team.signal)
        while self.team.comm.iprobe(source=0, tag=FROM_ROOT):
            kind, content = self.team.comm.recv(source=0, tag=FROM_ROOT)
            if kind == "tasks":
                self.tasks.extend(content)
            else:
                self.ended = True

    def _tell(self, kind: Any, content: Any = None) -> None:
        if content is None:
            content, self.results = self.results, []
        self.team.comm.send((self.team.rank, kind, content), 0, TO_ROOT)
