"""How far a contact study is to be trusted: peaks, limits, stress at the root, worn depths."""

from types import SimpleNamespace

import numpy as np
import pytest

from hpcrub import effects, plot, studies
from hpcrub.commands import inspect
from hpcrub.config.schema import Config
from hpcrub.contact.status import AVERAGED, NOT_STEADY, STEADY
from hpcrub.results.layout import DONE, FAILED
from hpcrub.results.verdict import MOST_ADVICE, REMARK, SINGLE, USELESS
from hpcrub.runs.findings import TIME_KEY, of_points
from hpcrub.setup import input_files
from hpcrub.statistics.percentiles import (
    percentile_interval,
    probability_interval,
    running_percentiles,
)
from hpcrub.studies import energy, open_result
from hpcrub.studies.contact import findings, limits, second_order, summary
from hpcrub.studies.contact import layout as contact_file
from hpcrub.studies.contact.layout import AMPLIFICATION, LINEAR
from hpcrub.studies.contact.survey import shared_uncertainty, survey
from tests.plot.stored import PATTERN, PHYSICS, File
from tests.program import TINY, lay_out, run_here, swept

(WEAR,) = (effect for effect in effects.EFFECTS if effect.name == "wear")
RUNS = np.array([31.0, 29.0, 30.0, 33.0, 28.0, 30.0, 31.0, 32.0, 30.0]) * 1e-3


