"""Branches: motions from several initial states, and how one speed hands its motion to the next.

Truth: the sweep from rest, whole histories that go on, and a sweep that is made up. How motions are
told apart is in test_coexistence.py.
"""

from pathlib import Path

import numpy as np
import pytest

from hpcrub.commands import run as cli
from hpcrub.contact.status import DIVERGED, STEADY
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import Modes, mistuned_modes
from hpcrub.response import history
from hpcrub.response.steady import localisation
from hpcrub.response.sweep import Motion, SweepResult, run_sweep
from hpcrub.setup.problem import build_problem
from hpcrub.studies import branches, open_result
from tests.program import TINY


def test_branches(folder, monkeypatch):
    monkeypatch.setattr(branches, "N_WINDOWS", 12)  # 60 take longer
    text = f"study: branches\nbranches: {{perturbed: 1}}\noutput: branches.h5\n{TINY}"
    Path("branches.yaml").write_text(text)
    assert cli.main(["branches.yaml"]) == 0
    file = open_result("branches.h5")
    amplitude = file.read("amplitude_m")
    assert amplitude.shape == (4, 3)
    assert np.isfinite(amplitude).all()
    problem = build_problem(file.config)
    modes = mistuned_modes(problem.reduced, np.zeros(12))
    rest = run_sweep(modes, problem.scene, file.config.speeds.values_hz)
    np.testing.assert_array_equal(amplitude[0], rest.amplitude)
    assert amplitude[1, 0] == rest.amplitude[0]  # both chains begin at rest
    assert amplitude[2, -1] == rest.amplitude[-1]
    windows, local = file.read("window_amplitude_m"), file.read("window_localisation")
    mean = windows.mean(axis=-1)
    assert windows.shape == local.shape == (4, 3, 12)
    assert np.abs(mean - amplitude).max() < 0.2 * amplitude.max()
    assert (windows.std(axis=-1) < 0.2 * mean).all()
    found = branches.label_file(file)
    np.testing.assert_array_equal(found >= 0, file.read("point_status") == STEADY)
    motion = Motion.at_rest(3, len(modes.omega))
    speeds = file.config.speeds.values_hz
    run_sweep(modes, problem.scene, speeds, motion=motion)
    largest = np.zeros((12, 3, 12))  # windows of three revolutions, speeds, tips
    for window in largest:
        for piece in history.integrate(modes, problem.scene, speeds, 3 / speeds.max(), motion):
            tips = np.abs(np.einsum("ck,rks->rsc", modes.tangential, piece.position))
            np.maximum(window, tips.max(axis=0), out=window)
    np.testing.assert_allclose(motion.time, rest.time + 12 * 3 / speeds)
    np.testing.assert_allclose(windows[0].T, largest.max(axis=2), rtol=1e-9)
    np.testing.assert_allclose(local[0].T, localisation(largest), rtol=1e-9)
    start = branches.deflection(modes, 12, 1, 3, 0.02)
    assert np.abs(modes.tangential @ start).max() == pytest.approx(0.02)
    assert Path("branches.png").exists()


def test_initial_states_share_no_random_number():
    """Neither with one another, of whatever seed and number, nor with the deviations of blades."""
    tips = np.eye(12)
    modes = Modes.planar(np.ones(12), tips, tips)
    places = [(seed, task) for seed in range(6) for task in range(6)]
    drawn = [branches.deflection(modes, 12, *place, 0.02) for place in places]
    assert np.abs(drawn).max(axis=1) == pytest.approx(0.02)
    drawn += [stiffness_deviation(seed, 0, sample, 12, 1.0) for seed, sample in places]
    drawn += [stiffness_deviation(seed, 1 + level, 0, 12, 1.0) for seed, level in places]
    shapes = np.divide(drawn, np.array(drawn)[:, :1])[:, 1:]  # whatever their sizes
    assert len(np.unique(shapes)) == shapes.size


@pytest.mark.parametrize("downwards", [False, True])
def test_every_speed_follows_the_one_before(monkeypatch, downwards):
    """From where that has ended; beside a diverged one, from the motion that was given."""
    begun = {}

    def fake(modes, scene, speeds_hz, poll, selection, motion, width):
        (i,) = selection
        begun[i] = [float(np.ravel(values[i])[0]) for values in motion]
        for number, values in enumerate(motion):
            values[i] = 10 * (i + 1) + number
        result = SweepResult.empty(len(speeds_hz))
        result.point_status[i] = DIVERGED if i == 2 else STEADY
        result.amplitude[i] = speeds_hz[i]
        return result

    monkeypatch.setattr(branches, "run_sweep", fake)
    first = [-1.0, -2.0, -3.0, -4.0]
    given = Motion(*(np.full((5, 3), value) for value in first))
    speeds = np.linspace(30.0, 34.0, 5)
    result = branches.follow(None, None, speeds, given, downwards)
    order, step = ([4, 3, 2, 1, 0], 1) if downwards else ([0, 1, 2, 3, 4], -1)
    assert list(begun) == order
    for i in order:
        expected = [10 * (i + step + 1) + n for n in range(4)]
        if i == order[0] or i + step == 2:
            expected = first
        assert begun[i] == expected
    np.testing.assert_array_equal(result.amplitude, speeds)
    np.testing.assert_array_equal(result.point_status == DIVERGED, np.arange(5) == 2)
