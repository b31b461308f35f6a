"""The value of a key that meets a limit: beside brute force, after a stop."""

import json
import re
import shutil

import h5py
import numpy as np
import pytest

from hpcrub import plot
from hpcrub.commands import inspect
from hpcrub.config.schema import Config
from hpcrub.effects.coating import depth_of_all
from hpcrub.results.verdict import SINGLE, USELESS
from hpcrub.setup.disks import deviation
from hpcrub.statistics.percentiles import probability_interval
from hpcrub.statistics.threshold import ABOVE, BELOW
from hpcrub.studies import open_result
from hpcrub.studies.contact.trials import BENT, beyond
from hpcrub.studies.threshold import STUDY as THRESHOLD
from hpcrub.studies.threshold import (
    at_value,
    crossing_in_words,
    n_to_tell,
    results,
    search_of,
    values_of,
)
from tests.plot.drawn import words
from tests.program import BRIEF, computed, datasets, refusal, run_here, swept
from tests.studies.common import largest_amplitudes, refused_study

N = 60
STUDY = (
    BRIEF.replace("samples: 2", f"samples: {N}").replace("[2, 4]", "[4]")
    + """\
study: threshold
threshold: {key: casing.clearance_mm, lowest: 0.2, highest: 1.4, tolerance: 0.6, probability: 0.4}
limits: {amplitude_mm: 10}
"""
)
REFUSED = {
    "threshold.key=casing.clearance": "casing.clearance: unknown key",
    "threshold.key=limits.amplitude_mm": "limits.amplitude_mm changes no disk",
    "threshold.lowest=2": "2.0 is not below threshold.highest, 1.4",
    "limits.amplitude_mm=null": "needs limits.amplitude_mm or limits.stress_mpa",
    "mistuning.half_range_percent=[1, 2]": "a threshold study is of one level",
    "threshold.lowest=-1": "casing.clearance_mm",
    "threshold.key=casing.n_bumps": "casing.n_bumps",
    "threshold.key=mistuning.tuned_runs": "mistuning.tuned_runs changes no disk",
    "casing.clearance_hz_mm=[[30, 0.3], [40, 0.2]]": "it cannot be combined with casing.clear",
    "casing.clearance_s_mm=[[0, 0.3], [9, 0.2]]": "it cannot be combined with casing.clearance_s",
    "threshold.tolerance=1e-4": "threshold.tolerance: 0.0001 divides the range into more than 512",
    "threshold.probability=0.05": "60 disks cannot show .* threshold.probability 0.05.* 104",
    "threshold.key=casing.clearance_hz_mm[0][1]": "no such element of a list",
    "threshold.key=speeds": "threshold.key: at the value 0.2: speeds",
}


@pytest.mark.parametrize("end", ["lowest", "highest"])
def test_a_key_without_effect_is_refused_also_where_an_end_is_its_default(end):
    other = {"lowest": "highest: 1.4", "highest": "lowest: 0.1"}[end]
    text = f"{{key: casing.clearance_mm, {other}, {end}: 0.25}}"
    beside = "clearance_s_mm: [[0, 0.3], [9, 0.2]]"
    config = Config.from_yaml(f"limits: {{amplitude_mm: 9}}\nstudy: threshold\nthreshold: {text}\n"
                              f"casing: {{{beside}}}")  # fmt: skip
    (line,) = THRESHOLD.problems(config)
    assert "has no effect: it cannot be combined with casing.clearance_s_mm" in line


