"""Ctrl-C and SIGTERM: every command ends with one line and its exit code, wherever it is."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from hpcrub.__main__ import main as program
from hpcrub.commands import run as cli
from hpcrub.ranks.parallel import STOP_SIGNALS
from hpcrub.results.storage import ResultFile
from hpcrub.runs import execution
from tests.program import ROOT, TINY, start


def stops(number):
    """Function in whose place the program gets a signal."""
    return lambda *_, **__: os.kill(os.getpid(), number)


@pytest.mark.parametrize("command", ["inspect", "plot", "merge whole.h5"])
def test_ctrl_c_in_a_command_is_one_line(path, capsys, monkeypatch, command):
    """Two files: it must not go on with the second one as after an error of the first."""
    monkeypatch.setattr(ResultFile, "__init__", stops(signal.SIGINT))
    monkeypatch.chdir(path.parent)
    assert program([*command.split(), str(path), str(path)]) == 75
    assert capsys.readouterr().err == "hpcrub: stopped: SIGINT came\n"
    assert [found.name for found in path.parent.iterdir()] == [path.name]


def test_a_stop_signal_in_the_first_second_is_one_line(tmp_path):
    (tmp_path / "a.yaml").write_text(TINY)
    begun = start(0, ROOT / "main.py", "a.yaml", folder=tmp_path)
    listens = Path(f"/proc/{begun.pid}/status")
    bit = 1 << (signal.SIGTERM - 1)
    while not int(listens.read_text().split("SigCgt:")[1].split()[0], 16) & bit:
        time.sleep(0.001)
    begun.send_signal(signal.SIGTERM)
    _, err = begun.communicate(timeout=60)
    said = "hpcrub: stopped: SIGTERM came before anything was begun\n"
    assert (begun.returncode, err) == (75, said)
    assert not (tmp_path / "results").exists()


def test_a_stop_signal_before_the_file_is_opened_makes_none(folder, monkeypatch, capfd):
    (folder / "a.yaml").write_text("study: modal\noutput: a.h5\n")
    monkeypatch.setattr(execution.memory, "check", stops(signal.SIGTERM))
    assert cli.main(["a.yaml"]) == 75
    expected = f"hpcrub: stopped: SIGTERM came before {folder / 'a.h5'} was opened\n"
    assert capfd.readouterr().err == expected
    assert not (folder / "a.h5").exists()


def test_a_signal_that_comes_after_the_end_changes_nothing():
    """Rank 0 has passed on what another rank has yet to get; its exit code was 138 then."""
    program = (
        "import os, signal, sys; from hpcrub.ranks import parallel; parallel.listen(); "
        "code = parallel.run(lambda team: 75); os.kill(os.getpid(), signal.SIGUSR1); sys.exit(code)"
    )
    assert subprocess.run([sys.executable, "-c", program], cwd=ROOT).returncode == 75


@pytest.mark.parametrize("words", [["--status"], ["--dry-run"]])
def test_a_call_from_python_gives_the_signals_back(tiny, words):
    """They stayed ignored, in the caller and in all that it started."""
    before = [signal.getsignal(number) for number in STOP_SIGNALS]
    assert program([str(tiny), *words]) in (0, 75)
    assert [signal.getsignal(number) for number in STOP_SIGNALS] == before
