"""A study of independent tasks: the ranks compute and write them, a resumed run does the rest."""

import time

import numpy as np

from hpcrub import studies
from hpcrub.results.layout import DONE, PENDING
from hpcrub.run.progress import console, print_line
from hpcrub.run.runlog import Work
from hpcrub.studies.warmup import warm_up


class TaskStudy:
    """Tasks of one study of which some may already be in the file."""

    what = "tasks"

    def __init__(self, team, config, problem, file, progress=None, phase=lambda name: None):
        """Arguments as `monte_carlo.Study`; problem: what the study's `prepare` returned."""
        self.team, self.config, self.problem, self.file = team, config, problem, file
        self.progress, self.phase = progress, phase
        self.work = Work()  # rank 0
        self.module = studies.find(config)
        self.status = None  # (T,) on rank 0

    def run(self):
        """Compute what is missing and write it.

        Raises Interrupted on all ranks after a stop signal; what is finished is in the file.
        """
        pending = self.team.on_root(self._take_stock)
        if pending and self.module.KERNEL:
            self.phase("loading the kernel")
            warm_up(self.team, self.config, self.progress)
        self.phase("tasks")
        tasks = map(int, np.flatnonzero(self.status == PENDING)) if self.team.rank == 0 else ()
        self.team.run_tasks(tasks, self._compute, self._collect)

    def n_done(self):
        """Finished tasks and all (rank 0)."""
        return int(np.count_nonzero(self.status == DONE)), len(self.status)

    def summary(self, seconds):
        """Print what was found (rank 0); seconds: wall time of this run."""
        out = console()
        for line in self.module.report(self.file):
            print_line(out, line)

    def require_results(self):
        """A task cannot fail: what it finds may be that all has diverged."""

    def _take_stock(self):
        self.status = self.file.read("status")
        return int(np.count_nonzero(self.status == PENDING))

    def _compute(self, task, poll):
        """Compute and write one task; returns the seconds it took."""
        start = time.perf_counter()
        for name, where, values in self.module.compute(self.problem, task, poll):
            self.file.write({name: values}, where)
        self.file.write({"computed_by": self.file.program, "status": DONE}, task)
        return time.perf_counter() - start

    def _collect(self, task, seconds):
        self.status[task] = DONE
        self.work += Work(1, 0, seconds)
        if self.progress:
            self.progress.tasks(*self.n_done())
