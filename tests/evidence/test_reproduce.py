"""The reproduction: its plan is valid, its verdicts are those that its head line promises."""

import numpy as np
import pytest

from evidence.reproduce import plan, rows
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


def test_speeds_are_judged_more_closely():
    assert rows.value_row("0", "peak [Hz]", 34.45, 34.52).agrees == "yes"
    assert rows.value_row("0", "peak [Hz]", 34.45, 34.70).agrees == "near"
    assert rows.value_row("0", "peak [Hz]", 34.45, 35.0).agrees == "no"
