"""A little of ``make stress``, and that its checks can fail."""

import numpy as np
import pytest

from evidence.stress import checks, histories, marches, monte_carlo, operators, steady_state
from evidence.stress.corners import CORNERS, Case, build, cases
from evidence.stress.model import reference_reduced, reference_scene
from evidence.validation import energy_balance
from hpcrub.contact import status
from hpcrub.contact.status import DIVERGED, STEADY
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.steady import SteadyCriteria
from hpcrub.response.sweep import cut_revolution

FIRST = {case.corner: case for case in cases(share=0.01)}


@pytest.mark.parametrize("corner", CORNERS)
def test_first_case_of_every_corner(corner):
    found = checks.examine(FIRST[corner])
    assert found.faults == ()


@pytest.fixture(scope="module")
def sound():
    modes, scene, speeds = build(Case("none", 1, scene=(("bump_height", 0.5e-3),), speed=33.0))
    return modes, scene, speeds, checks.run_sweep(modes, scene, speeds, width=checks.WIDTH)


def test_checks_find_nothing_in_a_sound_result(sound):
    modes, scene, speeds, result = sound
    assert (result.point_status == STEADY).any()
    assert list(checks.consistent(result, scene, speeds)) == []
    assert checks.follow(modes, scene, speeds, result)[2] == []
    assert checks.stepwise(modes, scene, speeds, result)[-1] == []
    assert marches.whole(modes, scene, speeds, result, checks.MOST_ROUND_OFF) == (8, [])
    assert marches.audited(modes, scene, speeds, result, checks.WIDTH) == (8, 0, [])
    case = Case("none", operators.SOUND_EVERY)
    assert operators.judge(case, modes, scene, speeds, result) == (1, [])


@pytest.mark.parametrize(
    ("field", "value", "fault"),
    [
        ("amplitude", np.nan, "NaN or infinity"),
        ("amplitude", np.inf, "NaN or infinity"),
        ("point_status", 0, "without a status"),
        ("point_status", DIVERGED, "diverged point with a result"),
        ("point_reason", status.TOO_LARGE, "contradict"),
        ("time", 1e3, "longer than allowed"),
    ],
)
def test_a_spoilt_result_is_noticed(sound, field, value, fault):
    _, scene, speeds, result = sound
    spoilt = getattr(result, field).copy()
    spoilt[2] = value
    faults = list(checks.consistent(result._replace(**{field: spoilt}), scene, speeds))
    assert any(fault in f for f in faults)


def test_a_false_steady_is_noticed(sound):
    modes, scene, speeds, result = sound
    false = result._replace(
        point_status=np.full(8, STEADY, np.uint8), time=np.full(8, 7.0 / speeds)
    )
    faults = checks.follow(modes, scene, speeds, false)[2]
    assert any("against the criteria" in f for f in faults)
    assert any("marched again" in f for f in faults)


def test_forces_of_the_wrong_sign_are_noticed(sound, monkeypatch):
    modes, scene, speeds, result = sound
    fill = checks.banks.fill_lane

    def pulling(bank, lane, *arguments):
        fill(bank, lane, *arguments)
        bank.contact.stiffness[:, lane] *= -1e-3

    monkeypatch.setattr(checks.banks, "fill_lane", pulling)
    faults = checks.stepwise(modes, scene, speeds, result)[-1]
    assert any("tension" in f for f in faults)
    assert any("penetration" in f for f in faults)


def test_a_penetration_that_is_not_a_number_is_noticed(sound, monkeypatch):
    modes, scene, speeds, result = sound
    fill = checks.banks.fill_lane

    def spoilt(bank, lane, *arguments):
        fill(bank, lane, *arguments)
        bank.state.position[0, lane] = np.nan

    monkeypatch.setattr(checks.banks, "fill_lane", spoilt)
    worst, _, _, faults = checks.stepwise(modes, scene, speeds, result)
    assert np.isnan(worst)
    assert any("penetration" in f for f in faults)


def test_displaced_tips_that_are_held_too_far_out_are_noticed(sound, monkeypatch):
    modes, scene, speeds, _ = sound
    scene = scene._replace(kinematics="polar")
    result = checks.run_sweep(modes, scene, speeds, width=checks.WIDTH)
    worst, contacts, left, faults = checks.stepwise(modes, scene, speeds, result)
    assert (contacts > 100, faults) == (True, [])
    assert left > 1e-9  # more than rounding: the bound is needed
    monkeypatch.setattr(checks, "STEEPEST", 0.0)
    assert checks.stepwise(modes, scene, speeds, result)[0] > worst


