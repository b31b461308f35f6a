"""A little of ``make test-faults``, and that its checks can fail."""

import pytest

from evidence.faults import disks, files


def sound(trials):
    """Problems of trials, of which there must be some."""
    trials = list(trials)
    assert trials
    return [trial.problem for trial in trials if trial.problem]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made")
    return folder, files.make(folder, ("contact", "energy"))["contact"]


def test_damaged_files_are_read_or_refused(made):
    """Every reader meets every kind of damage."""
    folder, content = made
    trials = list(files.harmed_files(folder, {"contact": content}, 1))
    assert len(trials) == len(files.READERS) * len(files.DAMAGES)
    assert sound(trials) == []


@pytest.mark.parametrize("reader", files.READERS)
def test_every_reader_refuses_a_damaged_file(made, reader):
    folder, content = made
    (folder / "cut.h5").write_bytes(content[:-100])
    found = files.read(folder, reader, "cut.h5", "contact")
    assert (found.code, found.problem) == (2, "")
    assert "is truncated" in found.said


def test_a_disk_that_fails_is_one_line(tmp_path):
    """HDF5 used to try again at the end of the process, with tracebacks and a crash."""
    (trial, *_) = disks.write_error(tmp_path / "job")
    assert trial.problem == ""
    assert (tmp_path / "job" / "job" / "err").read_text().count("\n") == 1
