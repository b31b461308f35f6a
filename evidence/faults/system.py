"""Signals at any moment."""

import random
import signal
import time

from evidence.faults.job import (
    ROOT,
    Job,
    Trial,
    carried_on,
    damage,
    judged,
    listens,
    n_done,
    run,
    send,
    undisturbed,
    values,
)
from hpcrub.results.layout import DONE

START_UP = f"import os, sys\nsys.path.insert(0, {str(ROOT)!r})\n"
MAIN = "from hpcrub.__main__ import main\nsys.exit(main())\n"


def script(folder, text):
    """A program that causes a fault in itself and then runs hpcrub."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "fault.py"
    path.write_text(START_UP + text + MAIN)
    return path


def stop_at_start(folder, number, ranks, n_trials):
    """A stop signal at any moment from the first line of hpcrub on, to the process or to one of
    the ranks: said in one line, no traceback, no half-made file."""
    expected, length = undisturbed()
    for trial in range(n_trials):
        job = Job(folder / f"{trial}", "study.yaml", ranks=ranks)
        victim = job.by_rank()[trial % ranks] if ranks else job.process.pid
        job.until(lambda victim=victim: listens(victim, number))
        share = (trial + random.Random(trial).random()) / n_trials
        job.until(lambda: False, 0.6 * share * length)
        send(victim, number)
        # a rank that ends before all are there says nothing: mpirun tells its exit code
        quiet = ranks and trial % ranks and not job.result.exists()
        words = () if quiet else [f"hpcrub: stopped: {number.name} came"]
        yield _stopped(job, [75], words, expected)


def stop_mpirun_at_start(folder, number, n_trials):
    """The same for mpirun, which returns 1. It kills its ranks after a second and drops what they
    say by then: they may be too late to say it."""
    expected, length = undisturbed()
    for trial in range(n_trials):
        job = Job(folder / f"{trial}", "study.yaml", ranks=2)
        job.until(lambda: False, random.Random(trial).random() * length)
        job.process.send_signal(number)
        yield _stopped(job, [1], (), expected)


def _stopped(job, codes, words, expected):
    code, problem = job.wait(), ""
    if job.result.exists():
        problem = damage(job.result, expected)
        if code == 0 and n_done(job.result) == expected["samples/status"].size:
            codes, words = [0], ()  # the signal came after the last sample
    trial = judged(job, code, codes, words, problem)
    return trial._replace(problem=trial.problem or carried_on(job, expected))


def killed_in_lay_out(folder):
    """--overwrite, killed before and after the new file takes the name: one of the two is there."""
    expected, _ = undisturbed()
    for when, seed in (("before", 2020), ("after", 2021)):
        place = folder / when
        run(place, "study.yaml")
        text = (
            "import os\nreplace = os.replace\n"
            "def deadly(*names):\n"
            + ("    replace(*names)\n" if when == "after" else "")
            + "    os.kill(os.getpid(), 9)\n"
            "os.replace = deadly\n"
        )
        other = "--set", "mistuning.seed=2021"
        job, code = run(place, "study.yaml", "--overwrite", *other, script=script(place, text))
        file = values(job.result)
        n_done = int((file["samples/status"] == DONE).sum())
        whole = expected["samples/status"].size
        problem = "" if n_done == (whole if when == "before" else 0) else "neither old nor new"
        arguments = other if when == "after" else ()
        job2, code2 = run(place, "study.yaml", "--resume", *arguments)
        problem = problem or ("" if code2 == 0 else f"seed {seed}: {job2.errors()}")
        yield Trial(code, f"{when} the file takes its name", problem)


def compiling(folder):
    """SIGTERM while the kernel is compiled: stopped in good order, with nothing done yet."""
    expected, _ = undisturbed()
    job = Job(folder, "study.yaml", **cold_cache(folder / "cache"))
    job.until(lambda: "compiling the kernel" in job.output())
    time.sleep(2.0)
    job.process.send_signal(signal.SIGTERM)
    trial = judged(job, job.wait(), [75], ["--resume"])
    yield trial._replace(problem=trial.problem or carried_on(job, expected))


def cold_cache(folder):
    """Environment in which compiled code is kept in this folder, new and empty."""
    folder.mkdir(parents=True)
    return {"XDG_CACHE_HOME": str(folder), "NUMBA_CACHE_DIR": None}


FAULTS = {
    "SIGTERM while starting, 1 process": lambda f: stop_at_start(f, signal.SIGTERM, 0, 8),
    "SIGTERM while starting, one of 2 ranks": lambda f: stop_at_start(f, signal.SIGTERM, 2, 8),
    "SIGTERM while starting, mpirun": lambda f: stop_mpirun_at_start(f, signal.SIGTERM, 6),
    "SIGINT while starting, 1 process": lambda f: stop_at_start(f, signal.SIGINT, 0, 8),
    "SIGTERM while compiling": compiling,
    "kill -9 while an old file is replaced": killed_in_lay_out,
}
