"""What a sweep says of a casing that vibrates, held against whole histories of the same motion."""

import numpy as np
import pytest

from evidence.truth.disk import ALUMINIUM, STEEL
from hpcrub.contact.status import DIVERGED, NOT_FED, RUNAWAY
from hpcrub.model.casing_modes import ring_modes
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response import casing_motion, history
from hpcrub.response.revolution import cut_revolution
from hpcrub.response.sweep import run_sweep
from tests.program import whole

SPEEDS = np.array([33.5, 34.0, 34.5])


def modes_in(problem, ring, most=5):
    casing = ring_modes(ring, np.arange(2, most + 1), 0.005)
    deviation = stiffness_deviation(5, 0, 0, 12, 0.04)
    return mistuned_modes(problem.reduced._replace(casing=casing), deviation)


@pytest.fixture(scope="module")
def swept(problem):
    modes = modes_in(problem, STEEL)
    return modes, run_sweep(modes, problem.scene, SPEEDS)


def test_the_largest_motion_is_that_of_the_history(problem, swept):
    modes, result = swept
    for s, speed in enumerate(SPEEDS):
        found = whole(modes, problem.scene, [speed], result.time[s], "time", "casing", "position")
        time, pairs, q = (values[..., 0] for values in found)
        length = problem.scene.steady.window_revolutions / speed
        inside = time <= result.time[s] * (1 + 1e-9)
        window = inside & (time > result.time[s] - length * (1 - 1e-9))
        angle = np.linspace(0, 2 * np.pi, 721)
        w = casing_motion.radial(modes.pairs, pairs[window], angle)
        assert result.casing.largest[s] == pytest.approx(np.abs(w).max(), rel=1e-2)
        by_wave = np.abs(np.fft.rfft(w[:, :-1], axis=1))[:, 2:6]
        assert result.casing.waves[s] == 2 + np.argmax((by_wave**2).mean(axis=0))
        assert 0 < result.casing.share[s] < 1
        assert np.isnan(result.casing.growth[s])


def test_a_casing_that_runs_away_ends_its_speed_at_once(problem):
    """With the wave that grows, and its rate as in the history of the waves."""
    modes, speed = modes_in(problem, ALUMINIUM, 8), SPEEDS[1]  # all waves are overtaken
    result = run_sweep(modes, problem.scene, [speed])
    assert result.point_status[0] == DIVERGED
    assert result.point_reason[0] == RUNAWAY
    assert result.time[0] < problem.scene.steady.first_check / 2
    (pairs,) = whole(modes, problem.scene, [speed], result.time[0], "casing")
    sizes = casing_motion.amplitudes(modes.pairs, pairs[:, :, 0])
    assert sizes[-1].max() > casing_motion.LARGEST * problem.scene.interface.radius.max()
    wave = np.argmax(sizes[-1])
    assert result.casing.waves[0] == modes.pairs.n_waves[wave]
    grid = cut_revolution(speed, problem.scene)
    per_turn = grid.steps_per_revolution // grid.stride
    if len(sizes) > per_turn:
        rate = np.log(sizes[-1, wave] / sizes[-1 - per_turn, wave]) * speed
        assert result.casing.growth[0] == pytest.approx(rate, rel=1e-6)
    assert np.isnan(result.amplitude[0])


def test_a_history_ends_with_a_casing_that_runs_away_as_a_sweep_does(problem):
    modes, speed = modes_in(problem, ALUMINIUM, 8), SPEEDS[1]
    result = run_sweep(modes, problem.scene, [speed])
    pieces = list(history.integrate(modes, problem.scene, [speed], 0.3))
    assert pieces[-1].reason[0] == RUNAWAY
    growth = result.casing.waves[0], result.casing.growth[0]
    np.testing.assert_allclose(pieces[-1].growth[0], growth, rtol=1e-9)
    failed = [piece.reason[0] != 0 for piece in pieces]
    assert pieces[failed.index(True)].time[-1, 0] == pytest.approx(result.time[0])
    assert not any(piece.position.any() for piece in pieces[failed.index(True) + 1 :])
    assert pieces[-1].time[-1, 0] == pytest.approx(0.3, abs=0.01)


def test_only_a_wave_that_the_rotor_overtakes_is_fed(problem):
    """Of steel, 20 mm: n = 2 travels at 25.3 Hz, n = 3 at 47.8 Hz."""
    pairs = ring_modes(STEEL, np.array([2, 3]), 0.0).seen_from(np.zeros(1))
    for grown, speed, reason in ((0, 34.0, RUNAWAY), (1, 34.0, NOT_FED), (1, 48.0, RUNAWAY)):
        watch, coordinates = casing_motion.Runaway(pairs, problem.scene, 4), np.zeros((3, 4))
        coordinates[1:, 2 * grown] = 1.0 / pairs.radial[grown]
        assert watch.see(coordinates[:1]) == 0
        assert watch.see(coordinates) == 2
        assert watch.reason(speed) == reason
        assert watch.growth(speed)[0] == pairs.n_waves[grown]


def test_the_largest_motion_is_that_of_all_records_and_angles():
    casing = ring_modes(STEEL, np.array([0, 2, 3, 4, 5, 6]), 0.0)
    pairs = casing.seen_from(np.zeros(1))
    y = np.random.default_rng(3).normal(size=(400, 12))
    angle, turned = np.linspace(0, 2 * np.pi, 97)[:-1], np.linspace(0, 9, 400)
    outward = casing.rows(angle)[0]
    assert casing_motion.largest(pairs, y)[0] == pytest.approx(np.abs(y @ outward.T).max())
    fixed = casing_motion.radial(pairs, casing_motion.at_rest(pairs, y, turned), angle)
    for r in (0, 57, 399):
        seen, _ = casing.rows(angle - turned[r])
        np.testing.assert_allclose(fixed[r], seen @ y[r], atol=1e-12)