@pytest.mark.parametrize("friction", [1.2, 1.5])
def test_false_flaws_are_noticed(sound, friction):
    modes, scene, speeds, result = sound
    case = Case("none", 1)
    flawed = checks.run_sweep(modes, scene._replace(friction=friction), speeds)
    assert operators.judge(case, modes, scene._replace(friction=friction), speeds, flawed)[1] == []
    fault = f"{status.WORDS[flawed.point_reason[0]]}, against its principal minors"
    assert operators.judge(case, modes, scene, speeds, flawed) == (8, [fault] * 8)
    sound_ones = flawed._replace(point_reason=result.point_reason, point_status=result.point_status)
    case = Case("none", operators.SOUND_EVERY)
    found = operators.judge(case, modes, scene._replace(friction=friction), speeds, sound_ones)
    assert found == (1, ["none, against its principal minors"])


def test_a_history_that_hides_its_failure_is_noticed(sound, monkeypatch):
    modes, scene, speeds, result = sound
    locked = scene._replace(friction=1.5)
    failed = checks.run_sweep(modes, locked, speeds)
    assert marches.whole(modes, locked, speeds, failed, checks.MOST_ROUND_OFF) == (8, [])
    monkeypatch.setattr(marches.history, "judge", lambda *arguments: status.NONE)
    faults = marches.whole(modes, locked, speeds, failed, checks.MOST_ROUND_OFF)[1]
    assert "a history goes through the casing without a reason" in faults
    assert "a history fails where its sweep does not, or the other way round" in faults


def test_energy_from_nowhere_is_noticed(sound, monkeypatch):
    modes, scene, speeds, result = sound
    monkeypatch.setattr(energy_balance, "TOLERANCE", 0.0)
    _, n_open, faults = marches.audited(modes, scene, speeds, result, checks.WIDTH)
    assert n_open == 8
    assert faults == ["the energy audit does not close"]


def test_tests_of_the_steady_state_are_judged_as_a_sweep_would():
    """Up to the time limit, at which a sweep checks once more and `steady_state` does not."""
    scene = reference_scene(steady=steady_state.PAPER._replace(max_time=3.0))
    modes = mistuned_modes(reference_reduced(), np.linspace(-0.03, 0.03, 12))
    speeds = histories.SPEEDS[:16]
    grid = cut_revolution(speeds[0], scene)
    members = histories.of_speeds(modes, scene, grid, speeds, 0, 0)
    verdict = steady_state.judge(histories.Histories(*members), scene.steady)
    result = checks.run_sweep(modes, scene, speeds)
    steady = verdict.accepted
    assert steady.sum() > 4
    assert (result.point_status[steady] == STEADY).all()
    np.testing.assert_allclose(verdict.time[steady], result.time[steady], rtol=1e-12)
    np.testing.assert_allclose(verdict.amplitude[steady], result.amplitude[steady], rtol=1e-6)


def test_the_criteria_once_more():
    t = np.linspace(0.0, 6.0, 1200)
    wave = np.sin(2 * np.pi * t)
    assert checks.accepted(wave, 1.0, 1.0, SteadyCriteria())
    assert not checks.accepted(wave, 1.0, 1.02, SteadyCriteria())
    assert not checks.accepted(np.sin(2 * np.pi * 1.1 * t), 1.0, 1.0, SteadyCriteria())


def test_independent_studies_share_no_sample():
    studies = monte_carlo.disjoint(np.arange(1000), 64)
    assert studies.shape == (15, 64)
    assert len(np.unique(studies)) == studies.size
    assert (studies.ravel() == np.arange(960)).all()


def test_spread_of_independent_studies_is_that_of_theory():
    """Medians of 100 normal samples: deviation √(π/200), whatever the program."""
    pool = np.random.default_rng(3).normal(size=100_000)
    found = monte_carlo.spread(pool, monte_carlo.disjoint(pool, 100))
    assert abs(found.deviation[1] / np.sqrt(np.pi / 200.0) - 1.0) < 0.1
    assert found.covered_interval.min() > 0.99
