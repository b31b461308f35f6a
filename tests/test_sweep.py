"""Sweeps over angular speeds: the cut of the revolution, lanes and their refilling, known peaks."""

import numpy as np
import pytest
from reference import reference_reduced

from hpcrub.errors import Interrupted
from hpcrub.reduction import Modes, mistuned_modes
from hpcrub.steady import SteadyCriteria
from hpcrub.sweep import (
    DIVERGED,
    NONE,
    NOT_STEADY,
    STEADY,
    Scene,
    cut_revolution,
    run_sweep,
    speed_bands,
)

SHORT = SteadyCriteria(first_check=0.2, max_time=0.6)


def scene_of(**changes):
    reduced = reference_reduced()
    defaults = {
        "contact_angle": reduced.contact_angle,
        "contact_radius": reduced.contact_radius,
        "damping_ratio": 0.005,
        "n_bumps": 4,
        "bump_height": 1.25e-3,
        "clearance": 0.25e-3,
        "growth_time": 0.01,
        "friction": 0.15,
        "step": 2e-5,
        "scheme": "exact_modal",
        "steady": SHORT,
    }
    return Scene(**{**defaults, **changes})


@pytest.fixture(scope="module")
def modes():
    return mistuned_modes(reference_reduced(), np.linspace(-0.03, 0.03, 12))


@pytest.mark.parametrize("n_bumps", [1, 4, 6, 97])
@pytest.mark.parametrize("step", [1e-3, 3e-5, 1e-6, 1e-7])
@pytest.mark.parametrize("speed", [0.5, 33.5, 900.0])
def test_revolution_is_cut_into_whole_steps_blocks_and_records(n_bumps, step, speed):
    grid = cut_revolution(speed, scene_of(n_bumps=n_bumps, step=step))
    assert 1.0 / (speed * grid.steps_per_revolution) <= step * (1.0 + 1e-9)
    assert grid.steps_per_block * grid.blocks_per_revolution == grid.steps_per_revolution
    assert grid.steps_per_block % grid.stride == 0
    assert n_bumps % grid.blocks_per_revolution == 0  # a block turns by whole pitches


def test_bands_hold_every_speed_once_and_similar_ones():
    speeds = np.array([40.0, 10.0, 10.5, 39.0, 80.0, 10.9])
    bands = speed_bands(speeds)
    assert sorted(np.concatenate(bands)) == list(range(6))
    assert [list(speeds[b]) for b in bands] == [[10.0, 10.5], [10.9], [39.0, 40.0], [80.0]]


def same(a, b):
    return all(np.array_equal(x, y, equal_nan=True) for x, y in zip(a[:4], b[:4], strict=True))


def test_result_does_not_depend_on_lanes_or_parts(modes):
    speeds = np.linspace(33.5, 35.5, 11)
    scene = scene_of()
    whole = run_sweep(modes, scene, speeds)
    assert set(whole.point_status) <= {STEADY, NOT_STEADY}
    assert np.ptp(whole.time) > 0.1
    for width in (1, 8):
        narrow = run_sweep(modes, scene, speeds, width=width)
        assert same(narrow, whole)
        assert narrow.n_steps == whole.n_steps
    parts = [run_sweep(modes, scene, speeds, selection=range(k, 11, 3)) for k in range(3)]
    for k, part in enumerate(parts):
        assert same([x[k::3] for x in part[:4]], [x[k::3] for x in whole[:4]])
        assert np.all(np.delete(part.point_status, np.arange(k, 11, 3)) == NONE)
    assert sum(part.n_steps for part in parts) == whole.n_steps


def test_nothing_moves_where_nothing_can_touch(modes):
    result = run_sweep(modes, scene_of(bump_height=0.2e-3), np.array([34.0, 35.0]))
    assert np.all(result.amplitude == 0.0)
    assert np.all(result.point_status == STEADY)
    assert np.all(result.localisation == 0.0)


def test_times_follow_the_criteria(modes):
    result = run_sweep(modes, scene_of(), np.array([33.5, 35.5]))
    block = 1.0 / (4 * np.array([33.5, 35.5]))
    assert np.all(result.time >= SHORT.first_check)
    assert np.all(result.time <= 0.6 + block)


def test_unstable_step_is_diverged_and_has_no_amplitude(modes):
    scene = scene_of(scheme="central_difference", step=3.7e-5)
    result = run_sweep(modes, scene, np.array([34.0]))
    assert result.point_status[0] == DIVERGED
    assert np.isnan(result.amplitude[0])
    assert np.isnan(result.localisation[0])


def test_poll_can_stop_a_sweep(modes):
    calls = []

    def poll():
        calls.append(1)
        if len(calls) == 3:
            raise Interrupted("enough")

    with pytest.raises(Interrupted):
        run_sweep(modes, scene_of(), np.array([34.0]), poll=poll)
    assert len(calls) == 3


def test_published_tuned_amplitudes():
    """Reference disk, n_d = 4: 10.8 mm at 33.25 Hz, 14.4 mm at 33.5 Hz, both periodic."""
    modes = mistuned_modes(reference_reduced(), np.zeros(12))
    scene = scene_of(step=1e-6, steady=SteadyCriteria(), scheme="central_difference")
    result = run_sweep(modes, scene, np.array([33.25, 33.5]))
    assert np.all(result.point_status == STEADY)
    assert result.amplitude * 1e3 == pytest.approx([10.8, 14.4], abs=0.06)
    assert np.all(result.localisation < 1e-3)  # all blades of the tuned disk move alike


def test_single_mode_disk_of_one_blade():
    """A mass on a soft spring pushed away by one bump per turn: it must touch and stay bounded."""
    ones = np.ones((1, 1))
    modes = Modes(np.array([2 * np.pi * 20.0]), ones, ones, ones)
    scene = Scene(np.zeros(1), 1.0, 0.05, 1, 2e-3, 1e-3, 0.01, 0.0, step=1e-4, steady=SHORT)
    result = run_sweep(modes, scene, np.array([15.0]))
    assert result.point_status[0] == STEADY
    assert 1e-4 < result.amplitude[0] < 0.1
