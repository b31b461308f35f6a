"""Result files that are damaged or lie, given to every program that reads one.

Each reader runs in a child of this process, so that one that crashes or hangs is seen.
"""

import contextlib
import io
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
from hpcrub import studies
from hpcrub.__main__ import main as program
from tests.program import TINY

PATIENCE = 60  # [s] for one reader
MEMORY = 8 << 30  # bytes that a reader may take more than it has
PHYSICS = "".join(line for line in TINY.splitlines(True) if "mistuning" not in line)
SOURCE = "contact.h5"
LOW = "material: {damping_ratio: 0.004}\n"
SPANS = "history: {duration_s: 0.6}\nspectrum: {window_s: 0.2, max_frequency_hz: 150}\n"
ONE_SPEED = TINY.replace("to_hz: 34.4", "to_hz: 34.0")
STUDIES = {
    "contact": TINY,
    "low": LOW + TINY,
    "modal": TINY,
    "casing": TINY,
    "linear": TINY,
    "time_response": ONE_SPEED + SPANS,
    "interaction_map": TINY + SPANS,
    "energy": f"sources: [{SOURCE}]\nenergy: {{samples: 2}}\nmistuning: {{samples: 2}}\n{PHYSICS}",
    "cross": f"sources: [{SOURCE}]\n{TINY}",
    "damping": f"sources: [{SOURCE}, low.h5]\n{TINY}",
    "branches": "branches: {perturbed: 1}\n" + TINY,
}
# What reads a result file, with the path of the file and the name of its study. One more program
# that does is one more line here.
READERS = {
    "inspect": lambda path, study: program(["inspect", path]),
    "plot": lambda path, study: program(["plot", path, "--out", "pictures"]),
    "export": lambda path, study: program(["export", path, "--to", "netcdf", "--out", "tables"]),
    "--resume": lambda path, study: program([f"{study}.yaml", "--resume", "--output", path]),
    "sources": lambda path, study: program(
        ["cross.yaml", "--set", f"sources=[{path}]", "--output", "of_source.h5", "--overwrite"]
    ),
    "merge": lambda path, study: program(["merge", "merged.h5", path, "--overwrite"]),
    "merge --samples": lambda path, study: program(
        ["merge", "more.h5", path, "--overwrite", "--samples", "3"]
    ),
}
DAMAGES = "bit", "bytes", "data", "cut"


