"""A little of ``make test-faults``, and that its checks can fail."""

import pytest

from evidence.faults import disks, files, inputs
from hpcrub.commands import run as cli
from hpcrub.config import schema as config
from hpcrub.errors import InputError


def sound(trials):
    """Problems of trials, of which there must be some."""
    trials = list(trials)
    assert trials
    return [trial.problem for trial in trials if trial.problem]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made")
    return folder, files.make(folder, ("contact", "cross"))["contact"]


def test_damaged_files_are_read_or_refused(made):
    """Every reader meets every kind of damage."""
    folder, content = made
    trials = list(files.harmed_files(folder, {"contact": content}, 1))
    assert len(trials) == len(files.READERS) * len(files.DAMAGES)
    assert sound(trials) == []


def test_files_that_lie_are_refused(made):
    assert sound(files.lies(*made, readers=("inspect",))) == []


def test_files_that_are_no_hdf5_are_refused(made):
    assert sound(files.forged(*made, readers=("inspect",))) == []


@pytest.mark.parametrize("reader", files.READERS)
def test_every_reader_refuses_a_damaged_file(made, reader):
    folder, content = made
    (folder / "cut.h5").write_bytes(content[:-100])
    found = files.read(folder, reader, "cut.h5", "contact")
    assert (found.code, found.problem) == (2, "")
    assert "is truncated" in found.said


@pytest.mark.parametrize("name", inputs.OUTPUTS)
def test_no_output_harms_what_is_there(tmp_path, monkeypatch, capfd, name):
    inputs.precious(tmp_path / "a")
    monkeypatch.chdir(tmp_path / "a")
    before = inputs.contents(tmp_path / "a")
    arguments = ["study.yaml", "--overwrite", "--no-figures", "--output", inputs.OUTPUTS[name]]
    allowed = name in inputs.ALLOWED
    assert cli.main(arguments) == (0 if allowed else 2)
    if not allowed:
        assert inputs.contents(tmp_path / "a") == before
        assert capfd.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("name", inputs.TEXTS)
def test_no_text_grows_or_runs(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.yaml").write_text(inputs.TEXTS[name], encoding="utf-8")
    with pytest.raises(InputError) as caught:
        config.load_runs("study.yaml")
    assert len(str(caught.value)) < 500
    assert not (tmp_path / "harmed").exists()


def test_a_disk_that_fails_is_one_line(tmp_path):
    """HDF5 used to try again at the end of the process, with tracebacks and a crash."""
    (trial, *_) = disks.write_error(tmp_path / "job")
    assert trial.problem == ""
    assert (tmp_path / "job" / "job" / "err").read_text().count("\n") == 1
