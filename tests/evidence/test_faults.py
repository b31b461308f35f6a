"""A little of ``make test-faults``, and that its checks can fail."""

import importlib.util
import os
import shutil
import signal
import subprocess
import sys
from types import SimpleNamespace

import numba
import pytest

from evidence.faults import disks, files, inputs, job
from hpcrub.commands import execution
from hpcrub.commands import run as cli
from hpcrub.config import schema as config
from hpcrub.config.schema import Config
from hpcrub.contact import jit
from hpcrub.errors import HpcrubError, InputError
from hpcrub.ranks.parallel import Team
from hpcrub.studies import warmup
from hpcrub.studies.files import open_result
from tests.program import ROOT, TINY


def sound(trials):
    """Problems of trials, of which there must be some."""
    trials = list(trials)
    assert trials
    return [trial.problem for trial in trials if trial.problem]


def test_a_stop_signal_in_the_first_second_is_one_line(tmp_path):
    begun = job.Job(tmp_path, "study.yaml")
    assert begun.until(lambda: job.listens(begun.process.pid, signal.SIGTERM))
    begun.process.send_signal(signal.SIGTERM)
    assert begun.wait() == 75
    assert begun.message() == "hpcrub: stopped: SIGTERM came before anything was begun"
    assert not begun.result.exists()