def make(folder, names=tuple(STUDIES)):
    """One small result file NAME.h5 for each study, with its input, in a folder.

    Returns {name: bytes}.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with contextlib.chdir(folder), silent("making"):
        for name in names:
            study = "contact" if name == "low" else name
            with open(f"{name}.yaml", "w", encoding="utf-8") as file:
                file.write(f"study: {study}\noutput: {name}.h5\n{STUDIES[name]}")
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


# damage


def harmed_files(folder, files, n_each, seed=1):
    """Every reader on every file of files ({name: bytes}) with every kind of damage, n_each times,
    each time at another random place."""
    for (name, content), reader, damage in itertools.product(files.items(), READERS, DAMAGES):
        rng = random.Random(f"{seed} {name} {reader} {damage}")
        for _ in range(n_each):
            harmed, where = _harm(content, rng, damage)
            (folder / "harmed.h5").write_bytes(harmed)
            found = read(folder, reader, "harmed.h5", name)
            problem = found.problem and f"{name}, {reader}, {where}: {found.problem}"
            yield found._replace(problem=problem)


def _harm(content, rng, kind):
    """The content, harmed in one of the ways of DAMAGES, and where."""
    if kind == "cut":
        length = rng.randrange(len(content))
        return content[:length], f"cut to {length}"
    at = rng.randrange(len(content))
    harmed = bytearray(content)
    if kind == "bit":
        harmed[at] ^= 1 << rng.randrange(8)
    elif kind == "bytes":
        harmed[at : at + 16] = rng.randbytes(min(16, len(content) - at))
    else:
        at, harmed = _harm_data(content, harmed, rng)
    return bytes(harmed), f"{kind} at {at}"


def _harm_data(content, harmed, rng):
    """Odd numbers in the data, which no checksum guards."""
    with h5py.File(io.BytesIO(content), "r") as file:
        data = []
        file.visititems(lambda name, item: data.append(item) if is_data(item) else None)
        stretches = [(d.id.get_offset(), d.id.get_storage_size()) for d in data]
    offset, length = rng.choice(stretches)
    odd = rng.choice([np.nan, np.inf, -np.inf, 1e308, -1e308, 5e-324, 0.0, -1.0])
    n = min(8, length)
    at = offset + rng.randrange(0, length - n + 1, n)
    number = np.array(odd).tobytes() if n == 8 else rng.randbytes(n)
    harmed[at : at + n] = number[:n]
    return at, harmed


def is_data(item):
    """Whether something in a file is a dataset with values."""
    return isinstance(item, h5py.Dataset) and item.size > 0


# lies


def _replace(name, **create):
    def lie(file):
        del file[name]
        file.create_dataset(name, **create)

    return lie


def _link(name, link):
    def lie(file):
        del file[name]
        file[name] = link

    return lie


def _attribute(name, value):
    def lie(file):
        file.attrs[name] = value

    return lie


def _remove(name):
    def lie(file):
        del file[name]

    return lie


def _virtual(file):
    layout = h5py.VirtualLayout((2, 2, 3), "f8")
    layout[...] = h5py.VirtualSource("elsewhere.h5", "x", (2, 2, 3))
    del file["samples/time_s"]
    file.create_virtual_dataset("samples/time_s", layout)


HUGE = {"shape": (2, 10**9, 10**6), "dtype": "f8", "chunks": (1, 10, 1000)}
EXTERNAL = [("/etc/hostname", 0, h5py.h5f.UNLIMITED)]
LIES = {
    "another shape": _replace("samples/time_s", data=np.zeros((2, 2, 4000))),
    "no shape": _replace("samples/time_s", data=h5py.Empty("f8")),
    "another type": _replace("samples/time_s", data=np.zeros((2, 2, 3), "f4")),
    "texts for numbers": _replace("samples/time_s", data=[["x", "y"]], dtype=h5py.string_dtype()),
    "a compound type": _replace("samples/time_s", shape=(2, 2, 3), dtype=[("a", "f8")]),
    "references": _replace("samples/time_s", shape=(2, 2, 3), dtype=h5py.ref_dtype),
    "a huge dataset": _replace("samples/time_s", **HUGE),
    "chunks": _replace("samples/time_s", shape=(2, 2, 3), dtype="f8", chunks=(1, 1, 3)),
    "a dataset in another file": _replace(
        "samples/time_s", shape=(2, 2, 3), dtype="f8", external=EXTERNAL
    ),
    "a virtual dataset": _virtual,
    "a soft link to itself": _link("samples/time_s", h5py.SoftLink("/samples/time_s")),
    "an external link": _link("samples/time_s", h5py.ExternalLink("/etc/passwd", "/x")),
    "a group in another file": _link("samples", h5py.ExternalLink("contact.h5", "/samples")),
    "no dataset": _remove("samples/time_s"),
    "no group": _remove("statistics"),
    "a dataset for a group": _replace("tuned", data=np.zeros(3)),
    "numbers for the configuration": _attribute("config", np.arange(5)),
    "no text for the configuration": _attribute("config", h5py.Empty("f8")),
    "a configuration that is no YAML": _attribute("config", "study: [contact"),
    "a configuration with a tag": _attribute("config", "study: !!python/object/apply:os.abort []"),
    "a configuration of 10¹² samples": _attribute("config", "mistuning: {samples: 1000000000000}"),
    "the configuration of another study": _attribute("config", "study: modal"),
    "numbers for the revision": _attribute("git_revision", np.arange(9)),
}


def lies(folder, content, readers=tuple(READERS)):
    """Sound HDF5 files that lie about what they hold."""
    path = folder / "lie.h5"
    for name, lie in LIES.items():
        path.write_bytes(content)
        with h5py.File(path, "r+", locking=False) as file:
            lie(file)
        for reader in readers:
            found = read(folder, reader, "lie.h5", "contact")
            problem = found.problem
            if not problem and found.code != 2 and "revision" not in name:
                problem = f"ends with {found.code}"
            yield found._replace(problem=problem and f"{name}, {reader}: {problem}")


FORGED = {
    "empty": lambda content: b"",
    "a text": lambda content: b"hello\n",
    "zeros": lambda content: bytes(len(content)),
    "only the beginning": lambda content: content[:100],
    "zeros behind the beginning": lambda content: content[:100] + bytes(len(content) - 100),
    "another beginning": lambda content: bytes(100) + content[100:],
}


def forged(folder, content, readers=tuple(READERS)):
    """Files that are no HDF5, or only begin so."""
    for name, forge in FORGED.items():
        (folder / "forged.h5").write_bytes(forge(content))
        for reader in readers:
            found = read(folder, reader, "forged.h5", "contact")
            problem = found.problem or ("" if found.code == 2 else f"ends with {found.code}")
            yield found._replace(problem=problem and f"{name}, {reader}: {problem}")


def not_files(folder, content, readers=tuple(READERS)):
    """Names that lead to no file."""
    (folder / "folder").mkdir()
    os.mkfifo(folder / "fifo")
    (folder / "loop").symlink_to("loop")
    names = ["folder", "fifo", "loop", "/dev/zero", "x" * 300]
    for name in names:
        for reader in readers:
            found = read(folder, reader, name, "contact")
            problem = found.problem or ("" if found.code == 2 else f"ends with {found.code}")
            yield found._replace(problem=problem and f"{name:.20}, {reader}: {problem}")


def all_studies(folder):
    """Random damage to files of every study."""
    yield from harmed_files(folder, make(folder), 3)


def _contact(function):
    """The fault of a contact file, which is made first."""

    def fault(folder):
        content = make(folder, ("contact", "cross"))["contact"]
        yield from function(folder, content)

    return fault


FAULTS = {
    "bytes changed, or the end cut, at random": all_studies,
    "HDF5 that lies": _contact(lies),
    "files that are no HDF5": _contact(forged),
    "names that are no files": _contact(not_files),
}
assert set(STUDIES) - {"low"} == set(studies.STUDIES)