@pytest.fixture(scope="module")
def brute(tmp_path_factory):
    """Folder with the input, its limit the median of all disks half-way, and all their peaks."""
    folder = tmp_path_factory.mktemp("threshold")
    config = Config.from_yaml(STUDY)
    values = config.threshold.values
    configs = [config.replace({"casing.clearance_mm": float(value)}) for value in values]
    peaks = np.array([largest_amplitudes(here, range(N)) for here in configs])
    limit = round(1e3 * float(np.median(peaks[len(values) // 2])), 3)
    computed(folder, STUDY.replace("_mm: 10", f"_mm: {limit}"))
    return folder, peaks, limit / 1e3


@pytest.fixture
def file(brute, tmp_path):
    """A copy of the result, open to be changed."""
    shutil.copy(brute[0] / "one.h5", tmp_path)
    with open_result(tmp_path / "one.h5", mode="r+") as file:
        yield file


def test_every_disk_is_that_of_brute_force_and_the_crossing_is_there(brute):
    folder, peaks, limit = brute
    with h5py.File(folder / "one.h5", "r") as file:
        n, above, found = (file[name][()] for name in ("n_disks", "n_above", "peak_amplitude_m"))
        low, high = file["crossing"][()]
        values, side = file["value"][()], file["side"][()]
        assert {file[name].attrs["units"] for name in ("value", "crossing")} == {b"mm"}
    for v in range(len(values)):
        np.testing.assert_array_equal(found[v, : n[v]], peaks[v, : n[v]])
        assert above[v] == np.count_nonzero(peaks[v, : n[v]] > limit)
        if side[v]:  # certain: all of its disks say the same
            ends = probability_interval(int(np.count_nonzero(peaks[v] > limit)), N, 1.96)
            assert ends[0] > 0.4 or ends[1] < 0.4
    share = (peaks > limit).mean(axis=1)
    crosses = values[np.flatnonzero((share[:-1] > 0.4) & (share[1:] <= 0.4))]
    assert ((low <= crosses) & (crosses <= high)).any()
    assert n.sum() < len(values) * N


@pytest.mark.long
def test_a_stop_changes_no_bit(brute):
    folder, *_ = brute
    first = datasets(folder / "one.h5")
    shutil.copy(folder / "one.h5", folder / "two.h5")
    with h5py.File(folder / "two.h5", "r+") as file:  # as if it had been stopped on its way
        for name in ("status", "peak_amplitude_m", "peak_stress_pa"):
            file[name][:, 15:] = 0 if name == "status" else np.nan
        file["n_disks"][:] = 0
    assert run_here("study.yaml", "--output", "two.h5", "--resume", folder=folder) == 0
    assert datasets(folder / "two.h5") == first


def test_the_figure_tells_where_the_asked_probability_is_met(brute):
    """Each value, coloured by whether it is met for certain, its share of disks, and the answer."""
    folder, values, peaks, limit = brute[0], Config.from_yaml(STUDY).threshold.values, *brute[1:]
    with open_result(folder / "one.h5") as file:
        chance, _ = plot.threshold(file)
        n, sides = file.read("n_disks"), file.read("side")
    drawn = {}
    for bars in chance.containers:
        drawn |= {float(x): (y, bars.get_label()) for x, y in zip(*bars[0].get_data(), strict=True)}
    foot, words = chance.get_ylim()[0], {-1: "met", 0: "not known", 1: "not met"}
    for value, row, disks, side in zip(values, peaks, n, sides, strict=True):
        share, label = drawn.pop(float(value))
        assert share == pytest.approx(max((row[:disks] > limit).mean(), foot))
        assert label == words[side]
    assert not drawn
    safe = values[sides == -1].min()
    assert [text.get_text() for text in chance.texts] == [f"answer: {safe:g} mm"]


def test_the_figure_leads_from_a_disk_to_what_second_order_makes_of_it(file):
    file.write({BENT: 0.007}, (1, 0))
    _, sizes = plot.threshold(file)
    (line,) = (one for one in sizes.get_lines() if one.get_label() == "to second order")
    before, value = file.read("peak_amplitude_m", (1, 0)), file.read("value", 1)
    np.testing.assert_allclose(line.get_xydata(), [[value, 1e3 * before], [value, 7.0]])
    limit = f"limit of {file.config.limits.amplitude_mm:g} mm"
    assert limit in words(sizes)  # and not the limit: one of MPa may decide


def test_what_is_there_is_told_of_the_disks_that_are_expected(brute, capfd):
    """`--status`, `inspect` and a dry run that resumes counted of all disks at all values."""
    folder, *_ = brute
    shutil.copy(folder / "one.h5", folder / "begun.h5")
    with h5py.File(folder / "begun.h5", "r+") as file:
        file["status"][:, 10:] = 0
        file["n_disks"][:] = 0
        n = np.count_nonzero(file["status"])
    with open_result(folder / "begun.h5") as begun:
        expected = THRESHOLD.next_round(begun).expected
    options = "study.yaml", "--output", "begun.h5"
    assert run_here(*options, "--status", folder=folder) == 75
    assert inspect.main([str(folder / "begun.h5")]) == 0
    said, told = capfd.readouterr().out, f"{n} of about {expected} disks (at most 300)\n"
    assert f"begun.h5: {told}" in said
    assert f"done: {told}" in said
    assert run_here(*options, "--resume", "--dry-run", folder=folder) == 0
    assert f"already there:        {100 * n / expected:.3g} %" in capfd.readouterr().out
    assert run_here("study.yaml", "--output", "one.h5", "--status", folder=folder) == 0
    assert re.search(r"one.h5: \d+ of at most 300 disks, converged\n", capfd.readouterr().out)


def test_a_file_is_complete_once_its_answer_is_written_with_whatever_rounding(file):
    low = file.read("probability_low")
    file.write({"probability_low": low * (1.0 + 1e-12)}, ())
    assert THRESHOLD.is_enough(file)
    assert not THRESHOLD.next_round(file).tasks
    file.write({"crossing": np.full(2, np.nan)}, ())  # as if killed before
    assert not THRESHOLD.is_enough(file)


def test_no_contact_at_any_value_is_an_answer(tmp_path):
    far = STUDY.replace("lowest: 0.2, highest: 1.4", "lowest: 3, highest: 4")
    with open_result(computed(tmp_path, far, output="far.h5")) as file:
        assert crossing_in_words(file).startswith("no blade touches the casing at any value tried")
        assert (file.read("side")[[0, -1]] == BELOW).all()


def test_disks_without_a_result_count_as_beyond_the_limit_and_are_told(file):
    n = file.read("n_disks")
    file.write({"peak_amplitude_m": np.full(n[0], np.nan)}, (0, slice(n[0])))
    assert beyond(file)[0, : n[0]].all()
    (lost,) = (f for f in THRESHOLD.findings(file) if "no result" in f.why)
    assert lost.why == f"{n[0]} of {n.sum()} disks have no result"
    assert lost.severity == USELESS


def test_disks_that_move_far_are_no_doubt_where_they_are_far_beyond_the_limit(file):
    """The verdict was "not usable" by 101 mm at values far from the answer, whose limit is 30."""
    values, crossing, side = map(file.read, ("value", "crossing", "side"))
    far = np.flatnonzero((side == ABOVE) & ~np.isin(values, crossing))[0]
    for value, is_told in ((far, False), (np.flatnonzero(values == crossing[0])[0], True)):
        file.write({"peak_amplitude_m": np.array(0.3)}, (value, 0))
        whys = [found.why for found in THRESHOLD.findings(file)]
        assert any("outside small displacements" in why for why in whys) == is_told


def test_a_value_that_cannot_be_told_is_not_said_to_be_below(file):
    """All values were called below 20 %, though of 20 disks at one of them 5 were beyond."""
    values, n = file.read("value"), file.read("n_disks")
    n[file.read("side") == ABOVE] = 0
    n[0] = 20  # 9 of them beyond the limit, beside a target of 40 %
    size = np.where(np.arange(N) < 9, 1.0, 1e-3)
    file.write({"n_disks": n}, ())
    file.write({"peak_amplitude_m": size}, 0)
    file.write(results(file.config, search_of(file)), ())
    line, found = crossing_in_words(file), [f.why for f in THRESHOLD.findings(file)]
    assert "at all values" not in line
    assert f"with 99 % confidence; not known: {values[0]:g}" in line
    assert "one side of 40 % is not certain anywhere" in found
    left, _ = plot.threshold(file)  # no value is orange; half of the figure was empty
    left.figure.draw_without_rendering()
    assert left.get_position().height > 0.5


def test_a_tolerance_that_was_not_reached_is_told_with_what_would_reach_it(file):
    """The verdict was "usable" where 1 N was asked and 9 were reached."""
    assert not any("known within" in f.why for f in THRESHOLD.findings(file))
    low, high = file.read("crossing")
    values, n = file.read("value"), file.read("n_disks")
    n[(values > values[0]) & (values < high)] = 3  # too few to be certain
    file.write({"n_disks": n}, ())
    (found,) = (f for f in THRESHOLD.findings(file) if "known within" in f.why)
    assert found.severity == SINGLE
    assert "not 0.6, as threshold.tolerance asks" in found.advice
    n_told = n_to_tell(0.01, 0.004)  # what would reach it, where 4 of 1,000 exceed the limit
    high = probability_interval(round(0.004 * n_told), n_told, 2.807)[1]
    assert high == pytest.approx(0.01, rel=0.05)


def key(text, **asked):
    """Input of a search for a key, beside some text."""
    rows = ", ".join(f"{name}: {json.dumps(value)}" for name, value in asked.items())
    return Config.from_yaml(f"study: threshold\nthreshold: {{{rows}}}\n{text}")


def test_a_key_with_whole_numbers_has_whole_values():
    """Of 1 to 4, 1.75 was tried and refused."""
    config = key("", key="casing.n_bumps", lowest=1, highest=4, tolerance=1)
    np.testing.assert_array_equal(values_of(config), [1, 2, 3, 4])
    assert at_value(config, 3.0).casing.n_bumps == 3


def test_an_element_of_a_list_is_a_key():
    text = "casing: {harmonics: [{order: 2, amplitude_mm: 0.1}, {order: 3, amplitude_mm: 0.2}]}\n"
    config = key(text, key="casing.harmonics[1].amplitude_mm")
    first, second = at_value(config, 0.7).casing.harmonics
    assert (first.amplitude_mm, second.amplitude_mm, second.order) == (0.1, 0.7, 3)
    whole = key(text, key="casing.harmonics[0].order", lowest=2, highest=5)
    np.testing.assert_array_equal(values_of(whole), [2, 3, 4, 5])


def test_a_clearance_over_the_speed_is_moved_as_a_whole():
    text = "casing: {clearance_hz_mm: [[30, 0.3], [40, 0.2]]}\n"
    config = key(text, key="casing.clearance_offset_mm", lowest=-0.2, highest=0.5)
    moved = at_value(config, -0.2).casing
    np.testing.assert_allclose(moved.clearances(np.array([30, 35, 40])), [1e-4, 5e-5, 0], atol=1e-9)
    assert at_value(config, 0.1).clearance == pytest.approx(config.clearance + 1e-4)
    told = refusal(at_value, config, -0.25)
    assert "a clearance of -0.005 mm, casing.clearance_offset_mm included" in told


def test_samples_that_are_not_given_are_as_many_as_the_target_needs():
    """5,000 disks, none beyond, do not show a probability below 0.001: 5,296 are needed."""
    config = key("limits: {stress_mpa: 350}\n", key="casing.clearance_mm", probability=0.001)
    assert config.mistuning.samples > 5296
    assert not [*THRESHOLD.problems(config)]
    few = config.replace({"mistuning.samples": 5000})
    assert any("5,296 can" in line for line in THRESHOLD.problems(few))


@pytest.mark.parametrize("override", REFUSED)
def test_what_cannot_be_searched_for_is_refused(folder, override, capsys):
    assert re.search(REFUSED[override], refused_study(folder, STUDY, override, capsys))


@pytest.mark.parametrize(
    ("name", "ends", "told"),
    [
        ("casing.clearance_mm", (0.2, 1.4), []),
        ("casing.clearance_mm", (0.2, 12.0), ["2.4 %", "(at casing.clearance_mm = 12)"]),
        ("casing.clearance_mm", (12.0, 30.0), ["2.4 %", "clearance_mm = 12)", "6 %", "= 30)"]),
        ("contact.friction", (0.0, 0.3), ["12 %", "casing.clearance_mm is in mm"]),
    ],
)
def test_what_is_not_plausible_is_told_of_both_ends_of_the_range(folder, name, ends, told, capfd):
    """It was told of the input's own value alone, which is not computed; so was "contact: none"."""
    (folder / "study.yaml").write_text(STUDY)
    keys = {"key": name, "lowest": ends[0], "highest": ends[1], "tolerance": np.ptp(ends)}
    options = [f"--set=threshold.{where}={value}" for where, value in keys.items()]
    options.append("--set=casing.clearance_mm=60")
    assert run_here("study.yaml", "--dry-run", *options, folder=folder) == 0
    said = capfd.readouterr().out
    found = [line for line in said.splitlines() if " units: " in line]
    for line, size, end in zip(found, told[::2], told[1::2], strict=True):
        assert f"the clearance is {size}" in line
        assert line.endswith(end)
    assert ("contact:              none" in said) == (ends[0] != 0.2)


def test_disks_that_cut_through_their_coating_are_told(tmp_path):
    """They were *usable*, with amplitudes of disks that rub on the casing behind it."""
    coating = "contact: {law: abradable, coating: {thickness_mm: 0.3, yield_mpa: 0.1}}\n"
    text = STUDY.replace("0.2, highest: 1.4", "0.3, highest: 0.9").replace(": 60", ": 15") + coating
    with open_result(computed(tmp_path, text, "--no-figures")) as file:
        depth, known = file.read("deepest_m"), np.isfinite(file.read("peak_amplitude_m"))
        config = at_value(file.config, file.read("value")[0])
        own = swept(config, deviation(config, 0, 3))
        lines = THRESHOLD.verdict(file).lines
    assert depth[0, 3] == own.wear.depth.max()
    n = np.count_nonzero(depth[known] >= depth_of_all(config) * (1.0 - 1e-9))
    assert lines[1].startswith(f"{n} of {known.sum()} disks cut through the coating and reach")
    assert n > 0
