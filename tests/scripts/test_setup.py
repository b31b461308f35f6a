"""What pip installs is the whole program."""

import os
import shutil
import subprocess
import sys

from tests.program import ROOT


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
