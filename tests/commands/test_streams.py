"""Standard streams that are closed, full, or without our characters end no study."""

import os
import subprocess
import sys

import pytest

from hpcrub.studies.files import open_result
from tests.program import ROOT, TINY


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
