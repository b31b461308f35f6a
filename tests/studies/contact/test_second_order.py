"""Disks of a study at small displacements that are computed to second order as well."""

import re

import numpy as np
import pytest

from hpcrub import studies
from hpcrub.config.schema import Config
from hpcrub.response.sweep import run_sweep
from hpcrub.results.layout import DONE
from hpcrub.results.verdict import REMARK, SINGLE, USELESS
from hpcrub.setup.disks import modes_of
from hpcrub.setup.problem import build_problem
from hpcrub.studies import open_result
from hpcrub.studies.contact import findings, second_order, trials
from hpcrub.studies.contact import layout as contact_file
from hpcrub.studies.run_up import summary
from tests.program import BRIEF, TINY, computed, lay_out, run_here
from tests.studies.common import lines_of_progress

CHECKED = TINY.replace("checked_samples: 0", "checked_samples: 1, tuned_runs: 1")


@pytest.mark.long
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
    Where amplifications decide they are the reason: it was "the tuned peak by +0 %".
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
    assert ("moves A_nl by +50 %" in finding.why) == (tuned == 0.03)


def test_they_are_computed_where_they_matter_and_can_be():
    config = Config.from_yaml(CHECKED)
    assert second_order.matters(config, 0.06)
    assert not second_order.matters(config, 2e-4)
    assert not second_order.matters(config, np.nan)
    for keys in ({"mistuning.checked_samples": 0}, {"contact.kinematics": "second_order"}):
        assert not second_order.matters(config.replace(keys), 0.06)


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


LIMITED = "limits: {amplitude_mm: 12}\n"
AT_AN_ANSWER = {
    "rare": LIMITED.replace("}", ", probability_error: 0.9}"),
    "threshold": LIMITED
    + "threshold: {key: casing.clearance_mm, lowest: 0.3, highest: 0.5, tolerance: 0.1, "
    "probability: 0.4}\n",
    "patterns": "patterns: {types_percent: [2, -2], kept: 1, candidates: 2, contact_samples: 2}\n",
}


N_BENT = {"rare": 6, "threshold": 6, "patterns": 4}


@pytest.mark.parametrize("study", AT_AN_ANSWER)
@pytest.mark.long
def test_disks_at_an_answer_are_computed_to_second_order(study, tmp_path, capsys):
    """They are those of the same input to second order; the verdict says it; a stop loses none."""
    text = BRIEF.replace("checked_samples: 0", "checked_samples: 2").replace("[2, 4]", "[4]")
    text = text.replace("samples: 2", "samples: 16") + f"study: {study}\n{AT_AN_ANSWER[study]}"
    computed(tmp_path, text)
    with open_result(tmp_path / "one.h5", mode="r+") as file:
        of = studies.run_of(file.config).study
        after, before = file.read(trials.BENT), file.read(of.amplitude)
        places = [tuple(place) for place in np.argwhere(~np.isnan(after))]
        assert len(places) == N_BENT[study]
        assert max(place[-1] for place in places) < 6  # by their numbers, whatever they did
        for place in places:
            config, blades = of.case(file.config, place if len(place) > 1 else int(place[0]))
            config = config.replace({"contact.kinematics": "second_order"})
            problem = build_problem(config)
            modes = modes_of(config, problem, blades)
            alone = run_sweep(modes, problem.scene, config.speeds.values_hz).amplitude.max()
            assert after[place] == alone != before[place]
        found = [finding.advice for finding in of.findings(file)]
        (line,) = (advice for advice in found if advice.startswith("to second order"))
        assert f"to {1e3 * np.median([after[place] for place in places]):.3g} mm from" in line
        file.write({trials.BENT_STATUS: 0, trials.BENT: np.nan}, places[0])
        assert not of.is_enough(file)
    assert run_here("study.yaml", "--output", "one.h5", "--resume", folder=tmp_path) == 0
    with open_result(tmp_path / "one.h5") as file:
        np.testing.assert_array_equal(file.read(trials.BENT), after)


