"""Who computes what next: the decisions of rank 0, without messages and without a clock.

`parallel` carries them out, and `scaling` simulates them with the same code.

- A rank that asks for work gets it in the order of the tasks. It asks when it begins its last task,
  so that the next one is there in time: rank 0 may be computing itself.
- The last tasks go to ranks that have nothing left: a task must not wait behind another.
- Very many ranks get several tasks with one message, so that rank 0 can answer them all.
- Samples are cut into parts when fewer of them than ranks are left.
"""

from collections import deque
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

AHEAD = 1.0  # tasks left per rank, above which a rank gets its next one before it needs it
SERVES_ONLY = 512  # ranks from which on rank 0 computes nothing itself
ONE_BY_ONE = 1000  # ranks that rank 0 can answer after every task
PART = 8  # speeds of a part: as many as are integrated together in the narrowest lanes


class Tuned(NamedTuple):
    """Every n_parts-th speed of one run of the tuned disk."""

    run: int = 0
    part: int = 0
    n_parts: int = 1


class Sample(NamedTuple):
    """Every n_parts-th speed of one sample.

    When all parts are computed, one rank gets the whole `response` and writes it.
    """

    level: int
    sample: int
    part: int = 0
    n_parts: int = 1
    response: tuple | None = None


def most_parts(n_speeds: int) -> int:
    """The most parts into which a sweep of n_speeds is worth cutting."""
    return max(1, -(-n_speeds // PART))


def n_parts(n_left: int, n_ranks: int, most: int) -> int:
    """Parts into which the next of n_left sweeps is cut: one until the ranks outnumber them.

    Half the ranks are counted: parts cost more than a whole, and most ranks are busy at the end.
    """
    return min(most, max(1, n_ranks // (2 * max(n_left, 1))))


class Tasks:
    """Independent tasks, first come, first served."""

    def __init__(self, tasks: Iterable[Any] = ()) -> None:
        self.urgent: deque[Any] = deque()  # others may have to wait for these
        self.others = deque(tasks)

    def __len__(self) -> int:
        return len(self.urgent) + len(self.others)

    def take(self, n_ranks: int) -> Any:
        """The next task; there must be one."""
        return self.urgent.popleft() if self.urgent else self.others.popleft()


class StudyTasks(Tasks):
    """Tasks of a contact study: the tuned disk and the samples."""

    def __init__(
        self, tuned: list[Tuned], samples: Iterable[tuple[int, int]], n_samples: int, most: int
    ) -> None:
        """Take the tasks of a study.

        samples: iterable of n_samples pairs (level, sample), drawn one at a time; most: parts of a
        sample, at most.
        """
        super().__init__()
        self.urgent.extend(tuned)
        self.samples, self.n_samples, self.most = iter(samples), n_samples, most

    def __len__(self) -> int:
        return super().__len__() + self.n_samples

    def take(self, n_ranks: int) -> Any:
        """The next task; there must be one. The parts of a sample follow each other."""
        if self.urgent:
            return super().take(n_ranks)
        cut = n_parts(self.n_samples, n_ranks, self.most)
        self.n_samples -= 1
        first, *rest = (Sample(*task, part, cut) for task in [next(self.samples)]
                        for part in range(cut))  # fmt: skip
        self.urgent.extend(rest)
        return first


class Assignments:
    """Which rank has which tasks, and which rank asks for more."""

    def __init__(self, tasks: Tasks | Iterable[Any], n_ranks: int) -> None:
        """tasks: Tasks, or any iterable of tasks; n_ranks: all of them, rank 0 included."""
        self.tasks = tasks if isinstance(tasks, Tasks) else Tasks(tasks)
        self.n_ranks = n_ranks
        # tasks of every rank, not reported yet
        self.held: list[deque[Any]] = [deque() for _ in range(n_ranks)]
        self.n_held = 0
        # ranks that ask, in that order: with no task, with some
        self.idle: dict[int, None] = {}
        self.early: dict[int, None] = {}
        self.closed = False  # no further task is needed

    def done(self, rank: int, n_done: int) -> list[Any]:
        """The tasks that `rank` has finished, n_done of them, in their order."""
        self.n_held -= n_done
        return [self.held[rank].popleft() for _ in range(n_done)]

    def ask(self, rank: int) -> None:
        """`rank` asks for more. With two tasks or more an answer was on its way as it asked."""
        self.early.pop(rank, None)
        if len(self.held[rank]) < 2:
            (self.early if self.held[rank] else self.idle)[rank] = None

    def answers(self) -> Iterator[tuple[int, list[Any]]]:
        """Yield (rank, tasks) to be sent now."""
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

    def _n_left(self):
        return 0 if self.closed else len(self.tasks)

    def _give(self, asking):
        rank = next(iter(asking))
        del asking[rank]
        several = min(-(-self.n_ranks // ONE_BY_ONE), self._n_left() // (2 * self.n_ranks))
        several = 1 if self.tasks.urgent else max(1, several)
        return rank, [self._note(rank, self.tasks.take(self.n_ranks)) for _ in range(several)]

    def _note(self, rank, task):
        self.held[rank].append(task)
        self.n_held += 1
        return task
