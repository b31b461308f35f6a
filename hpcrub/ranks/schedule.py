"""Assignment of tasks to ranks: the decisions of rank 0, without messages and without a clock.

`dispatch` carries them out.

- A rank that asks for work gets the next task. It asks when it begins the last task that it has, so
  that the answer is there in time: rank 0 may be computing itself.
- The last tasks go to ranks that have none left: a task must not wait behind another.
- Very many ranks get several tasks with one message, so that rank 0 can answer them all.
"""

from collections import deque
from collections.abc import Iterable, Iterator
from typing import Any

AHEAD = 1.0  # tasks left per rank, above which a rank gets its next task before it needs it
SERVES_ONLY = 512  # number of ranks above which rank 0 computes no tasks itself
ONE_BY_ONE = 1000  # number of ranks that rank 0 can answer after every task


class Tasks:
    """Independent tasks, first come, first served."""

    def __init__(self, tasks: Iterable[Any] = ()) -> None:
        self.urgent: deque[Any] = deque()  # tasks that go before all others
        self.others = deque(tasks)

    def __len__(self) -> int:
        return len(self.urgent) + len(self.others)

    def take(self, n_ranks: int) -> Any:
        """Take the next task; there must be one."""
        return self.urgent.popleft() if self.urgent else self.others.popleft()


class Assignments:
    """Tasks that every rank has, and ranks that ask for more."""

    def __init__(self, tasks: Tasks | Iterable[Any], n_ranks: int) -> None:
        """tasks: Tasks, or any iterable of tasks; n_ranks: number of ranks, rank 0 included."""
        self.tasks = tasks if isinstance(tasks, Tasks) else Tasks(tasks)
        self.n_ranks = n_ranks
        # tasks that every rank has and has not reported yet
        self.held: list[deque[Any]] = [deque() for _ in range(n_ranks)]
        self.n_held = 0
        # ranks in the order in which they asked: `idle` have no task, `early` still have one
        self.idle: dict[int, None] = {}
        self.early: dict[int, None] = {}
        self.closed = False  # no further task is needed

    def done(self, rank: int, n_done: int) -> list[Any]:
        """Return the tasks that `rank` has finished, n_done of them, in their order."""
        self.n_held -= n_done
        return [self.held[rank].popleft() for _ in range(n_done)]

    def ask(self, rank: int) -> None:
        """Note that `rank` asks; with two tasks or more it asked while an answer was on its way."""
        self.early.pop(rank, None)
        if len(self.held[rank]) < 2:
            (self.early if self.held[rank] else self.idle)[rank] = None

    def answers(self) -> Iterator[tuple[int, list[Any]]]:
        """Yield (rank, tasks) for every answer to be sent now."""
        while self.idle and self._n_left():
            yield self._give(self.idle)
        while self.early and not self.tasks.urgent and self._n_left() > AHEAD * self.n_ranks:
            yield self._give(self.early)

    def own(self) -> Any:
        """The task that rank 0 computes next itself, or None."""
        if self.n_ranks > SERVES_ONLY or not self._n_left():
            return None
        return self._note(0, self.tasks.take(self.n_ranks))

    def finished(self) -> bool:
        """Whether nothing is left to hand out or to wait for."""
        return not self.n_held and not self._n_left()

    def _n_left(self) -> int:
        return 0 if self.closed else len(self.tasks)

    def _give(self, asking: Any) -> tuple[Any, Any]:
        rank = next(iter(asking))
        del asking[rank]
        several = min(-(-self.n_ranks // ONE_BY_ONE), self._n_left() // (2 * self.n_ranks))
        several = 1 if self.tasks.urgent else max(1, several)
        return rank, [self._note(rank, self.tasks.take(self.n_ranks)) for _ in range(several)]

    def _note(self, rank: Any, task: Any) -> Any:
        self.held[rank].append(task)
        self.n_held += 1
        return task
