"""``kill -9`` of a process, of one rank, of all ranks, of mpirun, at all moments of a run.

A kill counts when the program still ran. Some come before the first sample is written, most while
samples are written, some after the last: rank 0 then writes the statistics and draws the figures.
"""

import random
import signal
import time

from evidence.faults.job import (
    Job,
    Trial,
    carried_on,
    damage,
    is_alive,
    n_done,
    send,
    undisturbed,
)

RANKS = 2
SEED = 5
ORPHANS = 30.0  # [s] that ranks may outlive their mpirun
TARGETS = "a process without mpirun", "one of two ranks", "both ranks", "mpirun"
OTHERS = {0: (2, 3), RANKS: (1, 3)}  # ranks of the resumed run, by those of the killed one
EARLY, LATE = 0.25, 0.15  # shares of the kills before the first sample, after the last
ATTEMPTS = 5  # to hit a program that still runs


def moments(n, target, n_samples):
    """n moments, the same ones every time: (samples that must be in the file, share of the time
    until the first sample, or of the time after the last one, to wait from then on)."""
    rng = random.Random(f"{SEED} {target}")
    n_early, n_late = round(EARLY * n), round(LATE * n)
    n_amid = n - n_early - n_late
    early = [(0, (i + rng.random()) / n_early) for i in range(n_early)]
    amid = [(1 + int((i + rng.random()) / n_amid * (n_samples - 2)), 0.0) for i in range(n_amid)]
    late = [(n_samples, (i + rng.random()) / n_late) for i in range(n_late)]
    return early + amid + late


def killed(folder, target, n_trials):
    """Trials: kill, look at the file, resume on another number of ranks, compare."""
    expected, _ = undisturbed()
    n_samples = expected["samples/status"].size
    ranks = 0 if target == TARGETS[0] else RANKS
    spans = timed(folder / "timed", ranks, n_samples)
    for number, (n_wanted, share) in enumerate(moments(n_trials, target, n_samples)):
        for attempt in range(ATTEMPTS):
            place = folder / f"{target} {number} {attempt}"
            job = Job(place, "study.yaml", ranks=ranks)
            wait = share * spans[n_wanted > 0] * 0.7**attempt
            trial = one(job, target, n_wanted, wait, number, expected)
            if trial:
                yield trial
                break
        else:
            yield Trial("", problem=f"{ATTEMPTS} programs ended before they were killed")


def timed(folder, ranks, n_samples):
    """Seconds of an undisturbed run until its first sample, and after its last one."""
    began = time.monotonic()
    job = Job(folder, "study.yaml", ranks=ranks)
    job.until_done(1)
    first = time.monotonic()
    job.until_done(n_samples)
    last = time.monotonic()
    job.wait()
    return first - began, time.monotonic() - last


def one(job, target, n_wanted, wait, number, expected):
    """The Trial of one kill, so many seconds after so many samples are in the file; None when the
    program had ended before."""
    ranks = job.by_rank()
    if n_wanted:
        job.until_done(n_wanted)
    job.until(lambda: False, wait)
    victims = _victims(job, target, number, ranks)
    hit = [pid for pid in victims if is_alive(pid)]
    for pid in victims:
        send(pid, signal.SIGKILL)
    code = job.wait()
    if not hit or code == 0:
        return None
    problem = _orphans(ranks)
    right = 128 + signal.SIGKILL if target in (TARGETS[1], TARGETS[2]) else "SIGKILL"
    if code != right:
        problem = problem or f"exit code {code}, not {right}: {job.errors()[-300:]}"
    when = "before the file was there"
    if job.result.exists():
        problem = problem or damage(job.result, expected)
        when = "" if problem else _when(n_done(job.result), expected["samples/status"].size)
    problem = problem or carried_on(job, expected, OTHERS[job.ranks][number // 2 % 2])
    return Trial(code, problem=problem, when=when)


def _victims(job, target, number, ranks):
    """Processes to kill; one of two ranks is rank 0 and rank 1 in turn."""
    if target == "one of two ranks":
        return [pid for rank, pid in enumerate(ranks) if rank == number % RANKS]
    return ranks if target == "both ranks" else [job.process.pid]


def _orphans(ranks):
    """What is wrong when ranks live on without their mpirun; they are ended."""
    end = time.monotonic() + ORPHANS
    while any(map(is_alive, ranks)) and time.monotonic() < end:
        time.sleep(0.02)
    if not any(map(is_alive, ranks)):
        return ""
    for pid in ranks:
        send(pid, signal.SIGKILL)
    return "ranks live on without mpirun"


def _when(n_found, n_samples):
    if n_found in (0, n_samples):
        return "after the last sample" if n_found else "before the first sample"
    return "while samples were written"
