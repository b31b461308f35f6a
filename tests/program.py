"""The program as its user runs it, to its end or not, and what its result file holds."""

import json
import os
import subprocess

import h5py
import numpy as np
import pytest

from evidence.page import ROOT
from evidence.program import ENVIRONMENT, TINY, command
from hpcrub import studies
from hpcrub.commands import run as cli
from hpcrub.config import schema as config
from hpcrub.errors import InputError
from hpcrub.response import history
from hpcrub.response.sweep import run_sweep
from hpcrub.runs import result_files
from hpcrub.setup.disks import modes_of
from hpcrub.setup.problem import build_problem

# the same, whose motions are judged after a tenth of a second, for searches among many disks
BRIEF = TINY.replace(
    "first_check_s: 0.2, max_time_s: 0.5",
    "rule: last_window, first_check_s: 0.1, max_time_s: 0.1, window_revolutions: 1",
)
BLISK = """\
disk: {model: sector.h5}
reduction: {n_modes: 10}
casing: {n_bumps: 4, clearance_mm: 0.02, bump_height_mm: 0.06, growth_time_s: 0.002}
speeds: {from_hz: 575, to_hz: 585, step_hz: 5}
time: {step_s: 2e-6}
steady_state: {first_check_s: 0.012, max_time_s: 0.012}
"""  # two contact points on each blade, of the sector that the tests mesh

__all__ = ["ENVIRONMENT", "ROOT", "TINY"]  # the tests import them from here


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


def run_on(ranks, *arguments, folder):
    """Run the program to its end on ranks, without figures and errors; returns what it prints."""
    code, out, err = run(ranks, *arguments, "--no-figures", folder=folder)
    assert (code, error_lines(err)) == (0, []), out + err
    return out


def run_here(*arguments, folder="."):
    """Exit code of the program on one rank, in this process and without figures."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        return cli.main([*map(str, arguments), "--no-figures"])


def computed(folder, text, *options, output="one.h5"):
    """Result file of a study on one rank; its input is study.yaml beside it."""
    (folder / "study.yaml").write_text(text)
    assert run_here("study.yaml", "--output", output, *options, folder=folder) == 0
    return folder / output


def refusal(function, *arguments):
    """The one line with which arguments are refused."""
    with pytest.raises(InputError) as caught:
        function(*arguments)
    message = str(caught.value)
    assert message
    assert message.isprintable()
    return message


def swept(config, own=None, speeds=None):
    """Sweep of one disk of a configuration: the tuned one, or that with deviations (N,)."""
    problem = build_problem(config)
    own = np.zeros(config.disk.n_blades) if own is None else own
    speeds = config.speeds.values_hz if speeds is None else speeds
    return run_sweep(modes_of(config, problem, own), problem.scene, speeds)


def at_speed(result, i):
    """All numbers of one speed of a sweep."""
    return [values[i] for values in result.by_name().values()]


def whole(modes, scene, speeds, duration, *names, motion=None):
    """Arrays of a whole history, such as its times, (T, ..., S) each."""
    pieces = list(history.integrate(modes, scene, speeds, duration, motion))
    return [np.concatenate([getattr(piece, name) for piece in pieces]) for name in names]


def lay_out(path, study=TINY):
    """An empty result file of a study, its input or its Config."""
    cfg = config.Config.from_yaml(study) if isinstance(study, str) else study
    result_files.lay_out(path, studies.run_of(cfg))
    return path


def error_lines(text):
    return [line for line in text.splitlines() if line.startswith("hpcrub: ")]


def end_of_log(path):
    """What the log of a result file tells of the end of its last run."""
    return json.loads(path.with_suffix(".runs.jsonl").read_text("utf-8").splitlines()[-1])


def names_in(file):
    """Names of all datasets of an open HDF5 file."""
    found = []
    file.visititems(lambda name, item: found.append(name))
    return [name for name in found if isinstance(file[name], h5py.Dataset)]


def contents(path):
    """Values of every dataset of a result file but its texts."""
    with h5py.File(path, "r", locking=False) as file:
        return {name: file[name][()] for name in names_in(file) if file[name].dtype.kind != "O"}


def datasets(path):
    """Bytes of the same."""
    return {name: values.tobytes() for name, values in contents(path).items()}


def load(path, overrides=()):
    """Config of an input file, the first one of a sweep."""
    return config.load_runs(path, overrides)[0]
