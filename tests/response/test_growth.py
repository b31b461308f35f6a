"""Waves that grow: seen before they show, on made-up waves and on a disk that leaves its motion."""

import numpy as np
import pytest

from hpcrub.config.schema import Config
from hpcrub.contact.status import GROWING, NOT_STEADY
from hpcrub.model.casing_modes import NO_PAIRS
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response import growth
from hpcrub.response.growth import Growth, Waves
from hpcrub.response.sweep import run_sweep
from hpcrub.setup.disks import run_deviation
from hpcrub.setup.problem import build_problem

N, WINDOW, DECAY = 12, 0.1, 8.0
PHASE = np.linspace(0.0, 6.0 * np.pi, 40, endpoint=False)
BLADES = 2.0 * np.pi * np.arange(N) / N
# six bumps, where the motion of equal blades is left for another one, 16 % larger, after 2.4 s
UNSTABLE = "casing: {n_bumps: 6}\nmaterial: {damping_ratio: 0.03}\n"
UNSTABLE += "speeds: {from_hz: 22.6, to_hz: 22.8, step_hz: 0.1}\n"


def tips(size, diameters):
    """A wave that travels around the disk, at the records of a window (1, R, N)."""
    return size * np.cos(PHASE[:, None] - diameters * BLADES)[None]


def watched(histories, n_windows):
    """Growth that has seen windows of waves; histories: {nodal diameter: size(window)}."""
    waves, found = Waves.of(np.arange(N), NO_PAIRS), Growth(DECAY, WINDOW)

    def seen(k):
        motion = sum(tips(size(k), diameters) for diameters, size in histories.items())
        return waves.seen(motion, np.zeros((1, len(PHASE), 0)))

    for k in range(1, n_windows):
        found.see(lambda window, k=k: seen(k - 1 + window))
    return found


def test_the_time_at_which_a_growing_wave_shows_is_foretold():
    """It is hidden below a forced wave, and its change reaches 3 % of the amplitude at 2.6 s."""
    rate, first = 5.0, 1e-8
    found = watched({4: lambda k: 1.0, 3: lambda k: first * np.exp(rate * WINDOW * k)}, 8)
    # rms over the records of a real wave, of which one half goes each way
    change = (1.0 - np.exp(-rate * WINDOW)) * first / np.sqrt(4.0)
    expected = np.log(growth.SHOWS / change) / rate
    assert found.shows(7 * WINDOW, 1.0) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("rate", [-8.0, -1.0])
def test_waves_that_decay_do_not_show(rate):
    found = watched({4: lambda k: 1.0, 3: lambda k: 1e-3 * np.exp(rate * WINDOW * k)}, 8)
    assert np.isnan(found.shows(7 * WINDOW, 1.0))


def test_rounding_does_not_grow():
    random = np.random.default_rng(1)
    found = watched({4: lambda k: 1.0 + 1e-15 * random.standard_normal()}, 9)
    assert np.isnan(found.shows(0.8, 1.0))


@pytest.mark.parametrize(("per_window", "shows"), [(0.02, True), (1e-4, False)])
def test_a_wave_that_drifts_shows_now(per_window, shows):
    """A small wave that swells evenly beside a large one belongs to a transient."""
    found = watched({4: lambda k: 1.0, 3: lambda k: 0.05 + per_window * k}, 8)
    assert found.shows(0.7, 1.0) == pytest.approx(0.7 if shows else np.nan, nan_ok=True)


def test_waves_of_several_places_and_of_unequal_blades():
    """Rows come in any order; where a blade has more places than others, the rest is left out."""
    blade = np.array([2, 0, 1, 0, 1, 2, 2])
    waves = Waves.of(blade, NO_PAIRS)
    motion = np.random.default_rng(2).standard_normal((5, len(blade)))
    seen = waves.seen(motion, np.zeros((5, 0))).reshape(5, 2, 2, 2)  # cosine or sine, wave, place
    for place, rows in enumerate(([1, 2, 0], [3, 4, 5])):
        series = np.fft.rfft(motion[:, rows], axis=1) / 3.0
        assert np.allclose(seen[:, 0, :, place] + 1j * seen[:, 1, :, place], series)


def test_waves_of_a_casing_stand_beside_those_of_the_disk():
    pairs = NO_PAIRS._replace(radial=np.array([2.0, -3.0]))
    seen = Waves.of(np.arange(3), pairs).seen(np.zeros((1, 3)), np.array([[1.0, 2.0, 3.0, 4.0]]))
    assert np.array_equal(seen[0, :, 2:], [[2.0, -9.0], [4.0, -12.0]])


@pytest.fixture(scope="module")
def config():
    return Config.from_yaml(UNSTABLE)


@pytest.fixture(scope="module")
def problem(config):
    return build_problem(config)


def swept(problem, deviation, speeds, **criteria):
    scene = problem.scene._replace(steady=problem.scene.steady._replace(**criteria))
    return run_sweep(mistuned_modes(problem.reduced, deviation), scene, speeds)


def test_a_motion_of_equal_blades_that_does_not_stay_is_marked(problem):
    """When it will have changed is foretold from 2 s; followed on, it has changed then."""
    equal, speeds = np.zeros(N), [22.7]
    marked = swept(problem, equal, speeds)
    assert (marked.point_status[0], marked.point_reason[0]) == (NOT_STEADY, GROWING)
    kept = swept(problem, equal, speeds, watches_growth=False)
    assert kept.amplitude[0] == pytest.approx(marked.amplitude[0], rel=1e-3)
    times = marked.growth_shows[0] + np.array([-0.25, 0.5])
    before, after = (
        swept(problem, equal, speeds, first_check=t, max_time=t, watches_growth=False)
        for t in times
    )
    assert before.amplitude[0] == pytest.approx(kept.amplitude[0], rel=0.02)
    assert after.amplitude[0] > 1.05 * kept.amplitude[0]


def test_a_run_of_unlike_blades_finds_the_motion_that_stays(config, problem):
    """The same amplitude as after 6 s, within its error; 9 to 17 % above that of equal blades."""
    blades, speeds = run_deviation(config, 0), [22.7]
    found = swept(problem, blades, speeds)
    late = swept(problem, blades, speeds, first_check=6.0, max_time=8.0, watches_growth=False)
    assert found.amplitude[0] == pytest.approx(late.amplitude[0], abs=2 * found.error[0])
    assert late.amplitude[0] > 18.0e-3


def test_unlike_blades_are_nearly_equal_and_repeat(config):
    runs = np.array([run_deviation(config, run) for run in (0, 1, 2, 0)])
    assert np.array_equal(runs[0], runs[3])
    assert np.abs(runs).max() <= 1e-4
    assert np.ptp(runs, axis=1).min() > 5e-5
    symmetric = config.replace({"mistuning.reference": "symmetric"})
    assert [np.ptp(run_deviation(symmetric, run)) for run in (0, 1, 12)] == [0.0, 0.0, 0.0]
