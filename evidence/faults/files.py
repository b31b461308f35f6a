"""Result files that are damaged, given to every program that reads one.

Each reader runs in a child of this process, so that one that crashes or hangs is seen.
"""

import contextlib
import itertools
import os
import random
import resource
import signal
import sys
import traceback

import h5py
import numpy as np

from evidence.faults.job import Trial
from evidence.program import TINY
from hpcrub import studies
from hpcrub.__main__ import main as program

PATIENCE = 60  # [s] for one reader
MEMORY = 8 << 30  # bytes that a reader may take more than it has
PHYSICS = "".join(line for line in TINY.splitlines(True) if "mistuning" not in line)
SOURCE = "contact.h5"
SPANS = "history: {duration_s: 0.6}\nspectrum: {window_s: 0.2, max_frequency_hz: 150}\n"
ONE_SPEED = TINY.replace("to_hz: 34.4", "to_hz: 34.0")
SPECIAL = {  # what a study needs besides, or instead; the others take TINY
    "time_response": ONE_SPEED + SPANS,
    "interaction_map": TINY + SPANS,
    "energy": f"sources: [{SOURCE}]\nenergy: {{samples: 2}}\nmistuning: {{samples: 2}}\n{PHYSICS}",
    "branches": "branches: {perturbed: 1}\n" + TINY,
}
INPUTS = {name: SPECIAL.get(name, TINY) for name in studies.STUDIES}  # sources come first
# What reads a result file, with the path of the file and the name of its study. One more program
# that does is one more line here.
READERS = {
    "inspect": lambda path, study: program(["inspect", path]),
    "plot": lambda path, study: program(["plot", path, "--out", "pictures"]),
    "export": lambda path, study: program(["export", path, "--out", "tables"]),
    "--resume": lambda path, study: program([f"{study}.yaml", "--resume", "--output", path]),
    "sources": lambda path, study: program(
        ["energy.yaml", "--set", f"sources=[{path}]", "--output", "of_source.h5", "--overwrite"]
    ),
    "merge": lambda path, study: program(["merge", "merged.h5", path, "--overwrite"]),
    "merge --samples": lambda path, study: program(
        ["merge", "more.h5", path, "--overwrite", "--samples", "3"]
    ),
}
DAMAGES = "bit", "cut"


def make(folder, names=tuple(INPUTS)):
    """One small result file NAME.h5 for each study, with its input, in a folder.

    Returns {name: bytes}.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with contextlib.chdir(folder), silent("making"):
        for name in names:
            with open(f"{name}.yaml", "w", encoding="utf-8") as file:
                file.write(f"study: {name}\noutput: {name}.h5\n{INPUTS[name]}")
            assert program([f"{name}.yaml"]) == 0, name
    return {name: (folder / f"{name}.h5").read_bytes() for name in names}


@contextlib.contextmanager
def silent(log):
    """The standard output and error of this process, and of what it calls, into a file."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept = [os.dup(1), os.dup(2)]
    with open(log, "w") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
        try:
            with contextlib.redirect_stdout(file), contextlib.redirect_stderr(file):
                yield
        finally:
            file.flush()
            for number, copy in zip((1, 2), kept, strict=True):
                os.dup2(copy, number)
                os.close(copy)


def read(folder, reader, path, study):
    """Trial of one reader on one file: 0, 2, or 1 with one line; never a crash, never a hang."""
    log = folder / "log"
    pid = os.fork()
    if pid == 0:
        _child(folder, reader, path, study)
    _, status = os.waitpid(pid, 0)
    said = log.read_text(errors="replace")
    lines = [line for line in said.splitlines() if line.startswith("hpcrub: ")]
    if os.WIFSIGNALED(status):
        name = signal.Signals(os.WTERMSIG(status)).name
        return Trial(name, "", "hangs" if name == "SIGALRM" else f"crashes: {said[-200:]}")
    code, problem = os.WEXITSTATUS(status), ""
    if "Traceback" in said:
        problem = f"a traceback: {said[-400:]}"
    elif code not in (0, 1, 2) or (code and len(lines) != 1):
        problem = f"{code} with {len(lines)} lines: {said[-200:]}"
    return Trial(code, lines[0] if code and lines else "", problem)


def _child(folder, reader, path, study):
    code = 120
    try:
        os.chdir(folder)
        with silent("log"):
            try:
                signal.alarm(PATIENCE)
                resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
                with open("/proc/self/statm", encoding="ascii") as file:
                    size = int(file.read().split()[0]) * resource.getpagesize() + MEMORY
                resource.setrlimit(resource.RLIMIT_AS, (size, size))
                code = READERS[reader](path, study)
            except BaseException:
                traceback.print_exc()
    finally:
        os._exit(code)


def harmed_files(folder, files, n_each, seed=1):
    """Every reader on every file of files ({name: bytes}) with every kind of damage, n_each times,
    each time at another random place outside the data, which nothing guards."""
    for name, content in files.items():
        (folder / "sound.h5").write_bytes(content)
        places = _metadata(folder / "sound.h5", len(content))
        for reader, damage in itertools.product(READERS, DAMAGES):
            rng = random.Random(f"{seed} {name} {reader} {damage}")
            for at in rng.sample(places, n_each):
                (folder / "harmed.h5").write_bytes(_harm(content, at, rng, damage))
                found = read(folder, reader, "harmed.h5", name)
                problem = found.problem and f"{name}, {reader}, {damage} at {at}: {found.problem}"
                yield found._replace(problem=problem)


def _metadata(path, size):
    """Places of a file that hold no values of a dataset."""
    free = np.ones(size, bool)

    def leave_out(_, item):
        if isinstance(item, h5py.Dataset) and item.size:
            start = item.id.get_offset()
            free[start : start + item.id.get_storage_size()] = False

    with h5py.File(path, "r", locking=False) as file:
        file.visititems(leave_out)
    return np.flatnonzero(free).tolist()


def _harm(content, at, rng, kind):
    """The content, harmed at a place in one of the ways of DAMAGES."""
    if kind == "cut":
        return content[:at]
    harmed = bytearray(content)
    harmed[at] ^= 1 << rng.randrange(8)
    return bytes(harmed)


def all_studies(folder):
    """Random damage to files of every study."""
    yield from harmed_files(folder, make(folder), 3)


FAULTS = {"a bit changed, or the end cut, at random": all_studies}