@pytest.fixture
def file(tmp_path):
    """Four disks of two levels: peaks at the lowest, the highest and twice the middle speed."""
    config = Config.from_yaml(TINY + "limits: {amplitude_mm: 35, stress_mpa: 1e4}\n")
    config = config.replace({"output": str(tmp_path / "x.h5")})
    lay_out(config.output, config)
    sizes = np.array([[40, 30, 20], [10, 20, 50], [20, 30, 29], [10, 30, 12]]) * 1e-3
    states = [[AVERAGED, 1, 1], [1, 1, NOT_STEADY], [1, STEADY, 1], [1, AVERAGED, 1]]
    with studies.open_result(config.output, mode="r+") as found:
        contact_file.write_tuned(
            found,
            {"run_peaks_m": RUNS, "reference_amplitude_m": 0.03, "peak_speed_hz": 34.2,
             "peak_amplitude_m": RUNS[0], "linear_amplitude_m": 1e-4},
        )  # fmt: skip
        for i, (size, state) in enumerate(zip(sizes, states, strict=True)):
            values = {
                "amplitude_m": size, "amplitude_error_m": 0.05 * size, "status": DONE,
                "amplitude_scatter_m": 0.07 * size, "time_s": 0.8 + 0 * size,
                "peak_amplitude_m": size.max(), "peak_stress_pa": 2e9,
                "point_status": np.array(state, np.uint8),
            }  # fmt: skip
            contact_file.write_sample(found, i // 2, i % 2, values)
        yield found


def test_of_a_few_measured_disks_no_percentiles_are_called_usable(tmp_path, monkeypatch):
    """Each has a row in the summary; the verdict was "percentiles usable, single values not"."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "disks.csv").write_text(
        "".join(f"{','.join(12 * [b])}\n" for b in ("1", "-1", "2"))
    )
    text = TINY.replace("half_range_percent: [2, 4], samples: 2", "pattern: disks.csv")
    lay_out("x.h5", input_files.resolved(Config.from_yaml(text)).replace({"output": "x.h5"}))
    size = np.array([1e-3, 2e-3, 1e-3])  # over a coarse grid of speeds
    of_disk = {"amplitude_m": size, "peak_amplitude_m": 2e-3, "point_status": [STEADY] * 3}
    with studies.open_result("x.h5", mode="r+") as found:
        contact_file.write_tuned(found, {"peak_amplitude_m": 2e-3, "peak_speed_hz": 34.2})
        for i in range(3):
            contact_file.write_sample(found, 0, i, of_disk | {"status": DONE})
        verdict = findings.verdict(found)
    assert verdict.words.startswith("usable with care: ")
    assert "percentiles" not in " ".join(verdict.lines)


def test_peaks_are_counted_by_what_they_are_and_where_they_lie(file):
    found = survey(file)
    assert [found.peaks[s] for s in (STEADY, AVERAGED, NOT_STEADY)] == [1, 2, 1]
    assert (found.lowest, found.highest, found.alone) == (1, 1, 1)
    assert found.points.sum() == 12
    assert found.error == pytest.approx(0.05)
    assert found.largest == pytest.approx(0.05)
    whole = findings.verdict(file)
    verdict, *advice = whole.lines
    assert verdict.startswith("not usable: ")
    assert not whole.usable
    assert len(advice) == MOST_ADVICE
    text = "\n".join(advice)
    for why, what in (
        ("1 of 4 peaks have not settled", "steady_state.max_time_s above 0.5"),
        ("1 of 4 peaks at the lowest speed", "speeds.from_hz below 34"),
        ("1 of 4 peaks at the highest speed", "speeds.to_hz above 34.4"),
    ):
        assert why in verdict
        assert what in text
    assert "at 1 of 4 peaks both neighbouring speeds are more than 10 % lower" in text


def test_a_tuned_peak_at_the_last_speed_is_marked_where_the_steps_do_not_reach_the_end(file):
    config = file.config.replace({"speeds.from_hz": 33.8, "speeds.to_hz": 34.3})
    counts = survey(file)
    found = SimpleNamespace(config=config, read=file.read)
    assert config.speeds.values_hz[-1] == file.read("tuned/peak_speed_hz") < config.speeds.to_hz
    edge = "tuned peak at the edge of the speeds"
    assert edge in str(list(findings._speeds(found, counts)))
    assert edge not in str(list(findings._speeds(file, counts)))


def test_disks_that_do_not_touch_have_no_peak_at_an_end(file):
    none = {"amplitude_m": np.zeros(3), "peak_amplitude_m": 0.0, "status": DONE}
    contact_file.write_sample(file, 0, 0, none | {"point_status": np.full(3, STEADY)})  # highest
    found = survey(file)
    assert (found.lowest, found.highest) == (0, 1)
    still = np.zeros((2, 3)), np.full((2, 3), STEADY), np.zeros((2, 3), int)
    assert list(of_points(file.config, *still, TIME_KEY)) == []


def test_tuned_runs_too_few_for_an_interval_of_their_median_are_told(file):
    for n, told in ((5, True), (6, False)):
        values = {"tuned/run_peaks_m": RUNS[:n], "tuned/reference_amplitude_m": 0.03}
        fake = type("Fake", (dict,), {"config": file.config, "read": dict.get})(values)
        assert ("few tuned runs" in str(list(findings._reference(fake)))) == told


def test_inspect_tells_what_an_unfinished_study_has_found(file, capfd):
    """As the study would: verdict, percentiles of the disks so far, and limits."""
    file.write({"samples/status": 0}, (1, 1))
    file.close()
    assert inspect.main([str(file.path)]) == 0
    printed = " ".join(capfd.readouterr().out.split())
    assert "done: 3 of 4 samples" in printed
    assert "Verdict: not usable: 1 of 3 peaks" in printed
    assert "Percentiles of contact amplifications and linear amplifications, and" in printed
    assert "±4 % 35 mm 1 0 0 % 0 to 98 %" in printed


@pytest.mark.parametrize("check", ["half_step", "followed"])
def test_a_check_is_said_beside_what_was_asked(file, check):
    """The share that is printed is that of the file's own numbers; a large one is no result."""
    text = TINY.replace("checked_samples: 0", "checked_samples: 1")
    config = Config.from_yaml(text).replace({"output": str(file.path) + "2"})
    lay_out(config.output, config)
    weights = []
    for change in (0.01, 0.1, -0.3):
        with studies.open_result(config.output, mode="r+") as found:
            tuned = {"peak_amplitude_m": 0.03, f"{check}_peak_m": 0.03 * (1.0 + change)}
            own = {"peak_amplitude_m": 0.02, f"{check}_peak_m": 0.02, "status": DONE}
            contact_file.write_tuned(found, tuned)
            contact_file.write_sample(found, 1, 0, own)
            moves = findings.check_moves(found, check)
            np.testing.assert_allclose(moves, [change, 0.0], atol=1e-12)
            (line,) = findings._checks(found)
        weights.append(line.severity)
        low, high = sorted((100 * change, 0.0))
        assert f"1 sample by {low:+.1f} to {high:+.1f} %" in line.advice
    assert weights == [REMARK, SINGLE, USELESS]
    percent = [limits.percent(share) for share in (0.0, 0.0042, 0.16, 0.997, 1.165)]
    assert percent == ["0", "0.42", "16", "100", "116"]


FOUR_BLADES = {
    "disk.n_blades": 4, "disk.blade.n_elements": 1, "disk.blade.thickness_mm": 14.7,
    "disk.blade.lean_deg": -43.7, "reduction.n_modes": 12, "material.damping_ratio": 0.0164,
    "casing.n_bumps": 2, "casing.bump_height_mm": 0.42, "casing.clearance_mm": 0.15,
    "contact.friction": 0.0, "speeds.from_hz": 94.5, "speeds.to_hz": 94.5,
    "steady_state.min_correlation": 0.9999, "steady_state.max_amplitude_change": 1e-3,
    "steady_state.max_time_s": 2.0, "mistuning.half_range_percent": [1.0],
    "mistuning.samples": 1, "mistuning.tuned_runs": 1, "convergence.step": 1,
}  # fmt: skip
SPRINGS = {"contact.law": "elastic", "contact.casing_stiffness_n_per_m": 1e8}
COARSEST = {"time.steps_per_bump_width": 12, "time.steps_per_period": 16, "time.step_s": 1e-3}


@pytest.mark.parametrize(
    ("keys", "holds"), [({}, True), (SPRINGS, True), (COARSEST, False), (SPRINGS | COARSEST, False)]
)
def test_the_default_step_holds_and_one_that_does_not_is_marked(tmp_path, monkeypatch, keys, holds):
    """On rigid bumps and on springs; truth: the tuned disk at an eighth of the default step."""
    monkeypatch.setattr(second_order, "matters", lambda *_: False)  # two kernels less to compile
    config = Config().replace(FOUR_BLADES | keys | {"output": str(tmp_path / "a.h5")})
    fine = config.replace({"time.step_s": Config().replace(FOUR_BLADES).step / 8.0})
    (truth,) = swept(fine).amplitude
    (tmp_path / "a.yaml").write_text(config.to_yaml())
    assert run_here(tmp_path / "a.yaml") == 0
    with open_result(config.output) as found:
        error = found.read("tuned/peak_amplitude_m") / truth - 1.0
        moved = findings.check_moves(found, "half_step")[0]
        said = f"{findings.verdict(found).words} {found.attributes.get('warnings', '')}"
    assert (abs(error) < 0.01) == (abs(moved) < 0.01) == holds
    marked = "half the step moves peaks" in said or "a blade springs back from" in said
    assert marked == (not holds)


def test_a_disk_is_followed_as_a_study_with_longer_times_does(tmp_path, monkeypatch):
    """The first check of the paper's rule comes too early, and says nothing of the time after."""
    monkeypatch.setattr(second_order, "matters", lambda *_: False)  # a kernel less to compile
    keys = FOUR_BLADES | {"steady_state.rule": "last_window", "speeds.from_hz": 93.5}
    config, peaks = Config().replace(keys), {}
    for factor in (1, 4):
        times = {"steady_state.first_check_s": 0.02 * factor, "steady_state.max_time_s": factor}
        own = config.replace(times | {"output": str(tmp_path / f"{factor}.h5")})
        (tmp_path / f"{factor}.yaml").write_text(own.to_yaml())
        assert run_here(tmp_path / f"{factor}.yaml") == 0
        with open_result(own.output) as found:
            names = "peak_amplitude_m", "followed_peak_m"
            peaks[factor] = [found.read(f"tuned/{name}") for name in names]
    assert peaks[1][1] == peaks[4][0] != peaks[1][0]


@pytest.mark.parametrize("runs", [RUNS, np.append(RUNS, np.nan)])
def test_the_reference_is_as_uncertain_as_the_median_of_the_runs_with_a_result(runs):
    file = File(TINY, tuned__run_peaks_m=runs, tuned__reference_amplitude_m=0.03)
    low, high = np.ravel(percentile_interval(RUNS, [50.0], 1.96))
    assert 0.03 / low > 1.0 > 0.03 / high
    np.testing.assert_allclose(shared_uncertainty(file), [1.0 - 0.03 / high, 0.03 / low - 1.0])


def test_limits_have_a_probability_with_its_interval(file):
    """Two of two: with 0.16 or more, since 0.16² = 0.025; none of two: with 0.84 or less."""
    table, basis = limits.chance_table(file, usable=True)
    assert [*zip(*(column.cells for column in table.columns), strict=True)] == [
        ("±2 %", "35 mm", "2", "2", "100 %", "16 to 100 %"),
        ("±2 %", "10000 MPa", "2", "0", "0 %", "0 to 84 %"),
        ("±4 %", "35 mm", "2", "0", "0 %", "0 to 84 %"),
        ("±4 %", "10000 MPa", "2", "0", "0 %", "0 to 84 %"),
    ]
    assert basis == "limit: 10000 MPa without the rotation's stress"
    assert "sign" not in table.title
    assert "not to be signed" in next(limits.chance_table(file, usable=False)).title
    first, second = limits.limit_lines(file, usable=True)
    assert first.startswith("±4 %: 0 of 2 disks exceed 35 mm, a probability of 0 to 84 %")
    assert "exceed 10000 MPa without the rotation's stress, a" in second
    for line in limits.limit_lines(file, usable=False):
        assert line.endswith("not to be signed, the verdict says why")
    (line,) = limits.largest_line(file, survey(file))
    assert line == "largest amplitude of all samples: 50 mm; largest stress: 2,000 MPa"
    contact_file.write_sample(file, 1, 1, {"status": FAILED})
    first, _ = limits.limit_lines(file, usable=True)
    assert "±4 %: 1 of 2 disks exceed 35 mm or have no result, a probability of 1.3 to 99" in first
    table, _ = limits.chance_table(file, usable=True)
    assert list(table.columns[3].cells)[2] == "1 (1 without result)"


@pytest.mark.parametrize(
    ("peak", "status", "does"),
    [(0.04, DONE, "exceeds 35 mm"), (0.03, DONE, "does not exceed 35 mm"),
     (np.nan, FAILED, "has no result")],
)  # fmt: skip
def test_the_one_disk_of_a_pattern_has_no_probability(peak, status, does):
    """One disk of one was said to exceed a limit with a probability of 2.5 to 100 %."""
    text = f"{PHYSICS}{PATTERN}contact: {{law: abradable}}\nlimits: {{amplitude_mm: 35}}\n"
    found = File(
        text, half_range=[0.024], samples__status=np.array([[status]]),
        samples__peak_amplitude_m=np.array([[peak]]), tuned__run_deepest_m=np.array([1e-3]),
        samples__deepest_m=np.array([[2e-3 if status == DONE else np.nan]]),
    )  # fmt: skip
    assert list(limits.limit_lines(found, usable=True)) == [f"the disk of the pattern {does}"]
    depths = list(WEAR.lines(found, 0))[1:]
    cuts = "the disk of the pattern: cut 2 mm deep at the median, 2 mm at most; 0 of 1 cut through"
    assert depths == [f"{cuts} the coating"] * (status == DONE)


def test_a_disk_is_as_severe_as_the_limit_that_it_exceeds_most():
    config = Config.from_yaml("limits: {amplitude_mm: 10, stress_mpa: 100}")
    found = limits.severity(config, np.array([5e-3, 2e-2, np.nan]), np.array([2e8, 5e7, 1e8]))
    np.testing.assert_allclose(found, [2.0, 2.0, np.nan])


def test_a_stress_by_a_factor_says_on_what_it_rests(file):
    """20 to 30 mm at ±2 %, 30 to 50 mm at ±4 %, by 40 MPa/mm; half of 2,400 MPa is left."""
    keys = {"limits.stress_mpa": 2400.0, "limits.stress_mpa_per_mm": 40.0}
    config = file.config.replace(keys).replace({"limits.amplitude_mm": None})
    scaled = SimpleNamespace(config=config, read=file.read)
    factor = "(if it moves in the mode for which 40 MPa/mm holds)"
    (high,) = limits.limit_lines(scaled, usable=True)
    assert f"0 of 2 disks exceed 2400 MPa without the rotation's stress {factor}, a" in high
    goodman = config.replace({"limits.static_mpa": 300.0, "limits.strength_mpa": 600.0})
    scaled.config = goodman
    assert goodman.limits.stress == pytest.approx(1.2e9)
    first, *_ = limits.limit_lines(scaled, usable=True)
    assert "which 300 MPa of the rotation leave of 2400 MPa" in first
    (line,) = limits.largest_line(scaled, survey(file))
    assert line == f"largest amplitude of all samples: 50 mm; largest stress: 2,000 MPa {factor}"


COATED = (
    TINY.replace("34.0, to_hz: 34.4", "35.6, to_hz: 36.0").replace("n_modes: 12", "n_modes: 60")
    + "casing: {bump_height_mm: 0.5}\ncontact: {law: abradable}\nlimits: {stress_mpa: 500}\n"
    + "output: coated.h5\n"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder of a finished study."""
    folder = tmp_path_factory.mktemp("coated")
    (folder / "coated.yaml").write_text(COATED, encoding="utf-8")
    assert run_here("coated.yaml", folder=folder) == 0
    return folder


@pytest.fixture
def coated(folder):
    """Its open result coated."""
    with open_result(folder / "coated.h5") as coated:
        yield coated


def test_the_largest_of_every_disk_are_those_of_its_points(coated):
    for name, of in (("deepest_m", "worn_depth_m"), ("peak_amplitude_m", "largest_amplitude_m")):
        largest = coated.read(f"samples/{of}").max(axis=2)
        assert np.array_equal(coated.read(f"samples/{name}"), largest)
    at = coated.read("speeds_hz")[coated.read("samples/worn_depth_m").argmax(axis=2)]
    assert np.array_equal(coated.read("samples/deepest_speed_hz"), at)
    assert coated.read("tuned/run_deepest_m")[0] == coated.read("tuned/worn_depth_m").max()


@pytest.mark.parametrize("kind", [AMPLIFICATION, LINEAR, *WEAR.kinds], ids=lambda kind: kind.name)
def test_percentiles_of_all_kinds_have_intervals_and_convergence(coated, kind):
    for level, values in enumerate(coated.read(f"samples/{kind.of}")):
        arguments = values, [1, 50, 99], 1, 2.81
        expected = running_percentiles(*arguments)._asdict()
        for key in expected:
            stored = coated.read(kind.dataset(key), level)
            np.testing.assert_array_equal(stored, expected[key])


def test_depths_of_a_level_stand_beside_those_of_the_tuned_disk(folder, coated, capfd):
    groups = [coated.read("tuned/run_deepest_m"), *coated.read("samples/deepest_m")]
    found = list(WEAR.lines(coated, 0))
    for line, depth in zip(found, groups, strict=True):
        middle, most = 1e3 * np.median(depth), 1e3 * depth.max()
        assert f"cut {middle:.3g} mm deep at the median, {most:.3g} mm at most; 0 of" in line
    for line in found[1:]:  # by the binomial distribution: (1 − p)² = 2.5 %, where none of two does
        assert f"a share of 0 to {100 * (1 - np.sqrt(0.025)):.0f} %" in line
    assert inspect.main([str(folder / "coated.h5")]) == 0
    printed = " ".join(capfd.readouterr().out.split())
    assert all(line in printed for line in found)
    assert summary.interval_table(coated, WEAR.kinds).row_count == 6


def test_disks_that_have_cut_through_are_counted(coated, monkeypatch):
    """As if the coating had been as thin as the disk of a level that cuts less has cut."""
    depths = coated.read("samples/deepest_m")
    monkeypatch.setattr("hpcrub.model.coating.Coating.worn_through", depths[1].min())
    low, high = probability_interval(2, 2, 1.96)
    line = list(WEAR.lines(coated, 0))[-1]
    assert f"2 of 2 cut through the coating, a share of {100 * low:.0f} to 100 %" in line
    runs = coated.read("tuned/run_deepest_m")
    through = np.count_nonzero(np.append(runs, depths) >= depths[1].min())
    assert (
        f"{through} of 13 disks and runs of the tuned one cut through the coating"
        in findings.verdict(coated).words
    )


def test_what_is_said_is_of_the_largest_amplitude_of_any_time(coated):
    """And of peaks that still wear, not of windows in the end."""
    found = survey(coated)
    assert found.largest == coated.read("samples/peak_amplitude_m").max()
    left = found.peaks[NOT_STEADY] - found.growing
    verdict, *advice = findings.verdict(coated).lines
    assert f"{left} of 4 peaks have not settled" in verdict
    assert any(f"{left} of 4 peaks" in line and "may cut deeper" in line for line in advice)
    assert not any("means" in line for line in advice)


def test_energy_of_the_disks_that_cut(folder, monkeypatch):
    """With what their wear has taken, as in the contact study that it starts from."""
    monkeypatch.chdir(folder)
    text = COATED.replace("coated.h5", "energy.h5")
    text += "study: energy\nsources: [coated.h5]\nenergy: {samples: 3}\n"
    (folder / "energy.yaml").write_text(text, encoding="utf-8")
    assert run_here("energy.yaml") == 0
    coated, source = open_result("energy.h5"), open_result("coated.h5")
    level, number = coated.read("level"), coated.read("number")
    taken = source.read("samples/wear_energy_j")[level, number]
    assert taken.min() > 0.0
    assert np.array_equal(coated.read("wear_energy_j"), taken)
    assert np.array_equal(coated.read("tuned/wear_energy_j"), source.read("tuned/wear_energy_j"))
    assert (coated.read("energy_j") > 0.0).all()
    *_, drawn = plot.energy(coated)
    found = np.concatenate([line.get_ydata() for line in drawn.lines])
    np.testing.assert_array_equal(np.sort(found), np.sort(taken.max(axis=1)))
    assert any(line.startswith("wear takes ") for line in energy.STUDY.report(coated))
