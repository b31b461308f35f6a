"""A little of ``make test-faults``, and what every reader says of a damaged file."""

import pytest

from evidence.faults import disks
from evidence.program import TINY
from hpcrub.__main__ import main as program
from tests.program import error_lines

PHYSICS = "".join(line for line in TINY.splitlines(True) if "mistuning" not in line)
READERS = {
    "inspect": ["inspect", "cut.h5"],
    "plot": ["plot", "cut.h5", "--out", "pictures"],
    "resume": ["study.yaml", "--resume", "--output", "cut.h5"],
    "sources": ["energy.yaml", "--output", "of_source.h5"],
    "merge": ["merge", "merged.h5", "cut.h5"],
    "merge with samples": ["merge", "more.h5", "cut.h5", "--samples", "3"],
}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with a result file without its end, and the inputs of READERS."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "study.yaml").write_text(TINY)
    energy = "study: energy\nsources: [cut.h5]\nenergy: {samples: 2}\nmistuning: {samples: 2}\n"
    (folder / "energy.yaml").write_text(energy + PHYSICS)
    assert program([str(folder / "study.yaml"), "--output", str(folder / "whole.h5")]) == 0
    (folder / "cut.h5").write_bytes((folder / "whole.h5").read_bytes()[:-100])
    return folder


@pytest.mark.parametrize("reader", READERS)
def test_every_reader_refuses_a_damaged_file(made, reader, monkeypatch, capfd):
    monkeypatch.chdir(made)
    assert program(READERS[reader]) == 2
    (line,) = error_lines(capfd.readouterr().err)
    assert "truncated file" in line


def test_a_disk_that_fails_is_one_line(tmp_path):
    """HDF5 used to try again at the end of the process, with tracebacks and a crash."""
    (trial, *_) = disks.write_error(tmp_path / "job")
    assert trial.problem == ""
    assert (tmp_path / "job" / "job" / "err").read_text().count("\n") == 1
