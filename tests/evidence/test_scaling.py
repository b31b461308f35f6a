"""The programs that the scaling measurement hands to mpirun as text, which no linter reads."""

import subprocess
import sys

import pytest

from evidence.scaling import program


@pytest.mark.parametrize("name", ["MESSAGES", "SLEEPING", "WRITING"])
def test_scripts_know_every_name_they_use(name):
    command = [sys.executable, "-m", "ruff", "check", "--isolated", "--select", "F821", "-"]
    script = getattr(program, name)
    done = subprocess.run(command, input=script, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
