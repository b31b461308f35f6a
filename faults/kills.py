"""``kill -9`` of a process, of one rank, of all ranks, of mpirun, at random moments of a run."""

import random
import signal
import time

from faults.job import Job, Trial, carried_on, damage, is_alive, send, undisturbed

RANKS = 2
SEED = 5
ORPHANS = 30.0  # [s] that ranks may outlive their mpirun
TARGETS = "a process without mpirun", "one of two ranks", "both ranks", "mpirun"


def moments(n, target):
    """n moments as shares of a run, the same ones every time."""
    rng = random.Random(f"{SEED} {target}")
    return [(i + rng.random()) / n for i in range(n)]


def killed(folder, target, n_trials):
    """Trials: kill, look at the file, resume on another number of ranks, compare."""
    expected, _ = undisturbed()
    began = time.monotonic()
    job = Job(folder / "timed", "study.yaml", ranks=_ranks(target))
    job.wait()
    length = time.monotonic() - began
    for trial, moment in enumerate(moments(n_trials, target)):
        yield one(folder / f"{target} {trial}", target, moment * length, 1 + trial % 3, expected)


def _ranks(target):
    return 0 if target == TARGETS[0] else RANKS


def one(folder, target, moment, resumed_on, expected):
    """One kill, that many seconds after the start."""
    job = Job(folder, "study.yaml", ranks=_ranks(target))
    job.until(lambda: False, moment)
    ranks = job.below()
    victims = {"one of two ranks": ranks[-1:], "both ranks": ranks}.get(target, [job.process.pid])
    for pid in victims:
        send(pid, signal.SIGKILL)
    code = job.wait()
    end = time.monotonic() + ORPHANS
    while any(map(is_alive, ranks)) and time.monotonic() < end:
        time.sleep(0.02)
    problem = ""
    if any(map(is_alive, ranks)):
        problem = "ranks live on without mpirun"
        for pid in ranks:
            send(pid, signal.SIGKILL)
    found = "no file yet"
    if job.result.exists():
        problem = problem or damage(job.result, expected)
        found = "a sound file"
    problem = problem or carried_on(folder, expected, ranks=resumed_on)
    return Trial(code, found, problem)
