"""What pip installs is the whole program, and conda installs what it needs."""

import os
import shutil
import subprocess
import sys
import tomllib

import yaml

from tests.program import ROOT


def test_what_pip_installs_runs_without_the_checkout(tmp_path):
    """All packages are in the wheel, and so is the command."""
    for name in ("hpcrub", "pyproject.toml", "README.md"):  # setuptools writes beside its sources
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, tmp_path / name)
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation"]
    pip += ["--disable-pip-version-check", "--no-compile", "--no-index", "--target", "there", "."]
    alone = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    subprocess.run(pip, cwd=tmp_path, env=alone, check=True, capture_output=True)
    there, elsewhere = tmp_path / "there", tmp_path / "elsewhere"
    elsewhere.mkdir()
    alone |= {"PYTHONPATH": str(there)}
    show = "import hpcrub.commands.plot as last, hpcrub.commands.merge; print(last.__file__)"
    for command, begin in (
        ([str(there / "bin" / "hpcrub"), "--version"], "hpcrub "),
        ([sys.executable, "-c", show], str(there)),
    ):
        done = subprocess.run(command, cwd=elsewhere, env=alone, capture_output=True, text=True)
        assert done.stdout.startswith(begin), done.stderr


def test_conda_installs_what_the_package_needs():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    needed = project["dependencies"] + project["optional-dependencies"]["mpi"]
    environment = yaml.safe_load((ROOT / "environment.yml").read_text("utf-8"))["dependencies"]
    by_conda = {str(x).replace(" >", ">").replace("-base", "").split()[0] for x in environment}
    assert {line.lower() for line in needed} <= by_conda
    assert environment[-1] == {"pip": ["--editable .[dev]"]}  # the rest, and hpcrub itself
