"""The program as its user runs it, on any number of ranks of this machine, and a tiny study."""

import os
import subprocess
import sys

from evidence.page import ROOT

# two samples on two levels, three speeds, a fraction of a second
TINY = """\
speeds: {from_hz: 34.0, to_hz: 34.4, step_hz: 0.2}
reduction: {n_modes: 12}
time: {step_s: 2e-5}
steady_state: {first_check_s: 0.2, max_time_s: 0.5}
mistuning: {half_range_percent: [2, 4], samples: 2, checked_samples: 0}
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


def run(ranks, script, *arguments, folder=ROOT, **options):
    """Run a script to its end in a folder; options of `subprocess.run`. Raises CalledProcessError.

    Returns its standard output, if ``capture_output``.
    """
    usual = {"check": True, "text": True, "cwd": folder, "env": os.environ | ENVIRONMENT}
    return subprocess.run(command(ranks, script, *arguments), **(usual | options)).stdout
