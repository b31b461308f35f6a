"""The program as its user runs it, on any number of ranks, and a tiny study for it."""

import os
import subprocess
import sys
from pathlib import Path

import h5py

from hpcrub.config import schema as config
from hpcrub.results.layout import LAYOUT

ROOT = Path(__file__).resolve().parent.parent
# two samples on two levels, three speeds, a fraction of a second
TINY = """\
speeds: {from_hz: 34.0, to_hz: 34.4, step_hz: 0.2}
reduction: {n_modes: 12}
time: {step_s: 2e-5}
steady_state: {first_check_s: 0.2, max_time_s: 0.5}
mistuning: {half_range_percent: [2, 4], samples: 2}
convergence: {step: 1}
"""
ENVIRONMENT = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "NUMBA_NUM_THREADS": "1",
    "PYTHONPATH": str(ROOT),
}


def command(ranks, script, *arguments):
    """Command line that runs a Python script, under mpirun unless ranks is 0."""
    launcher = ["mpirun", "-n", str(ranks)] if ranks else []
    return [*launcher, sys.executable, str(script), *map(str, arguments)]


def start(ranks, script, *arguments, folder):
    """A running program whose output is collected."""
    return subprocess.Popen(
        command(ranks, script, *arguments),
        cwd=folder,
        env=os.environ | ENVIRONMENT,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def run(ranks, *arguments, folder, script=ROOT / "main.py", timeout=600):
    """Run to the end, compiling included; returns (exit code, stdout, stderr)."""
    process = start(ranks, script, *arguments, folder=folder)
    try:
        out, err = process.communicate(timeout=timeout)
    finally:
        process.kill()
    return process.returncode, out, err


def error_lines(text):
    return [line for line in text.splitlines() if line.startswith("hpcrub: ")]


def datasets(path):
    """Bytes of every dataset of a result file."""
    with h5py.File(path, "r", locking=False) as file:
        return {line.name: file[line.name][()].tobytes() for line in LAYOUT}


def load(path, overrides=()):
    """Config of an input file, the first one of a sweep."""
    return config.load_runs(path, overrides)[0]
