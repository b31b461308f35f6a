"""A file system without locks, as NFS without lockd: flock and fcntl give ENOLCK."""

import os
import shutil
import subprocess
import sys

import pytest

from evidence.truth.hexahedra import sector_arrays
from hpcrub.results import model_file
from tests.program import ENVIRONMENT, datasets, run, run_on

LIBRARY = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>

int flock(int file, int how) { errno = ENOLCK; return -1; }

#define WITHOUT_LOCKS(name)                                                                     \
  int name(int file, int what, ...) {                                                           \
    va_list rest;                                                                               \
    va_start(rest, what);                                                                       \
    void *more = va_arg(rest, void *);                                                          \
    va_end(rest);                                                                               \
    if (what == F_SETLK || what == F_SETLKW || what == F_GETLK) { errno = ENOLCK; return -1; }  \
    return ((int (*)(int, int, ...))dlsym(RTLD_NEXT, #name))(file, what, more);                 \
  }
WITHOUT_LOCKS(fcntl)
WITHOUT_LOCKS(fcntl64)
"""
LOCK = """\
import sys, time
from hpcrub.results import ownership
ownership.Lock("result.h5")
print("mine", flush=True)
time.sleep(float(sys.argv[1]))
"""
READING = """\
import hpcrub
from hpcrub.__main__ import main

assert main(["tiny.yaml", "--status"]) == 0
assert main(["inspect", "results/tiny.h5"]) == 0
assert hpcrub.open("results/tiny.h5").to_dataframe("samples").size > 0
"""


@pytest.fixture
def lockless(folder, monkeypatch):
    """A folder in which programs that are started find no locks."""
    if not (compiler := shutil.which("cc")):
        pytest.skip("no C compiler (cc) to build the library that takes the locks away")
    (folder / "locks.c").write_text(LIBRARY)
    command = [compiler, "-shared", "-fPIC", "-o", "locks.so", "locks.c", "-ldl"]
    subprocess.run(command, check=True)
    monkeypatch.setenv("LD_PRELOAD", str(folder / "locks.so"))
    return folder


@pytest.mark.long
def test_a_study_runs_goes_on_and_is_read(tiny, lockless):
    run_on(2, tiny, folder=lockless)
    before = datasets(lockless / "results/tiny.h5")  # of this process, which has locks
    run_on(0, tiny, "--resume", folder=lockless)
    assert datasets(lockless / "results/tiny.h5") == before
    assert sorted(os.listdir(lockless / "results")) == ["tiny.h5", "tiny.runs.jsonl"]
    (lockless / "read.py").write_text(READING)
    code, out, err = run(0, folder=lockless, script=lockless / "read.py")
    assert (code, err) == (0, "")
    assert "4 of 4 samples" in out
    assert "sound" in out


def test_a_model_file_is_written_and_read(lockless):
    model_file.write("sector.h5", sector_arrays())
    command = "import", "model", "sector.h5", "--output", "copy.h5"
    code, _, err = run(0, *command, folder=lockless)
    assert (code, err) == (0, "")
    assert model_file.read("copy.h5").keys() >= model_file.read("sector.h5").keys()


def job(seconds):
    """A job that owns result.h5 for some seconds, if it can."""
    return subprocess.Popen(
        [sys.executable, "-c", LOCK, str(seconds)],
        env=os.environ | ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def test_a_second_job_is_kept_off_until_somebody_deletes_the_file_of_the_first(lockless):
    first = job(60)
    assert first.stdout.readline() == "mine\n"
    file = lockless / "result.h5.hpcrub-lock"
    assert f"if none runs, delete {file}" in job(0).communicate()[1]
    first.kill()
    first.wait()
    assert job(0).communicate()[0] == ""  # nobody knows that the first is dead
    file.unlink()
    assert job(0).communicate()[0] == "mine\n"


def test_of_jobs_that_begin_together_one_gets_the_file(lockless):
    jobs = [job(1) for _ in range(4)]
    assert sorted(one.communicate()[0] for one in jobs) == ["", "", "", "mine\n"]