def test_a_stop_signal_before_the_file_is_opened_makes_none(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.yaml").write_text("study: casing\noutput: a.h5\n")
    stop = lambda *_: os.kill(os.getpid(), signal.SIGTERM)  # noqa: E731
    monkeypatch.setattr(execution.size, "check", stop)
    assert cli.main(["a.yaml"]) == 75
    expected = f"hpcrub: stopped: SIGTERM came before {tmp_path / 'a.h5'} was opened\n"
    assert capfd.readouterr().err == expected
    assert not (tmp_path / "a.h5").exists()


def test_a_file_that_was_taken_away_is_told(tmp_path):
    path = tmp_path / "a.h5"
    with pytest.raises(HpcrubError, match=r"a\.h5 was removed or moved while this job ran"):
        execution.require_there(path)
    path.touch()
    execution.require_there(path)


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


def test_a_source_is_never_overwritten(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cfg = config.Config.from_yaml("study: cross\nsources: [a.h5]\noutput: x/../a.h5")
    with pytest.raises(InputError, match="is one of the sources"):
        execution.check_output(cfg, execution.Existing(overwrite=True))


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
    assert (tmp_path / "job" / "0" / "err").read_text().count("\n") == 1


@pytest.mark.parametrize("closed", ["1", "2", "0"])
def test_a_closed_stream_ends_no_study(tmp_path, closed):
    """And nothing is printed into the result file, which would else get the stream's number."""
    (tmp_path / "a.yaml").write_text("study: casing\noutput: a.h5\n")
    command = f"exec {sys.executable} {ROOT / 'main.py'} a.yaml --no-figures {closed}>&-"
    done = subprocess.run(command, shell=True, cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    open_result(tmp_path / "a.h5").close()


@pytest.mark.parametrize("encoding", ["ascii", "iso8859-2"])
def test_an_output_without_our_characters_ends_no_study(tmp_path, encoding):
    (tmp_path / "a.yaml").write_text(TINY.replace("samples: 2", "samples: 1") + "output: a.h5\n")
    arguments = [sys.executable, ROOT / "main.py", "a.yaml", "--no-figures"]
    environment = os.environ | {"PYTHONIOENCODING": encoding, "PYTHONUTF8": "0"}
    done = subprocess.run(arguments, cwd=tmp_path, capture_output=True, env=environment)
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"+-2 %" in done.stdout


def test_a_full_disk_behind_the_log_ends_no_study(tmp_path):
    (tmp_path / "a.yaml").write_text("study: casing\noutput: a.h5\n")
    with open("/dev/full", "w") as full:
        arguments = [sys.executable, ROOT / "main.py", "a.yaml", "--no-figures"]
        done = subprocess.run(arguments, cwd=tmp_path, stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 0
    assert done.stderr.decode().count("on without it") == 1
    assert (tmp_path / "a.h5").exists()


@pytest.fixture
def small(tmp_path, monkeypatch):
    """Function: load and call a compiled function anew; whether it came from the cache."""
    source = tmp_path / "small.py"
    source.write_text(
        "from hpcrub.contact.jit import compiled\n@compiled\ndef f(x):\n    return x + 1.5\n"
    )
    monkeypatch.setattr(jit, "cache", SimpleNamespace(lost=""))

    def comes_from_cache():
        # every time: numba reads its settings anew when the environment has changed
        monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "cache"))
        spec = importlib.util.spec_from_file_location("small", source)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        assert module.f(1.0) == 2.5
        return sum(module.f.stats.cache_hits.values()) == 1

    return comes_from_cache


def test_a_damaged_cache_is_compiled_anew(tmp_path, small):
    """With any of its two files cut the code does not come from the cache, but the numbers are
    right, and the time after that it does again."""
    assert [small(), small()] == [False, True]
    for pattern in ("*.nbc", "*.nbi"):
        (entry,) = (tmp_path / "cache").rglob(pattern)
        content = entry.read_bytes()
        for harmed in (content[: len(content) // 2], b""):
            entry.write_bytes(harmed)
            assert [small(), small()] == [False, True], pattern


def test_a_full_disk_of_compiled_code_is_told(tmp_path, small, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("numba.core.caching.IndexDataCacheFile.save", full)
    assert not small()
    assert jit.cache.lost.endswith("No space left on device")


def cache_of(tmp_path, monkeypatch):
    """(folder of compiled code, why there is none) with this place for it."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(jit, "cache", SimpleNamespace(lost=""))
    return jit._cache_folder(), jit.cache.lost


def test_compiled_code_of_others_is_refused(tmp_path, monkeypatch):
    """numba executes what it finds: a folder into which others can write is no cache."""
    found, _ = cache_of(tmp_path, monkeypatch)
    assert os.stat(found).st_mode & 0o777 == 0o700
    os.chmod(found, 0o777)
    assert cache_of(tmp_path, monkeypatch) == ("", f"{found}: others may write there")
    os.chmod(found, 0o700)
    monkeypatch.setattr(os, "geteuid", lambda: 4711)
    assert cache_of(tmp_path, monkeypatch)[0] == ""


def test_a_copy_of_the_program_has_its_own_compiled_code(tmp_path, monkeypatch):
    """numba looks for code by the path and the time of its source: a mark that says that all is
    compiled must not be found by another clone, whose ranks would then all compile at once."""
    mine, _ = cache_of(tmp_path, monkeypatch)
    shutil.copytree(ROOT / "hpcrub", tmp_path / "clone" / "hpcrub")
    monkeypatch.setattr(jit, "__file__", str(tmp_path / "clone" / "hpcrub" / "contact" / "jit.py"))
    other, _ = cache_of(tmp_path, monkeypatch)
    assert other != mine
    os.utime(tmp_path / "clone" / "hpcrub" / "contact" / "kernel.py", (1, 1))
    assert cache_of(tmp_path, monkeypatch)[0] not in (mine, other)


def test_a_folder_of_compiled_code_that_cannot_be_written_is_told_once(
    tmp_path, monkeypatch, capfd
):
    """For all ranks by rank 0, whichever of them it is that cannot."""
    monkeypatch.setattr(jit, "cache", SimpleNamespace(lost=""))
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    monkeypatch.setattr(warmup, "_load", lambda config: None)
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert jit._cache_folder() == ""
    assert "Not a directory" in jit.cache.lost
    team = Team()
    warmup.warm_up(team, Config())
    err = capfd.readouterr().err
    assert err.count("\n") == err.count("compiled code cannot be kept on 1 of 1 ranks") == 1
    assert "XDG_CACHE_HOME=" in err
    team.size, team.gather = 3, lambda own: ["", jit.cache.lost, ""]
    team.bcast = lambda value: value
    warmup.warm_up(team, Config())
    assert "cannot be kept on 1 of 3 ranks" in capfd.readouterr().err
    team.rank = 2
    team.gather = team.on_root = lambda *_: None
    warmup.warm_up(team, Config())
    assert capfd.readouterr().err == ""
