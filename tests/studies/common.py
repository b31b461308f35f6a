"""What the tests of several studies ask: brute force, ranks, refusals."""

import numpy as np
import pytest

from hpcrub.ranks import progress
from hpcrub.response.sweep import run_sweep
from hpcrub.setup.disks import deviation, modes_of
from hpcrub.setup.problem import build_problem
from tests.program import run_here


def lines_of_progress(folder, capsys, *options):
    """Lines with which a study on one rank tells of each of its tasks."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(progress, "INTERVAL", 0.0)
        patch.setattr(progress, "SHARE", 0.0)
        assert run_here("study.yaml", *options, folder=folder) == 0
    told = capsys.readouterr().out.splitlines()
    return [line for line in told if line.startswith("disks")]


def refused_study(folder, text, override, capsys):
    """What a study with a changed key is refused with, of which no file is made."""
    (folder / "study.yaml").write_text(text)
    options = "--output", "refused.h5", "--set", override
    assert run_here("study.yaml", *options, folder=folder) == 2
    assert not (folder / "refused.h5").exists()
    return capsys.readouterr().err


def largest_amplitudes(config, samples, level=0):
    """Largest amplitudes of samples [m], each swept by itself (n,)."""
    problem, found = build_problem(config), []
    for sample in samples:
        modes = modes_of(config, problem, deviation(config, level, sample))
        found.append(run_sweep(modes, problem.scene, config.speeds.values_hz).amplitude.max())
    return np.array(found)
