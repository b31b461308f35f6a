"""Signals at all moments of a run, to a process, to one rank, to all ranks, to mpirun.

``kill -9`` and the two that ask to stop. Some come before the first sample is written, most while
samples are written, some after the last: rank 0 then writes the statistics and draws the figures.
"""

import functools
import random
import signal
import time

from evidence.faults.job import (
    Job,
    Trial,
    carried_on,
    damage,
    is_alive,
    judged,
    listens,
    n_done,
    run,
    script,
    send,
    undisturbed,
    values,
)
from hpcrub.results.layout import DONE

RANKS = 2
ORPHANS = 30.0  # [s] that ranks may outlive their mpirun
EARLY, LATE = 0.25, 0.15  # shares of the trials before the first sample, after the last
STARTING = 0.6  # of the time of a run, until there is a sample


def signalled(number, target, codes, n_trials, folder):
    """Trials: send a signal, look at the end and the file, resume on other ranks, compare."""
    expected, length = undisturbed()
    n_samples, rng = expected["samples/status"].size, random.Random(f"{number} {target}")
    for trial in range(n_trials):
        job = Job(folder / f"{trial}", "study.yaml", ranks=0 if target == "a process" else RANKS)
        job.until(lambda job=job: len(job.below()) >= job.ranks)
        ranks = job.below() if job.ranks else [job.process.pid]
        victims = {"one of two ranks": ranks[trial % RANKS :][:1], "mpirun": [job.process.pid]}
        victims = victims.get(target, ranks)
        if number != signal.SIGKILL and target != "mpirun":
            job.until(lambda victims=victims: all(listens(pid, number) for pid in victims))
        share = (trial + rng.random()) / n_trials
        if share < EARLY:
            job.until(lambda: False, STARTING * length * share / EARLY)
        else:
            amid = (share - EARLY) / (1.0 - EARLY - LATE)
            job.until_done(min(n_samples, 1 + int(amid * n_samples)))
            job.until(lambda: False, length * (share - 1.0 + LATE))
        for pid in victims:
            send(pid, number)
        # a rank that is stopped before all are there says nothing: mpirun tells its exit code
        silent = number == signal.SIGKILL or target == "mpirun"
        silent = silent or (job.ranks and trial % RANKS and not job.result.exists())
        words = [] if silent else [f"hpcrub: stopped: {number.name} came"]
        found = _ended(job, codes, words, expected, ranks)
        others = (1, 3) if job.ranks else (2, 3)
        problem = found.problem or carried_on(job, expected, others[trial // 2 % 2])
        yield found._replace(problem=problem)


def _ended(job, codes, words, expected, ranks):
    """The Trial of a program that got a signal."""
    code, problem, when = job.wait(), _orphans(ranks), "before the file was there"
    if job.result.exists():
        n_samples = expected["samples/status"].size
        problem = problem or damage(job.result, expected)
        n_found = 0 if problem else n_done(job.result)
        when = "while samples were written" if n_found else "before the first sample"
        when = "after the last sample" if n_found == n_samples else when
        if code == 0 and n_found == n_samples:
            codes, words = [0], []  # the signal came when all was done
    return judged(job, code, codes, words, problem)._replace(when=when)


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


def killed_in_lay_out(folder):
    """--overwrite, killed before and after the new file takes the name: one of the two is there."""
    expected, _ = undisturbed()
    for when in ("before", "after"):
        place = folder / when
        run(place, "study.yaml")
        done = "replace(*names)" if when == "after" else "pass"
        text = f"""import os
replace = os.replace
def deadly(*names):
    {done}
    os.kill(os.getpid(), 9)
os.replace = deadly
"""
        other = "--set", "mistuning.seed=2021"
        job, code = run(place, "study.yaml", "--overwrite", *other, script=script(place, text))
        n_found = int((values(job.result)["samples/status"] == DONE).sum())
        whole = expected["samples/status"].size
        problem = "" if n_found == (whole if when == "before" else 0) else "neither old nor new"
        job2, code2 = run(place, "study.yaml", "--resume", *(other if when == "after" else ()))
        problem = problem or ("" if code2 == 0 else f"{when}: {job2.errors()}")
        yield Trial(code, problem=problem, when=f"{when} the file takes its name")


def compiling(folder):
    """SIGTERM while the kernel is compiled: stopped in good order, with nothing done yet."""
    expected, _ = undisturbed()
    (folder / "cache").mkdir(parents=True)
    empty = {"XDG_CACHE_HOME": str(folder / "cache"), "NUMBA_CACHE_DIR": None}
    job = Job(folder, "study.yaml", **empty)
    job.until(lambda: "loading the kernel" in job.output())
    time.sleep(2.0)
    job.process.send_signal(signal.SIGTERM)
    trial = judged(job, job.wait(), [75], ["--resume"])
    yield trial._replace(problem=trial.problem or carried_on(job, expected, 2))


KILL, TERM, INT = signal.SIGKILL, signal.SIGTERM, signal.SIGINT
# signal, target, exit codes, trials. mpirun, when stopped, returns 1, kills its ranks after a
# second and drops what they say by then: they may be too late to say it
CASES = [
    (KILL, "a process", ["SIGKILL"], 13),
    (KILL, "one of two ranks", [137], 13),
    (KILL, "both ranks", [137], 13),
    (KILL, "mpirun", ["SIGKILL"], 13),
    (TERM, "a process", [75], 8),
    (TERM, "one of two ranks", [75], 8),
    (TERM, "mpirun", [1], 6),
    (INT, "a process", [75], 8),
]
FAULTS = {
    **{f"{how[0].name} to {how[1]}": functools.partial(signalled, *how) for how in CASES},
    "SIGTERM while compiling": compiling,
    "SIGKILL while an old file is replaced": killed_in_lay_out,
}
