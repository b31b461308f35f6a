"""A study on any number of ranks in simulated time, with the program's own decisions.

Rank 0 assigns tasks by the program's `schedule.Assignments`, and the others ask when they begin
their last task, as in `parallel`. A message takes no time on its way, but rank 0 handles one after
another. At the end it says good-bye to every rank and hears the same.
"""

import heapq
from itertools import count
from typing import NamedTuple

import numpy as np

from hpcrub.config.sections import Mistuning
from hpcrub.ranks.schedule import Assignments
from hpcrub.studies.contact.tasks import ContactTasks, SamplePart, TunedPart, n_parts

TUNED_RUNS = Mistuning().tuned_runs


class Machine(NamedTuple):
    """What a rank needs besides integrating in time [s]."""

    receive: float  # rank 0, for a message with its results
    send: float  # rank 0
    finish: float  # eigenproblem, linear peak and writing of a sample
    slowdown: float = 1.0  # of all, when ranks share cores


class Result(NamedTuple):
    """What a simulated study took."""

    seconds: float
    useful: float  # sum of all sweeps, as one rank would integrate them [s]
    serving: float  # seconds that rank 0 was busy with messages

    def efficiency(self, n_ranks):
        """Share of the ranks' time that went into useful work."""
        return self.useful / (n_ranks * self.seconds)


def study(costs, machine, n_ranks, n_samples, cut=True):
    """Simulate one case of n_samples samples in all, each with the costs of a measured disk.

    costs: `costs.Costs`; cut: whether samples are cut into parts.
    """
    most = max(costs.parts[0], default=1) if cut else 1
    of_run = n_parts(TUNED_RUNS, n_ranks, most)
    tuned = [TunedPart(*place, of_run) for place in np.ndindex(TUNED_RUNS, of_run)]
    samples = ((0, number) for number in range(n_samples))
    tasks = ContactTasks(tuned, samples, n_samples, most)
    return _Simulation(costs, machine, n_ranks, tasks, len(tuned)).run()


class _Simulation:
    def __init__(self, costs, machine, n_ranks, tasks, n_tuned):
        self.costs, self.machine, self.n_ranks = costs, machine, n_ranks
        self.tasks, self.n_tuned = tasks, n_tuned  # parts of the tuned disk that are not known yet
        self.assignments, self.random = Assignments(tasks, n_ranks), np.random.default_rng(1)
        self.events, self.order = [], count()
        self.queue, self.finished = ([[] for _ in range(n_ranks)] for _ in range(2))
        self.busy = [None] * n_ranks
        self.waiting = []  # ranks with a sample that is finished but for its reference
        self.known, self.drawn = {}, {}  # parts of samples that are cut, and their costs
        self.useful = self.serving = self.free = 0.0  # free: when rank 0 has handled its messages

    def run(self):
        for rank in range(1, self.n_ranks):
            self._at(0.0, self._message, rank, [], True)
        self._at(0.0, self._own)
        while self.events:
            now, _, action, arguments = heapq.heappop(self.events)
            action(now, *arguments)
        assert self.assignments.finished(), "the ranks wait for each other"
        end = self._serve(now, (self.n_ranks - 1) * (self.machine.send + self.machine.receive))
        return Result(end, self.useful, self.serving)

    def _at(self, when, action, *arguments):
        heapq.heappush(self.events, (when, next(self.order), action, arguments))

    def _serve(self, now, seconds):
        """Let rank 0 handle a message; returns when it has."""
        seconds *= self.machine.slowdown
        self.serving += seconds
        self.free = max(now, self.free) + seconds
        return self.free

    def _message(self, now, rank, finished, asks):
        """Rank 0 hears of tasks that a rank has finished, and sends all answers."""
        now = self._serve(now, self.machine.receive)
        self._collect(self.assignments.done(rank, len(finished)), now)
        if asks:
            self.assignments.ask(rank)
        for other, some in self.assignments.answers():
            self.queue[other] += some
            now = self._serve(now, self.machine.send)
            if self.busy[other] is None:
                self._begin(now, other)
        self._own(now)

    def _own(self, now):
        """Give rank 0 a task of its own, if it has none."""
        if self.busy[0] is None and (task := self.assignments.own()):
            self.queue[0].append(task)
            self._begin(now, 0)

    def _collect(self, tasks, now):
        """As `contact.MonteCarlo._collect`: the tuned disk and parts of samples."""
        for task in tasks:
            if isinstance(task, TunedPart):
                self.n_tuned -= 1
                if not self.n_tuned:
                    told = self._serve(now, (self.n_ranks - 1) * self.machine.send)
                    for rank in self.waiting:
                        self._at(told, self._end, rank)
            elif task.n_parts > 1:
                self.known[task.places] = self.known.get(task.places, 0) + 1
                if self.known[task.places] == task.n_parts:
                    self.tasks.urgent.appendleft(task._replace(part=0, n_parts=1, response=(0,)))

    def _begin(self, now, rank):
        self.busy[rank] = task = self.queue[rank].pop(0)
        if rank and not self.queue[rank]:
            self._report(now, rank)
        self._at(now + self._cost(task) * self.machine.slowdown, self._end, rank)

    def _end(self, now, rank):
        task, self.busy[rank] = self.busy[rank], None
        if self.n_tuned and isinstance(task, SamplePart) and task.n_parts == 1:
            self.busy[rank] = task
            self.waiting.append(rank)
        elif rank == 0:
            self._collect(self.assignments.done(0, 1), now)
            self._own(now)
        else:
            self.finished[rank].append(task)
            if not self.queue[rank] or self.n_tuned:
                self._report(now, rank, asks=not self.queue[rank])
            if self.queue[rank]:
                self._begin(now, rank)

    def _report(self, now, rank, asks=True):
        finished, self.finished[rank] = self.finished[rank], []
        self._at(now, self._message, rank, finished, asks)

    def _cost(self, task):
        """Seconds of a task; all parts of a disk have the costs of one measured disk."""
        is_sample = isinstance(task, SamplePart) and task.n_parts == 1
        finish = self.machine.finish * is_sample
        if is_sample and task.response:
            return finish
        key = task._replace(part=0)
        if key not in self.drawn:
            self.drawn[key] = int(self.random.integers(len(self.costs.whole)))
            self.useful += self.costs.whole[self.drawn[key]] * self.machine.slowdown
        if task.n_parts > 1:
            return self.costs.parts[self.drawn[key]][task.n_parts][task.part]
        return self.costs.whole[self.drawn.pop(key)] + finish
