"""The reproduction fits the program: its inputs are valid, its rows are made of results."""

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
