"""Names of result files: one job at a time, and nothing of somebody else is replaced."""

import os
import subprocess
import sys
from pathlib import Path

import h5py
import pytest

from hpcrub import studies
from hpcrub.__main__ import main as program
from hpcrub.errors import InputError
from hpcrub.results import ownership, storage
from tests.program import lay_out, refusal


@pytest.mark.parametrize(
    "make",
    [
        lambda path: path.write_text("export PATH"),
        lambda path: h5py.File(path, "w").close(),
        Path.mkdir,
        os.mkfifo,
        lambda path: path.symlink_to("/dev/null"),
    ],
    ids=["text", "HDF5", "folder", "fifo", "device"],
)
def test_what_is_not_ours_is_never_replaced(tmp_path, make):
    path = tmp_path / "precious"
    make(path)
    before = path.lstat()
    with pytest.raises(InputError, match="is not a result file of hpcrub"):
        lay_out(path)
    assert [found.name for found in tmp_path.iterdir()] == ["precious"]
    assert os.path.samestat(path.lstat(), before)


def test_a_file_that_another_program_has_open_is_told_as_that(path):
    """HDF5 says that a resource is temporarily unavailable."""
    lock = "import h5py, sys; f = h5py.File(sys.argv[1], 'r+'); print(1, flush=True); input()"
    ends = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", lock, str(path)], **ends) as other:
        other.stdout.readline()
        for use in (storage.ResultFile, storage.refuse_foreign):
            assert "another program has it open" in refusal(use, path)
        other.communicate(b"\n")


def test_a_link_to_nothing_is_followed(tmp_path):
    (tmp_path / "link.h5").symlink_to("nowhere/result.h5")
    lay_out(tmp_path / "link.h5")
    studies.open_result(tmp_path / "nowhere" / "result.h5").close()


def test_our_own_and_empty_files_are_replaced(path):
    link = path.with_name("link.h5")
    link.symlink_to(path)
    for content in (path.read_bytes(), b""):
        path.write_bytes(content)
        lay_out(link)
        studies.open_result(path).close()
    assert link.is_symlink()


@pytest.mark.parametrize("output", ["a.yaml", "a.png", "a.runs.jsonl", "", ".", "a.yaml/a.h5"])
def test_no_output_harms_the_input_or_passes_for_a_figure_or_log(tiny, folder, capfd, output):
    tiny.rename("a.yaml")
    before = os.listdir(), Path("a.yaml").read_bytes()
    assert program(["run", "a.yaml", "--overwrite", "--output", output]) == 2
    assert capfd.readouterr().err.count("\n") == 1
    assert before == (os.listdir(), Path("a.yaml").read_bytes())


@pytest.mark.parametrize("words", [
    ["run", "LONG.yaml"],
    ["run", "tiny.yaml", "--output", "LONG.h5"],
    ["run", "tiny.yaml", "--set", "disk.model=LONG.h5"],
    ["inspect", "LONG.h5"],
    ["plot", "LONG.h5"],
    ["report", "LONG.h5"],
    ["merge", "LONG.h5", "LONG.h5"],
    ["import", "model", "LONG.h5"],
    ["import", "calculix", "LONG.inp", "--contact", "TIPS"],
])  # fmt: skip
def test_a_name_that_is_too_long_is_one_line(tiny, folder, capfd, words):
    """Methods of `Path` raise OSError where functions of `os.path` say that there is no file."""
    assert program([word.replace("LONG", 300 * "x") for word in words]) == 2
    said = capfd.readouterr().err
    assert "File name too long" in said
    assert said.count("\n") == 1
    assert os.listdir() == ["tiny.yaml"]


def in_another_job(path):
    """What another process hears that wants to lock a file: nothing, or the error."""
    program = f"from hpcrub.results.ownership import Lock\nLock({str(path)!r}).release()"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    return done.stderr.strip().rpartition("\n")[2]


def test_one_file_under_two_names_is_locked_once(tmp_path):
    (tmp_path / "link.h5").symlink_to("result.h5")
    lock, other = ownership.Lock(tmp_path / "result.h5"), tmp_path / "link.h5"
    assert in_another_job(other).endswith(f"InputError: {other} is in use by another job")
    lock.release()
    assert in_another_job(other) == ""
    assert not lock.path.exists()


def test_a_lock_releases_only_itself(tmp_path):
    """The folder was removed and made again, and another job has begun in it."""
    lock = ownership.Lock(tmp_path / "result.h5")
    lock.path.unlink()
    lock.path.write_text("of another job")
    lock.release()
    assert lock.path.exists()
