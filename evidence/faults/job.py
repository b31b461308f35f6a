"""A tiny study as a user runs it: started, disturbed, carried on, compared with an undisturbed one.

Every fault yields `Trial`s. A trial without a problem did what it should.
"""

import contextlib
import os
import signal
import subprocess
import tempfile
import time
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from evidence.page import ROOT
from evidence.program import ENVIRONMENT, TINY, command
from hpcrub import studies
from hpcrub.results.layout import DONE

STUDY = TINY.replace("samples: 2", "samples: 32")
BESIDE = {f"study{ending}" for ending in (".h5", ".png", ".runs.jsonl")}
PATIENCE = 600.0  # [s] for anything that must end by itself: compiling can take minutes


class Trial(NamedTuple):
    """What one disturbed program did."""

    code: int | str  # exit code, or the name of the signal that ended it
    said: str = ""  # its message
    problem: str = ""  # what it should have done
    when: str = ""  # what it was at: counted in the table


class Skip(Exception):
    """A fault that cannot be caused on this machine; says why."""


class Job:
    """A running program in a folder of its own."""

    def __init__(self, folder, *arguments, ranks=0, script=None, **environment):
        """ranks: under mpirun, unless 0; environment: variables, None removes one."""
        self.folder, self.ranks = Path(folder), ranks
        self.folder.mkdir(parents=True, exist_ok=True)
        study = self.folder / "study.yaml"
        if not study.exists():
            study.write_text(STUDY + "output: results/study.h5\n", encoding="utf-8")
        variables = os.environ | ENVIRONMENT | environment
        with open(self.folder / "out", "w") as out, open(self.folder / "err", "w") as err:
            self.process = subprocess.Popen(
                command(ranks, script or ROOT / "main.py", *arguments), cwd=folder,
                env={name: value for name, value in variables.items() if value is not None},
                stdin=subprocess.DEVNULL, stdout=out, stderr=err, start_new_session=True,
            )  # fmt: skip

    @property
    def result(self):
        """Path of the result file."""
        return self.folder / "results" / "study.h5"

    def wait(self, patience=PATIENCE):
        """Exit code, or name of the signal, at its end; "hangs" when there is none."""
        try:
            code = self.process.wait(patience)
        except subprocess.TimeoutExpired:
            self.kill()
            return "hangs"
        return code if code >= 0 else signal.Signals(-code).name

    def kill(self):
        """End the program and all that it started."""
        for pid in [*self.below(), self.process.pid]:
            send(pid, signal.SIGKILL)
        self.process.wait()

    def below(self):
        """Processes that it started, in their order: the ranks, under mpirun."""
        return children(self.process.pid)

    def until(self, condition, patience=PATIENCE):
        """Wait for a condition or for the end of the program; whether the condition came true."""
        end = time.monotonic() + patience
        while time.monotonic() < end and self.process.poll() is None:
            if condition():
                return True
            time.sleep(0.01)
        return False

    def until_done(self, n_wanted):
        """Wait until so many samples are in the file."""
        return self.until(lambda: self.result.exists() and n_done(self.result) >= n_wanted)

    def errors(self):
        """All that it wrote to the standard error."""
        return (self.folder / "err").read_text(errors="replace")

    def output(self):
        """All that it wrote to the standard output."""
        return (self.folder / "out").read_text(errors="replace")

    def message(self):
        """Its own lines in the standard error, without the folder."""
        lines = [line for line in self.errors().splitlines() if line.startswith("hpcrub: ")]
        return " / ".join(lines).replace(f"{self.folder}/", "")


def children(pid):
    """Processes that a process started, in their order; none of one that is gone."""
    with contextlib.suppress(FileNotFoundError):
        return sorted(map(int, Path(f"/proc/{pid}/task/{pid}/children").read_text().split()))
    return []


def send(pid, number):
    """Send a signal to a process that may be gone."""
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, number)


def listens(pid, number):
    """Whether a process handles a signal itself."""
    try:
        lines = Path(f"/proc/{pid}/status").read_text(encoding="ascii").splitlines()
    except (FileNotFoundError, ProcessLookupError):
        return False
    caught = next((line.split()[1] for line in lines if line.startswith("SigCgt")), "0")
    return bool(int(caught, 16) >> (number - 1) & 1)


def is_alive(pid):
    """Whether a process runs (a zombie does not)."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def run(folder, *arguments, **options):
    """Run to the end; returns the Job and its exit code."""
    job = Job(folder, *arguments, **options)
    return job, job.wait()


def script(folder, text):
    """A program that causes a fault in itself, and then runs hpcrub."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "fault.py"
    path.write_text(f"""import sys
sys.path.insert(0, {str(ROOT)!r})
{text}
from hpcrub.__main__ import main
sys.exit(main())
""")
    return path


def n_done(path):
    """Samples that a file has."""
    return int(np.count_nonzero(values(path)["samples/status"] == DONE))


def values(path):
    """{dataset: values} of a result file. Raises InputError when it is not sound."""
    file = studies.open_result(path)
    lines = studies.run_of(file.config).datasets()
    found = {line.name: np.asarray(file.read(line.name)) for line in lines}
    file.close()
    return found


@cache
def undisturbed():
    """Values of the same study on one rank, and how long it takes when all is compiled [s]."""
    with tempfile.TemporaryDirectory() as folder:
        for attempt in ("compiles", "does not"):
            began = time.monotonic()
            job, code = run(f"{folder}/{attempt}", "study.yaml")
            assert code == 0, job.errors()
            took = time.monotonic() - began
        return values(job.result), took


def damage(path, expected):
    """What is wrong with the file of a disturbed study: "" when all that is done is whole."""
    try:
        found = values(path)
    except Exception as error:
        return f"the file does not open: {error}"
    done = found["samples/status"] != 0
    for name, right in expected.items():
        if name.startswith("samples/") and found[name][done].tobytes() != right[done].tobytes():
            return f"{name} of a finished sample differs"
        complete = np.isfinite(found["tuned/linear_amplitude_m"])
        if name.startswith("tuned/") and complete and found[name].tobytes() != right.tobytes():
            return f"{name} differs"
    return ""


def carried_on(disturbed, expected, ranks):
    """Resume a disturbed Job's study on another number of ranks (0: without mpirun); "" when it
    ends with the undisturbed bits and nothing beside."""
    assert max(ranks, 1) != max(disturbed.ranks, 1)
    job, code = run(disturbed.folder, "study.yaml", "--resume", ranks=ranks)
    if code != 0:
        return f"resume on {ranks} ranks ends with {code}: {job.errors()[-300:]}"
    found = values(job.result)
    if any(found[name].tobytes() != expected[name].tobytes() for name in expected):
        return f"resume on {ranks} ranks gives other bits"
    left = {p.name for p in job.result.parent.iterdir()} - BESIDE
    return f"left behind: {', '.join(left)}" if left else ""


def judged(job, code, codes, words=(), problem=""):
    """The Trial of a program that ended, with what is wrong about its end."""
    said, errors = job.message(), job.errors()
    if not problem and code not in codes:
        problem = f"exit code {code}, not {' or '.join(map(str, codes))}: {errors[-300:]}"
    if not problem and "Traceback" in errors + job.output():
        problem = f"a traceback: {errors[-300:]}"
    missing = [word for word in words if word not in said]
    if not problem and missing:
        problem = f"its message lacks {missing[0]!r}: {said or errors[-300:]!r}"
    return Trial(code, said, problem)
