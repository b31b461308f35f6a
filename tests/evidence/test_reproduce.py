"""The reproduction: its plan is valid, its verdicts are those that its head line promises."""

import numpy as np
import pytest

from evidence.reproduce import numbers, plan, rows
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


ROWS = {
    "family": 1, "peaks": 2, "ranges": 3, "table2": 4, "coexistence": 5, "steady_time": 6,
    "linear": 10, "medians": 11, "below": 13, "amplitudes": 14, "samples_needed": 15, "cost": 16,
}  # fmt: skip


@pytest.mark.parametrize("name", ROWS)
def test_rows_are_made_of_results(name):
    found = getattr(numbers, name)(Examples(ROOT / "docs" / "examples"))
    assert {row.number for row in found} == {str(ROWS[name])}
    assert all(row.paper and row.ours for row in found)
