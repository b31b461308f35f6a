"""A run in progress: ranks compute rounds of tasks, and write their results."""

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from hpcrub.ranks.parallel import Team
from hpcrub.ranks.progress import Progress
from hpcrub.ranks.runlog import Work
from hpcrub.results.layout import DONE, PENDING
from hpcrub.results.storage import ResultFile
from hpcrub.runs.warmup import warm_up
from hpcrub.setup.problem import Problem, build_problem, checks_second_order, to_second_order


class Round(NamedTuple):
    """What a study computes next, which the results in its file alone tell."""

    tasks: Sequence[Any]  # indices in the dataset `status`; none: the study is over
    known: Mapping[str, Any] = {}  # {dataset: values} that the results tell so far
    expected: int | None = None  # parts that are probably needed; 0: not known; None: all
    phase: str = ""  # name of the tasks; those of another name take another time
    status: str = "status"  # dataset in which the tasks are marked as done
    integrates: bool = True  # whether the tasks need the kernel, if the study integrates
    # parts that are still expected, these tasks included, by the first index of a task (K,), where
    # it tells how long they take; None: one part takes as long as another
    ahead: np.ndarray | None = None
    to_second_order: bool = False  # whether the tasks are disks once more, to second order


class Job:
    """A run in progress; its file may already hold some of the results.

    It computes rounds of tasks: a round begins when all tasks of the one before are in the file.
    """

    def __init__(
        self,
        run: Any,
        team: Team,
        prepared: Any,
        file: ResultFile,
        progress: Progress | None = None,
        phase: Callable[[str], None] = lambda name: None,
    ) -> None:
        """Create a job that has not begun.

        - run: a `Run`; prepared: returned by its study's `prepare`.
        - file: open for writing on all ranks.
        - progress: needed on rank 0 to compute.
        - phase: called with the name of every phase that begins.
        """
        self.study, self.config = run
        self.team, self.prepared, self.file = team, prepared, file
        self.progress: Any = progress
        self.phase = phase
        self.work = Work()  # done so far, on rank 0
        self.before = Work()  # of it, which does not tell the time left
        self.ahead: np.ndarray | None = None  # as in the round, less what is done of it
        self.taken = np.zeros((2, 0))  # number of tasks by their first index, and seconds (2, K)
        self.expected: int | None = None  # as in the round
        self.status: np.ndarray = np.zeros(0, np.uint8)  # of every part at the begin, on rank 0
        self.n_finished = 0  # parts, on rank 0
        self.n_bent = 0  # tasks to second order that are done, on rank 0
        self.round: Any = None  # Round, on all ranks without its tasks
        self.tasks: Sequence[Any] = ()  # of the round, on rank 0
        self.kernels: set[bool] = set()  # that are loaded, by `Round.to_second_order`

    def run(self) -> None:
        """Compute and write all missing results, round after round (all ranks).

        Raises Interrupted on all ranks after a stop signal; finished results are in the file.
        """
        self.team.on_root(self._take_stock)
        while planned := self.team.on_root(self._plan):
            is_missing = planned.to_second_order not in self.kernels
            if planned.integrates and self.study.integrates and is_missing:
                self.load_kernel(planned.to_second_order)
            if self.round is None or self.round.phase != planned.phase:
                self.phase(planned.phase or self.study.unit)
                if planned.ahead is None or self.round is None:
                    self.begin()
            self.round = planned
            self.team.run_tasks(self.tasks, self._compute, self._collect)

    def load_kernel(self, of_second_order: bool = False) -> Problem:
        """Compile a kernel, or load it, before anything is measured (all ranks).

        Returns the problem for which the kernel is.
        """
        self.phase("loading the kernel")
        problem, next_problem = self.study.problem_of(self.prepared), None
        if of_second_order:
            problem = self.team.on_root(self._problem_to_second_order)
        elif self.study.to_second_order and checks_second_order(self.config):
            next_problem = self._problem_to_second_order
        histories = self.study.histories and not of_second_order
        warm_up(self.team, self.config, problem, histories, next_problem)
        self.kernels.add(of_second_order)
        self.begin()
        return problem

    def _problem_to_second_order(self) -> Problem:
        return build_problem(to_second_order(self.config))

    def begin(self) -> None:
        """Tell the time left by the tasks from now on, because those before took another time."""
        if self.progress:
            self.progress.began, self.before = time.monotonic(), self.work

    def n_done(self) -> tuple[int, int]:
        """Number of finished parts of the job, and of all parts (rank 0)."""
        return self.n_finished, self.status.size

    def require_results(self) -> None:
        """Raise HpcrubError when all of the job has failed (rank 0); tasks never fail."""

    def summary(self, seconds: float) -> None:
        """Print verdict and results (rank 0); seconds: wall time of this run."""
        self.study.print_results(self.file)

    def _take_stock(self) -> Any:
        self.status = self.study.parts(self.file)
        self.n_finished = int(np.count_nonzero(self.status != PENDING))

    def _plan(self) -> Any:
        """Write what is known, and plan the next round; without its tasks, None at the end."""
        planned = self.study.next_round(self.file)
        self.file.write(planned.known, ())
        tasks, n = list(planned.tasks), 1
        if planned.integrates:
            # each rank gets two shares, so that none waits long for the others
            n = min(self.study.n_together(self.prepared), -(-len(tasks) // (2 * self.team.size)))
        self.tasks = [tasks[first : first + n] for first in range(0, len(tasks), max(n, 1))]
        self.expected, self.ahead = planned.expected, planned.ahead
        return planned._replace(tasks=(), known={}) if planned.tasks else None

    def _compute(self, tasks: Any, poll: Any) -> Any:
        """Compute tasks together, and write each, its status last. Returns the duration [s]."""
        start = time.perf_counter()
        if self.round.to_second_order:
            computed = self.study.compute_to_second_order(self.file, tasks, poll)
        else:
            computed = self.study.compute_all(self.config, self.prepared, tasks, poll)
        for task, found in computed:
            for name, where, values in found:
                self.file.write({name: values}, where)
            self.file.write({self.round.status: DONE}, task)
        return time.perf_counter() - start

    def _collect(self, tasks: Any, seconds: Any) -> None:
        """Count tasks that took some seconds, and tell how far the job is (rank 0)."""
        if self.round and self.round.to_second_order:  # no parts: each disk was one already
            self.n_bent += len(tasks)
            self.progress.part(self.round.phase, self.n_bent, sum(map(len, self.tasks)))
            return
        n_parts = sum(self.study.n_parts(self.status, task) for task in tasks)
        self.n_finished += n_parts
        self.work += Work(n_parts, 0, seconds)
        left = self._seconds_left(tasks, seconds)
        self.progress.part(self.study.unit, *self.n_done(), left, self.expected)

    def _seconds_left(self, tasks: Any, seconds: Any) -> float:
        """Time that what is expected will take, after tasks that took some seconds (rank 0)."""
        elapsed, before = time.monotonic() - self.progress.began, self.before
        if self.ahead is None:
            n_done, n_all = self.n_done()
            goal = n_all if self.expected is None else min(self.expected, n_all)
            return (goal - n_done) * elapsed / (self.work.n_done - before.n_done)
        if not self.taken.size:
            self.taken = np.zeros((2, len(self.ahead)))
        for task in tasks:
            self.ahead[task[0]] -= 1
            self.taken[:, task[0]] += 1.0, seconds / len(tasks)
        known = np.flatnonzero(self.taken[0])  # others take as long as their neighbours
        each = np.interp(np.arange(len(self.ahead)), known, np.divide(*self.taken[::-1, known]))
        share = elapsed / (self.work.seconds - before.seconds)  # of the ranks' time
        return share * float(np.maximum(self.ahead, 0.0) @ each)
