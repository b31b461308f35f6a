"""The set-up script names exactly what is missing, and never installs it when told not to."""

import os
import shutil
import subprocess
import sys

import pytest

from tests.program import ROOT

SCRIPT = ROOT / "tools" / "setup.sh"
TOOLS = ["bash", "cut", "dirname", "env", "gcc", "id", "mpicc", "mpirun", "paste", "sed"]


def set_up(tmp_path, hidden, **variables):
    """Run a copy of the script with only TOOLS in PATH, less those hidden, and a fake apt-get."""
    (tmp_path / "tools").mkdir()
    shutil.copy(SCRIPT, tmp_path / "tools")
    programs = tmp_path / "bin"
    programs.mkdir()
    for tool in TOOLS:
        found = shutil.which(tool)
        if found is None:
            pytest.skip(f"{tool} is not here")
        if tool not in hidden:
            (programs / tool).symlink_to(found)
    (programs / "apt-get").write_text('#!/bin/bash\necho "$@" >>"$APT_LOG"\n')
    (programs / "apt-get").chmod(0o755)
    environment = {
        "PATH": str(programs),
        "HOME": str(tmp_path),
        "APT_LOG": str(tmp_path / "apt"),
        "PYTHON": "no-such-python",
        "HDF5_DIR": "/somewhere",
    }
    command = [str(programs / "bash"), str(tmp_path / "tools" / "setup.sh")]
    return subprocess.run(
        command, env=environment | variables, capture_output=True, text=True, check=False
    )


def test_missing_packages_are_named_and_not_installed(tmp_path):
    done = set_up(tmp_path, hidden=["mpicc"], APT="no")
    assert done.returncode == 1
    assert "libopenmpi-dev (command mpicc)" in done.stderr
    assert "apt-get install libopenmpi-dev python3-venv python3-dev)" in done.stderr
    assert "openmpi-bin" not in done.stderr
    assert not (tmp_path / "apt").exists()
    assert not (tmp_path / ".venv").exists()


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may install")
def test_only_what_is_missing_is_installed(tmp_path):
    done = set_up(tmp_path, hidden=["mpirun"])
    asked = (tmp_path / "apt").read_text().split("\n")
    assert asked[1].split()[-3:] == ["openmpi-bin", "python3-venv", "python3-dev"]
    assert "still missing after apt-get: openmpi-bin (command mpirun)" in done.stderr


def test_what_pip_installs_runs_without_the_checkout(tmp_path):
    """All packages are in the wheel, and so is the command."""
    for name in ("hpcrub", "pyproject.toml", "README.md"):  # setuptools writes beside its sources
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, tmp_path / name)
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation"]
    pip += ["--disable-pip-version-check", "--no-index", "--target", "there", "."]
    alone = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    subprocess.run(pip, cwd=tmp_path, env=alone, check=True, capture_output=True)
    there, elsewhere = tmp_path / "there", tmp_path / "elsewhere"
    elsewhere.mkdir()
    alone |= {"PYTHONPATH": str(there)}
    for command in ([sys.executable, "-m", "hpcrub"], [str(there / "bin" / "hpcrub")]):
        done = subprocess.run(
            [*command, "--version"], cwd=elsewhere, env=alone, capture_output=True, text=True
        )
        assert done.stdout.startswith("hpcrub "), done.stderr
    everything = (
        "import hpcrub.commands.plot, hpcrub.commands.merge, hpcrub.studies.branches as last"
    )
    show = f"{everything}; print(last.__file__)"
    command = [sys.executable, "-c", show]
    done = subprocess.run(command, cwd=elsewhere, env=alone, capture_output=True, text=True)
    assert done.stdout.startswith(str(there)), done.stderr
