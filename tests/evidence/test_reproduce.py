"""The reproduction: its plan is valid, its verdicts are those that its head line promises."""

import numpy as np
import pytest

from evidence.reproduce import numbers, plan, rows
from hpcrub import studies
from hpcrub.config import schema as config
from tests.program import ROOT, load


@pytest.mark.parametrize("step", plan.STEPS, ids=lambda step: step.name)
def test_every_step_is_a_valid_input(step, tmp_path):
    for scale in (0.01, 1.0):
        arguments = plan.arguments(step, tmp_path, scale)
        runs = config.load_runs(arguments[0], plan.overrides(step, tmp_path, scale))
        if step.samples:
            key, full, fewest = step.samples
            section, name = key.split(".")
            expected = max(fewest, round(scale * full))
            assert all(getattr(getattr(run, section), name) == expected for run in runs)


def test_every_study_is_reproduced():
    inputs = {load(ROOT / "inputs" / f"{step.input}.yaml").study for step in plan.STEPS}
    assert inputs == set(studies.STUDIES)


def test_sources_are_results_of_other_steps(tmp_path):
    made = set()
    for step in plan.STEPS:
        assert set(step.sources) <= made
        arguments = plan.arguments(step, tmp_path, 1.0)
        overrides = [*plan.overrides(step, tmp_path, 1.0), f"output={tmp_path / step.name}.h5"]
        runs = config.load_runs(arguments[0], overrides)
        made |= {run.output.removeprefix(f"{tmp_path}/") for run in runs}


@pytest.mark.parametrize(
    ("arguments", "verdict"),
    [
        ((1.75, 1.70, 1.60, 1.80), "yes"),  # inside the interval
        ((1.75, 1.50, 1.40, 1.60), "no"),
        ((1.75, 1.70, 1.68, 1.72), "near"),  # outside, within 5 %
        ((1.75, 1.60, 1.50, np.nan), "open"),  # nothing bounds it from above
        ((1.75, 1.90, 1.80, np.nan), "no"),  # but from below
        ((58.1, 58.5), "yes"),  # without an interval: 1 %
        ((58.1, 60.0), "near"),
        ((58.1, 65.0), "no"),
    ],
)
def test_verdicts(arguments, verdict):
    assert rows.value_row("0", "something [mm]", *arguments).agrees == verdict


def test_one_run_of_the_paper_may_be_any_of_ours():
    runs = np.linspace(30.0, 50.0, 201)
    row = rows.run_row("0", "something [mm]", 49.0, runs, digits=1)
    assert (row.ours, row.interval, row.agrees) == ("40.00", "[30.50, 49.50]", "yes")
    assert rows.run_row("0", "something [mm]", 52.0, runs, digits=1).agrees == "no"


@pytest.mark.parametrize(
    ("smaller", "larger", "verdict"),
    [
        ((1.2, 1.1, 1.3), (1.3, 1.2, 1.4), "yes"),
        ((1.4, 1.3, np.nan), (1.35, 1.25, 1.45), "open"),
        ((1.4, 1.3, 1.5), (1.2, 1.1, np.nan), "open"),
        ((1.4, 1.3, 1.5), (1.2, 1.1, 1.25), "no"),
    ],
)
def test_an_order_is_contradicted_by_intervals_that_lie_apart(smaller, larger, verdict):
    assert rows.order(smaller, larger) == verdict


def test_who_comes_first_is_open_where_intervals_overlap():
    row = rows.order_row("0", "smallest", 3, 1, (1.1, 1.3), (1.2, 1.4))
    assert (row.ours, row.agrees) == ("1", "open")
    assert rows.order_row("0", "smallest", 3, 1, (1.1, 1.15), (1.2, 1.4)).agrees == "no"
    assert rows.order_row("0", "smallest", 3, 3, (1.2, 1.4), (1.2, 1.4)).agrees == "yes"


def test_speeds_are_judged_more_closely():
    assert rows.value_row("0", "peak [Hz]", 34.45, 34.52).agrees == "yes"
    assert rows.value_row("0", "peak [Hz]", 34.45, 34.70).agrees == "near"
    assert rows.value_row("0", "peak [Hz]", 34.45, 35.0).agrees == "no"


class Examples(rows.Results):
    """The small results that come along, for each of the paper's four studies."""

    def file(self, pattern):
        return super().file({"perturbed_pattern.h5": "table2.h5",
                             "perturbed_tuned.h5": "n_d_4.h5"}.get(pattern, pattern))  # fmt: skip

    def contact(self, n_d):
        return self.file(f"n_d_{n_d}.h5")


@pytest.mark.parametrize(
    ("make", "number"),
    [
        (numbers.family, "1"),
        (numbers.peaks, "2"),
        (numbers.ranges, "3"),
        (numbers.table2, "4"),
        (numbers.coexistence, "5"),
        (numbers.steady_time, "6"),
        (numbers.linear, "10"),
        (numbers.medians, "11"),
        (numbers.below, "13"),
        (numbers.amplitudes, "14"),
        (numbers.samples_needed, "15"),
        (numbers.cost, "16"),
    ],
)
def test_rows_are_made_of_results(make, number):
    found = make(Examples(ROOT / "docs" / "examples"))
    assert {row.number for row in found} == {number}
    assert all(row.paper and row.ours for row in found)


def test_what_is_missing_is_said(tmp_path):
    (row, *_) = numbers.rows(rows.Results(tmp_path))
    assert (row.quantity, row.agrees) == (
        "1: frequencies of the first family: no modal.h5",
        "not run",
    )
