"""Disks of a study at small displacements that are computed to second order as well."""

import numpy as np
import pytest

from hpcrub import studies
from hpcrub.config.schema import Config
from hpcrub.results.layout import DONE
from hpcrub.results.verdict import REMARK, SINGLE, USELESS
from hpcrub.setup.problem import build_problem
from hpcrub.studies import open_result
from hpcrub.studies.contact import findings, second_order
from hpcrub.studies.contact import layout as contact_file
from tests.program import TINY, lay_out, run_here

CHECKED = TINY.replace("checked_samples: 0", "checked_samples: 1, tuned_runs: 1")


def test_they_are_the_disks_of_a_study_to_second_order(tmp_path):
    """Same disks, same speeds, same bits; and the verdict says what the second order changes."""
    found = {}
    for kinematics in ("small", "second_order"):
        path = tmp_path / f"{kinematics}.yaml"
        path.write_text(f"{CHECKED}contact: {{kinematics: {kinematics}}}\noutput: {path}.h5\n")
        assert run_here(path) == 0
        with open_result(f"{path}.h5") as file:
            sample = file.read("samples/peak_amplitude_m", (-1, 0))
            found[kinematics] = np.array([file.read("tuned/peak_amplitude_m"), sample])
            if kinematics == "small":
                computed = file.read(second_order.PEAK)
                verdict = findings.verdict(file)
    np.testing.assert_array_equal(computed, found["second_order"])
    change = 100.0 * (found["second_order"] / found["small"] - 1.0)
    ratio = 100.0 * ((1.0 + change[1] / 100.0) / (1.0 + change[0] / 100.0) - 1.0)
    (line,) = (line for line in verdict.lines if line.startswith("to second order"))
    assert f"({change[0]:+.2g} %)" in line
    assert f"and A_nl of 1 disk changes by {ratio:+.2g} %" in line


@pytest.mark.parametrize(
    ("tuned", "sample", "severity"),
    [
        (0.031, 0.0206, REMARK),
        (0.033, 0.022, SINGLE),
        (0.03, 0.03, USELESS),
        (0.055, 0.03, SINGLE),
        (np.inf, 1.0, USELESS),
    ],
)
def test_it_weighs_by_what_changes(tmp_path, tuned, sample, severity):
    """Alike for all disks, millimetres are wrong; not alike, amplifications are, too.

    A change by a motion that the second order cannot tell (of more than 41 mm) is not quoted.
    """
    config = Config.from_yaml(CHECKED).replace({"output": str(tmp_path / "x.h5")})
    lay_out(config.output, config)
    with studies.open_result(config.output, mode="r+") as file:
        contact_file.write_tuned(file, {"peak_amplitude_m": 0.03, "peak_speed_hz": 34.0})
        contact_file.write_sample(file, 1, 0, {"peak_amplitude_m": 0.02, "status": DONE})
        values = {second_order.PEAK: np.array([tuned, sample]), second_order.SPEED: [34.0, 34.0]}
        file.write(values, ())
        (finding,) = second_order.of_displacements(file, np.array([0.03]))
    assert finding.severity == severity
    assert ("%" in finding.advice) == (tuned < 0.041)


def test_they_are_computed_where_they_matter_and_can_be():
    config = Config.from_yaml(CHECKED)
    assert second_order.problem_of(config, 1e-4) is None
    assert second_order.problem_of(config, np.nan) is None
    assert second_order.problem_of(config, 0.03).reduced.interface.second_order
    for keys in ({"mistuning.checked_samples": 0}, {"contact.kinematics": "second_order"}):
        assert second_order.problem_of(config.replace(keys), 0.03) is None


def test_a_part_and_a_smaller_study_have_the_disks_of_the_whole():
    """Parts are merged, and a study of few samples is a part of one with more."""
    whole = Config.from_yaml(CHECKED).replace(
        {"mistuning.samples": 9, "mistuning.checked_samples": 5}
    )
    problem = build_problem(whole)
    for keys in ({"part.samples": [4, 9]}, {"mistuning.samples": 1}):
        part = whole.replace(keys)
        assert second_order.n_disks(part) == second_order.n_disks(whole) == 3
        for number in range(3):
            (mine, _), (theirs, _) = (second_order.disk(c, problem, number) for c in (part, whole))
            np.testing.assert_array_equal(mine.omega, theirs.omega)
