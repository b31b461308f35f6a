"""Signals, clocks, compiled code, and samples that fail."""

import random
import signal
import time

from evidence.faults.disks import small_disk
from evidence.faults.job import (
    ROOT,
    Job,
    Trial,
    carried_on,
    damage,
    is_alive,
    judged,
    listens,
    run,
    send,
    undisturbed,
    values,
)
from hpcrub.results.layout import DONE, FAILED

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


def stop_before_python(folder, number):
    """The same before Python has begun: nothing can be said, nothing is there."""
    expected, _ = undisturbed()
    job = Job(folder, "study.yaml")
    job.process.send_signal(number)
    trial = _stopped(job, [number.name, 75], (), expected)
    if trial.code == 75 and "stopped" not in trial.said:
        trial = trial._replace(problem="75 without a word")
    yield trial  # 75: on a busy machine Python may have been faster than the signal


def _stopped(job, codes, words, expected):
    code, problem = job.wait(), ""
    if job.result.exists():
        problem = damage(job.result, expected)
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


def paused(folder):
    """SIGSTOP of each rank for three seconds, then SIGCONT."""
    expected, _ = undisturbed()
    for rank in (0, 1):
        job = Job(folder / f"{rank}", "study.yaml", ranks=2)
        job.until(job.result.exists)
        pids = job.by_rank()
        if not pids:
            yield Trial(job.wait(), problem="it ended before it could be paused")
            continue
        send(pids[rank], signal.SIGSTOP)
        time.sleep(3.0)
        problem = "" if is_alive(pids[rank]) else "it had ended before it was paused"
        send(pids[rank], signal.SIGCONT)
        code = job.wait()
        yield judged(job, code, [0], problem=problem or damage(job.result, expected))


def clock(folder):
    """The clock of the day runs backwards, by a minute at every look."""
    expected, _ = undisturbed()
    text = (
        "import time, itertools\nnow = time.time()\nlooks = itertools.count()\n"
        "time.time = lambda: now - 60.0 * next(looks)\n"
        "time.time_ns = lambda: int(1e9 * time.time())\n"
    )
    for ranks in (0, 2):
        place = folder / f"{ranks}"
        job, code = run(place, "study.yaml", ranks=ranks, script=script(place, text))
        yield judged(job, code, [0], problem=damage(job.result, expected))


def sample_fails(folder):
    """An eigenproblem without solution in one sample: it is marked, all others are as ever."""
    expected, _ = undisturbed()
    text = (
        "import numpy as np\nfrom hpcrub.studies import samples\n"
        "from hpcrub.model.mistuning import stiffness_deviation\nsolve = samples.mistuned_modes\n"
        "bad = stiffness_deviation(2020, 1, 3, 12, 0.04)\n"
        "def failing(reduced, deviation):\n"
        "    if np.array_equal(deviation, bad):\n"
        "        raise np.linalg.LinAlgError('Eigenvalues did not converge')\n"
        "    return solve(reduced, deviation)\nsamples.mistuned_modes = failing\n"
    )
    for ranks in (0, 2):
        place = folder / f"{ranks}"
        job, code = run(place, "study.yaml", ranks=ranks, script=script(place, text))
        found, problem = values(job.result), ""
        name = "samples/amplification"
        others = found["samples/status"] == DONE
        if found["samples/status"][1, 3] != FAILED or others.sum() != others.size - 1:
            problem = "not just that sample is marked"
        elif found[name][others].tobytes() != expected[name][others].tobytes():
            problem = "other samples differ"
        elif "level 1, sample 3 failed: LinAlgError" not in job.output():
            problem = "not said"
        yield judged(job, code, [0], problem=problem)


def cold_cache(folder):
    """Environment in which compiled code is kept in this folder, new and empty."""
    folder.mkdir(parents=True)
    return {"XDG_CACHE_HOME": str(folder), "NUMBA_CACHE_DIR": None}


def cache_index(folder):
    """Every index of compiled code cut in half: compiled anew, and mended."""
    expected, _ = undisturbed()
    environment = cold_cache(folder / "cache")
    run(folder / "compiles", "study.yaml", **environment)
    entries = sorted((folder / "cache").rglob("*.nbi"))
    assert entries
    for entry in entries:
        entry.write_bytes(entry.read_bytes()[: entry.stat().st_size // 2])
    sizes = [entry.stat().st_size for entry in entries]
    job, code = run(folder, "study.yaml", **environment)
    mended = [entry.stat().st_size > size for entry, size in zip(entries, sizes, strict=True)]
    problem = damage(job.result, expected) or ("" if all(mended) else "not mended")
    yield judged(job, code, [0], problem=problem)


def cache_not_writable(folder, n_blocked):
    """No place for the compiled code of some of two ranks: said once, and they go on without."""
    expected, _ = undisturbed()
    folder.mkdir(parents=True)
    blocked = folder / "blocked"
    blocked.write_text("a file where the folder should be")
    text = (
        f"if int(os.environ['OMPI_COMM_WORLD_RANK']) >= {2 - n_blocked}:\n"
        f"    os.environ['XDG_CACHE_HOME'] = {str(blocked)!r}\n"
    )
    environment = {"NUMBA_CACHE_DIR": None}
    job, code = run(folder, "study.yaml", ranks=2, script=script(folder, text), **environment)
    words = [f"cannot be kept on {n_blocked} of 2 ranks", "Not a directory", "XDG_CACHE_HOME="]
    problem = damage(job.result, expected)
    if not problem and job.message().count("cannot be kept") != 1:
        problem = f"not said once: {job.message()}"
    yield judged(job, code, [0], words, problem)


def cache_full(folder):
    """The disk of the cache is full when compiled code is to be kept."""
    expected, _ = undisturbed()
    with small_disk(folder / "cache", "64k") as disk:
        environment = {"XDG_CACHE_HOME": str(disk), "NUMBA_CACHE_DIR": None}
        job, code = run(folder, "study.yaml", **environment)
        words = ["compiled code cannot be kept", "No space left on device"]
        yield judged(job, code, [0], words, damage(job.result, expected))


FAULTS = {
    "SIGTERM before Python has begun": lambda f: stop_before_python(f, signal.SIGTERM),
    "SIGTERM while starting, 1 process": lambda f: stop_at_start(f, signal.SIGTERM, 0, 8),
    "SIGTERM while starting, one of 2 ranks": lambda f: stop_at_start(f, signal.SIGTERM, 2, 8),
    "SIGTERM while starting, mpirun": lambda f: stop_mpirun_at_start(f, signal.SIGTERM, 6),
    "SIGINT while starting, 1 process": lambda f: stop_at_start(f, signal.SIGINT, 0, 8),
    "SIGTERM while compiling": compiling,
    "kill -9 while an old file is replaced": killed_in_lay_out,
    "SIGSTOP of a rank, then SIGCONT": paused,
    "clock running backwards": clock,
    "numerical failure in one sample": sample_fails,
    "index of compiled code truncated": cache_index,
    "no folder for compiled code, one of 2 ranks": lambda f: cache_not_writable(f, 1),
    "no folder for compiled code, both ranks": lambda f: cache_not_writable(f, 2),
    "disk of compiled code full": cache_full,
}
