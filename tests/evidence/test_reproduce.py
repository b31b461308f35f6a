"""The reproduction: its plan is valid, its verdicts are those that its head line promises."""

import numpy as np
import pytest

from evidence.reproduce import numbers, plan, report, rows
from hpcrub import plot
from hpcrub.config import schema as config
from tests.program import ROOT


@pytest.mark.parametrize("step", plan.STEPS, ids=lambda step: step.name)
def test_every_step_is_a_valid_input(step, tmp_path):
    for scale in (0.01, 1.0):
        arguments = plan.arguments(step, tmp_path, scale)
        runs = config.load_runs(arguments[0], plan.overrides(step, tmp_path, scale))
        if step.samples:
            key, full, fewest = step.samples
            section, name = key.split(".")
            expected = full if scale == 1.0 else max(fewest, round(scale * step.weight * full))
            assert all(getattr(getattr(run, section), name) == expected for run in runs)


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


def test_the_sentence_at_the_top_counts_the_rows():
    words = ("yes", "near", "no", "no", "open", "")
    found = [rows.Row("", "", "", "", "", word, fitted=word == "yes") for word in words]
    text = report.verdict(found)
    assert "Of 5 numbers" in text
    assert "2 agree with ours or are near, 2 do not, 1 are open" in text
    assert "of the 4 that took no part" in text
    assert text.endswith("agree is 1.**")


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


def test_the_papers_points_are_drawn_in_its_figure_7(tmp_path):
    example = ROOT / "docs" / "examples" / "table2.h5"
    (tmp_path / "table2.h5").symlink_to(example)
    report.figures(tmp_path, tmp_path / "page.md")
    assert (tmp_path / "page" / "figure_7_table2.png").exists()
    left, right = plot.summary(example)
    report.mark_points(left, right)
    assert [tuple(np.ravel(s.get_data())) for s in left.get_lines()[-2:]] == [
        (34.78, 58.1), (33.66, 38.9),
    ]  # fmt: skip
    assert right.get_lines()[-1].get_ydata() == [67.9]


def test_what_is_missing_is_said(tmp_path):
    (row, *_) = numbers.rows(rows.Results(tmp_path))
    assert (row.quantity, row.agrees) == (
        "1: frequencies of the first family: no modal.h5",
        "not run",
    )
