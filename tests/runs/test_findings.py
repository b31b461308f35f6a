"""What is found of a study, and what it makes of its verdict."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from hpcrub import effects, studies
from hpcrub.config.schema import Config
from hpcrub.contact.status import GROWING, NOT_FED, NOT_STEADY, RUNAWAY, STEADY, count
from hpcrub.results.verdict import MOST_ADVICE, REMARK, SINGLE, USELESS, Finding, Verdict
from hpcrub.runs.findings import (
    TIME_KEY,
    kinematics,
    not_resolved,
    of_peaks,
    of_points,
    points_without_result,
    too_few_samples,
)


@pytest.mark.parametrize(("at", "severity"), [(1, USELESS), (0, REMARK)])
def test_points_that_grow_are_told_once_and_count_where_they_are_peaks(at, severity):
    """They were counted as points that have not settled, too."""
    amplitude, states = np.array([[1.0, 2.0, 1.0]]), np.array([[STEADY, STEADY, STEADY]])
    reasons = np.zeros((1, 3), int)
    states[0, at], reasons[0, at] = NOT_STEADY, GROWING
    (found,) = of_points(Config(), amplitude, states, reasons, TIME_KEY)
    assert found.why == "still growing at 1 of 3 points"
    assert found.severity == severity
    (found,) = of_peaks(Config(), np.array([0, 0, 3]))
    assert found.why == "2 of 3 peaks at the lowest speed"


@pytest.mark.parametrize(
    ("study", "key"),
    [
        ("interaction_map", "history.duration_s above 1.2"),
        ("time_response", "history.duration_s above 1.2"),
        ("branches", "steady_state.max_time_s above 4"),
    ],
)
def test_a_motion_that_has_not_settled_needs_more_of_the_studys_own_time(study, key):
    keys = {"history.duration_s": 1.2, "steady_state.max_time_s": 4.0}
    values = {
        "amplitude_m": np.full((1, 3), 1e-3), "tangential_m": np.full((3, 1, 1), 1e-3),
        "mean_amplitude_m": np.full((1, 3), 1e-3), "second_order_amplitude_m": np.full(1, np.nan),
        "point_status": np.full((1, 3), NOT_STEADY), "point_reason": np.zeros((1, 3), int),
    }  # fmt: skip
    if study == "time_response":
        values |= {name: values[name][0] for name in ("point_status", "point_reason")}
        values |= {"amplitude_m": np.full(1, 1e-3)}
    fake = SimpleNamespace(config=Config().replace(keys), read=values.get)
    assert key in str(list(studies.STUDIES[study].findings(fake)))


def test_what_was_not_resolved_is_no_single_number():
    for why in ("not resolved", "steep casing"):
        line = f"{why}: 5 time steps per bump width"
        assert list(not_resolved(["units: rpm", line])) == [Finding(SINGLE, why, line)]


def test_a_verdict_is_that_of_its_weightiest_finding():
    remark, single, useless = (
        Finding(severity, f"why {severity}", f"do {severity}")
        for severity in (REMARK, SINGLE, USELESS)
    )
    assert Verdict.of([]).lines == ["usable"]
    assert Verdict.of([remark]).lines == ["usable", "do 0"]
    of_many = "percentiles usable, single values not: why 1"
    assert Verdict.of([remark, single], of_many=True).lines == [of_many, "do 1", "do 0"]
    assert Verdict.of([single]).lines == ["usable with care: why 1", "do 1"]
    assert Verdict.of([single, useless, useless]).words == "not usable: why 2"
    assert len(Verdict.of([remark] * 9).lines) == 1 + MOST_ADVICE


def test_a_casing_that_vibrates_must_be_known():
    config = Config(casing={"ring": {"thickness_mm": 20}})
    assert [e.name for e in effects.of(Config())] == []
    (casing,) = effects.of(config)
    (found,) = casing.findings(SimpleNamespace(config=config))
    assert found.advice.startswith("damping, thickness and radius of the casing can move peaks")


@pytest.mark.parametrize(
    ("reason", "words"),
    [(RUNAWAY, "or change the casing: a stiffer"), (NOT_FED, "or change time.step_s first")],
)
def test_what_to_change_where_a_casing_runs_away(reason, words):
    (found,) = points_without_result(count([reason]), 1, 1)
    assert words in found.advice


@pytest.mark.parametrize(("millimetres", "weight"), [(5.0, None), (70.0, SINGLE), (101.0, USELESS)])
def test_motions_outside_small_displacements_are_no_result(millimetres, weight):
    """Tips of 500 mm radius; u^2/2R of 5 mm is 0.025 mm where the casing reaches in by 1 mm.

    √(R² + u²) − R of 70 mm is 4.9 mm outwards. A straight clamped blade of the default length is
    shorter by 0.6 w²/l, w = u/cos α, along its chord, which leans by α from the radius at the tip;
    bow and mode leave a tenth. The sum is 2.7 mm inwards.
    """
    found = list(kinematics(Config(), millimetres / 1e3))
    assert [finding.severity for finding in found] == ([] if weight is None else [weight])
    if weight == SINGLE:
        sine, length = 200.0 * np.sin(np.deg2rad(43.7)) / 500.0, 405.0
        shorter = 0.6 * millimetres**2 / (length * np.sqrt(1.0 - sine**2))
        inwards = float(re.search("inwards by (.*) mm, as the", found[0].advice)[1])
        assert inwards == pytest.approx(shorter - millimetres**2 / 1000.0, rel=0.15)
        assert "second_order computes with that" in found[0].advice


def test_a_model_file_that_tells_no_second_order_leaves_the_sum_open():
    disk = Config().disk.model_copy(update={"model": "fan.h5", "tip_radius_mm": 500.0})
    (found,) = kinematics(Config().model_copy(update={"disk": disk}), 0.07)
    assert "outwards by u²/2R = 4.9 mm, and a bent blade is shorter" in found.advice
    assert "hpcrub import --second-order" in found.advice


def test_motions_of_second_order_say_how_large_the_third_is():
    bent = Config().replace({"contact.kinematics": "second_order"})
    (far,), (near,) = (list(kinematics(bent, u)) for u in (0.09, 0.02))
    assert (far.severity, near.severity) == (SINGLE, REMARK)
    assert "20 mm are of second order" in near.advice


def test_the_extremes_of_all_disks_are_known_by_no_number_of_samples():
    """Percentiles 0 and 100 ended in an OverflowError after all samples were computed."""
    (finding,) = too_few_samples([0, 50, 100], 20)
    assert "percentiles 0, 100 have no 95 % interval" in str(finding)
    assert "convergence.percentiles without 0 and 100" in str(finding)
    (finding,) = too_few_samples([0, 1, 50], 20)  # 0.99**367.1 is 0.025
    assert "mistuning.samples of 368 and more, convergence.percentiles without 0" in str(finding)
