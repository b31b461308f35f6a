"""A study on any number of ranks in simulated time, with the program's own decisions.

Rank 0 assigns tasks by the program's `schedule.Assignments`; ranks behave as in `parallel`: rank 0
looks at its messages at the polls of its own task, or every PAUSE when it has none; the others ask
when they begin their last task. Messages take no time on the way, but rank 0 handles one after
another. At the end it says good-bye to every rank and hears the same.
"""

import heapq
from itertools import count
from typing import NamedTuple

import numpy as np

from hpcrub.config.sections import Mistuning
from hpcrub.ranks import schedule
from hpcrub.ranks.parallel import PAUSE
from hpcrub.studies.contact import tasks as contact_tasks

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
    return _Simulation(costs, machine, n_ranks, cut).run(n_samples)


class _Simulation:
    def __init__(self, costs, machine, n_ranks, cut):
        self.costs, self.machine, self.n_ranks = costs, machine, n_ranks
        self.random = np.random.default_rng(1)
        self.most = max(costs.parts[0], default=1) if cut else 1
        self.events, self.order = [], count()
        self.queue = [[] for _ in range(n_ranks)]
        self.results = [[] for _ in range(n_ranks)]
        self.running = [None] * n_ranks
        self.waiting = {}  # ranks with a finished sample and no reference
        self.inbox, self.asleep = [], False
        self.shares = np.zeros(n_ranks, dtype=bool)  # ranks that know the tuned disk
        self.parts, self.records = {}, {}
        self.useful = self.serving = 0.0
        self.free_at = 0.0  # when rank 0 has handled its last messages

    def run(self, n_samples):
        cut = contact_tasks.n_parts(TUNED_RUNS, self.n_ranks, self.most)
        parts = np.ndindex(TUNED_RUNS, cut)
        tuned = [contact_tasks.TunedPart(run, part, cut) for run, part in parts]
        self.n_tuned = len(tuned)
        samples = ((0, number) for number in range(n_samples))
        self.tasks = contact_tasks.ContactTasks(tuned, samples, n_samples, self.most)
        self.assignments = schedule.Assignments(self.tasks, self.n_ranks)
        for rank in range(1, self.n_ranks):
            self._report(rank, 0.0)
        self._at(0.0, self._serve)
        now = 0.0
        while self.events:
            now, _, action, arguments = heapq.heappop(self.events)
            action(now, *arguments)
        assert self.assignments.finished(), "the ranks wait for each other"
        farewell = self.machine.send + self.machine.receive
        farewell *= (self.n_ranks - 1) * self.machine.slowdown
        seconds = max(now, self.free_at) + farewell
        serving = self.serving + farewell
        return Result(seconds, self.useful, serving)

    def _at(self, when, action, *arguments):
        heapq.heappush(self.events, (when, next(self.order), action, arguments))

    def _cost(self, task):
        """Seconds of a task; all parts of a disk have the costs of one measured disk."""
        if isinstance(task, contact_tasks.SamplePart) and task.response:
            return 0.0
        key = task._replace(part=0)
        if key not in self.records:
            self.records[key] = int(self.random.integers(len(self.costs.whole)))
            self.useful += self.costs.whole[self.records[key]] * self.machine.slowdown
        record = self.records[key]
        if task.n_parts == 1:
            seconds = self.costs.whole[record]
            del self.records[key]
        else:
            seconds = self.costs.parts[record][task.n_parts][task.part]
        return seconds * self.machine.slowdown

    # rank 0

    def _serve(self, now):
        """Handle all messages, send all answers, then go on with the own task."""
        began = now
        for rank, tasks, asks in self.inbox:
            now += self.machine.receive * self.machine.slowdown
            now = self._collect(self.assignments.done(rank, len(tasks)), now)
            if asks:
                self.assignments.ask(rank)
        self.inbox = []
        for rank, tasks in self.assignments.answers():
            now += self.machine.send * self.machine.slowdown
            self._at(now, self._receive, rank, tasks)
        self.serving += now - began
        self.free_at = now
        self._go_on(now)

    def _collect(self, tasks, now):
        """As `contact.MonteCarlo._collect`: the tuned disk and parts of samples."""
        for task in tasks:
            if isinstance(task, contact_tasks.TunedPart):
                self.n_tuned -= 1
                if not self.n_tuned:
                    self.shares[0] = True
                    for rank in range(1, self.n_ranks):
                        now += self.machine.send * self.machine.slowdown
                        self._at(now, self._share, rank)
            elif task.n_parts > 1:
                known = self.parts[task.sample] = self.parts.get(task.sample, 0) + 1
                if known == task.n_parts:
                    self.tasks.urgent.appendleft(task._replace(part=0, n_parts=1, response=(0,)))
        return now

    def _go_on(self, now):
        if self.running[0] is None:
            task = self.assignments.own()
            if task is None:
                self.asleep = True
                return
            self.running[0] = [task, self._cost(task)]
        task, left = self.running[0]
        if left <= 0.0:
            if _is_sample(task) and not self.shares[0]:
                self._at(now + PAUSE, self._serve)
                return
            self.running[0] = None
            now = self._collect(self.assignments.done(0, 1), now + self._finish(task))
            self._at(now, self._serve)
            return
        polls = self.costs.polls
        step = min(left, polls[self.random.integers(len(polls))] * self.machine.slowdown)
        self.running[0][1] -= step
        self._at(now + step, self._serve)

    def _arrive(self, now, *message):
        self.inbox.append(message)
        if self.asleep:
            self.asleep = False
            self._at(max(now + self.random.random() * PAUSE, self.free_at), self._serve)

    # the others

    def _report(self, rank, now, asks=True):
        tasks, self.results[rank] = self.results[rank], []
        self._at(now, self._arrive, rank, tasks, asks)

    def _receive(self, now, rank, tasks):
        self.queue[rank].extend(tasks)
        if self.running[rank] is None:
            self._begin(now + self.random.random() * PAUSE, rank)

    def _begin(self, now, rank):
        task = self.queue[rank].pop(0)
        self.running[rank] = task
        if not self.queue[rank]:
            self._report(rank, now)
        self._at(now + self._cost(task), self._computed, rank)

    def _computed(self, now, rank):
        if self.shares[rank] or not _is_sample(self.running[rank]):
            self._at(now + self._finish(self.running[rank]), self._end, rank)
        else:
            self.waiting[rank] = True

    def _share(self, now, rank):
        self.shares[rank] = True
        if self.waiting.pop(rank, False):
            self._computed(now, rank)

    def _end(self, now, rank):
        self.results[rank].append(self.running[rank])
        self.running[rank] = None
        if not self.queue[rank]:
            self._report(rank, now)
            return
        if not self.shares[rank]:
            self._report(rank, now, asks=False)
        self._begin(now, rank)

    def _finish(self, task):
        return self.machine.finish * self.machine.slowdown * _is_sample(task)


def _is_sample(task):
    """Whether a task ends with a whole sample, which needs the tuned disk."""
    return isinstance(task, contact_tasks.SamplePart) and task.n_parts == 1