@pytest.mark.long
def test_the_tuned_disk_runs_up_to_second_order(tmp_path):
    """Its peaks are those of a study to second order."""
    text = TINY.replace("checked_samples: 0", "checked_samples: 1").partition("\n")[2]
    text += "study: run_up\nrun_up: {from_hz: 33, to_hz: 36, hz_per_s: [4, 8], repeats: 2}\n"
    computed(tmp_path, text)
    bent = "contact.kinematics=second_order"
    computed(tmp_path, text, "--set", bent, output="two.h5")
    with open_result(tmp_path / "one.h5") as file, open_result(tmp_path / "two.h5") as other:
        found = file.read("tuned/second_order_peak_m")
        (rate,) = np.flatnonzero(np.isfinite(found[:, 0, 0]))
        assert rate == np.nanmax(file.read("tuned/peak_amplitude_m"), axis=(1, 2)).argmax()
        np.testing.assert_array_equal(found[rate], other.read("tuned/peak_amplitude_m", rate))
        assert np.isnan(other.read("tuned/second_order_peak_m")).all()
        words = " ".join(found.advice for found in summary.findings(file))
    assert "peaks of the tuned disk change by " in words
    assert f"to {1e3 * np.median(found[rate], axis=0).max():.3g} mm from" in words


@pytest.mark.parametrize(
    ("after", "severity", "words"),
    [
        ([np.nan] * 3, None, ""),
        ([0.0202] * 3, REMARK, "change by +1 ± 0 %, at the median, to 20.2 mm from 20 mm"),
        ([0.0192, np.nan, np.nan], REMARK, "change by -4 %, to 19.2 mm"),
        ([0.0180, np.nan, np.nan], SINGLE, "change by -10 %"),
        ([0.0190, 0.0200, 0.0220], SINGLE, "change by +1.7 ± 19 %"),
        ([0.0140, 0.0141, 0.0142], USELESS, "change by -30 ± 1.2 %"),
        (
            [0.0550, 0.0540, 0.0200],
            SINGLE,
            "the peak of the disks, at the median, is 54 mm, where small displacements say 20 mm;",
        ),
        ([np.inf, np.inf, 0.0202], USELESS, "there is no result of the disks"),
    ],
)
def test_it_weighs_how_far_peaks_move(tmp_path, after, severity, words):
    config = Config.from_yaml(CHECKED).replace({"output": str(tmp_path / "x.h5")})
    lay_out(config.output, config)
    with studies.open_result(config.output) as file:
        sizes = np.full(3, 0.02), np.array(after)
        found = second_order.of_others(file, "the disks", *sizes)
    assert (found and found.severity) == severity
    assert words in (found.advice if found else "")


@pytest.mark.parametrize("study", AT_AN_ANSWER)
def test_it_names_the_disks_of_every_study_in_a_sentence(tmp_path, study):
    """It was "of the best pattern, and without one,, at the median"."""
    text = BRIEF.replace("[2, 4]", "[4]").replace("samples: 2", "samples: 16")
    config = Config.from_yaml(f"{text}study: {study}\n{AT_AN_ANSWER[study]}")
    which = studies.run_of(config).study.which
    lay_out(str(tmp_path / "x.h5"), Config.from_yaml(CHECKED))
    with studies.open_result(tmp_path / "x.h5") as file:
        for size in (0.03, 0.055, np.inf):
            found = second_order.of_others(file, which, np.full(2, 0.02), np.full(2, size))
            assert f" of {which}" in found.advice
            assert not re.search(r",\W*,", found.advice + found.why)


def test_disks_to_second_order_are_counted_by_themselves(tmp_path, capsys):
    """They were "disks: 6 of 5"."""
    text = BRIEF.replace("checked_samples: 0", "checked_samples: 1").replace("[2, 4]", "[4]")
    text = text.replace("samples: 2", "samples: 8") + f"study: rare\n{AT_AN_ANSWER['rare']}"
    (tmp_path / "study.yaml").write_text(text)
    told = lines_of_progress(tmp_path, capsys, "--output", "one.h5")
    assert [line for line in told if "order" in line][-1] == "disks to second order: 6 of 6"
