"""A small probability: beside brute force, after a stop."""

import re
import shutil

import h5py
import numpy as np
import pytest
from scipy.stats import binomtest

from hpcrub import plot
from hpcrub.config.schema import Config
from hpcrub.results.verdict import SINGLE, USELESS
from hpcrub.studies import open_result, rare
from hpcrub.studies.contact.trials import left_for_others
from tests.plot.drawn import lines
from tests.program import BRIEF, contents, datasets, run_here
from tests.studies.common import largest_amplitudes, lines_of_progress, refused_study

N = 150
STUDY = (
    BRIEF.replace("checked_samples: 0", "checked_samples: 1")
    .replace(" samples: 2", f" samples: {N}")
    .replace("[2, 4]", "[4]")
    + """\
study: rare
limits: {amplitude_mm: 10, probability_error: 0.4}
"""
)
REFUSED = {
    "limits.probability_error=null": "limits.probability_error or limits.probability_below",
    "limits.probability_error=0": "limits.probability_error",
    "limits.probability_below=1.5": "limits.probability_below",
    "limits.amplitude_mm=null": "a rare study needs limits.amplitude_mm or limits.stress_mpa",
    "mistuning.half_range_percent=[1, 2]": "a rare study is of one level",
    "part.samples=[0, 10]": "a rare study cannot be computed in parts",
}


@pytest.fixture(scope="module")
def brute(tmp_path_factory):
    """Folder with the input, its limit exceeded by one of five, and the peaks of all disks."""
    folder = tmp_path_factory.mktemp("rare")
    peaks = largest_amplitudes(Config.from_yaml(STUDY), range(N))
    limit = round(1e3 * float(np.quantile(peaks, 0.8)), 3)
    (folder / "study.yaml").write_text(STUDY.replace("_mm: 10", f"_mm: {limit}"))
    return folder, peaks, limit / 1e3


@pytest.fixture(scope="module")
def sampled(brute):
    """The result of one rank."""
    folder, *_ = brute
    assert run_here("study.yaml", "--output", "one.h5", folder=folder) == 0
    return folder / "one.h5"


@pytest.mark.long
def test_it_ends_by_the_first_disks_of_brute_force_that_tell_enough(brute, sampled):
    _, peaks, limit = brute
    found = contents(sampled)
    n = int(np.count_nonzero(found["status"]))
    np.testing.assert_array_equal(found["n_disks"], [100, 130, N])
    assert n < N
    np.testing.assert_array_equal(found["peak_amplitude_m"][:n], peaks[:n])
    assert np.isnan(found["peak_amplitude_m"][n:]).all()
    speeds = Config.from_yaml(STUDY).speeds.values_hz
    assert set(found["peak_speed_hz"][:n]) <= set(speeds)
    for place, n_disks in enumerate((100, 130)):
        result = binomtest(int((peaks[:n_disks] > limit).sum()), n_disks)
        ends, chance = result.proportion_ci(method="exact"), result.statistic
        enough = ends.high - ends.low <= 0.8 * chance
        assert enough == (n == n_disks)
        estimate = [found[name][place] for name in rare.ESTIMATE]
        np.testing.assert_allclose(estimate, (chance, *ends), rtol=1e-4)  # 1.96 is rounded
        if enough:
            break
    assert np.isnan(found["probability"][place + 1 :]).all()


def cut(path, n):
    """Leave the first n disks of a result, as if it had been stopped then."""
    with h5py.File(path, "r+") as file:
        for name in ("peak_amplitude_m", "peak_stress_pa", "peak_speed_hz", "followed_severity"):
            file[name][n:] = np.nan
        for name in ("status", "peak_status"):
            file[name][n:] = 0
        for name in rare.ESTIMATE:
            file[name][file["n_disks"][()] > n] = np.nan


@pytest.mark.long
def test_a_stop_changes_no_bit_and_the_time_left_follows_from_the_last_estimate(
    brute, sampled, capsys
):
    """It was told for all samples, "at most hours", of which a goal may need a few."""
    folder, again = brute[0], brute[0] / "again.h5"
    shutil.copy(sampled, again)
    cut(again, 60)
    assert run_here("study.yaml", "--output", "again.h5", "--status", folder=folder) == 75
    assert f"60 of at most {N} disks" in capsys.readouterr().out
    shutil.copy(sampled, again)
    cut(again, 101)
    assert run_here("study.yaml", "--output", "again.h5", "--status", folder=folder) == 75
    expected = int(re.search(r"101 of about (\d+) disks \(at most", capsys.readouterr().out)[1])
    told = lines_of_progress(folder, capsys, "--output", "again.h5", "--resume")
    assert f" of about {expected} (at most {N}), about " in told[0]
    assert len(told) == np.count_nonzero(contents(sampled)["status"]) - 101
    assert datasets(again) == datasets(sampled)


def test_every_fiftieth_disk_is_followed_longer_to_see_whether_its_motion_stays(sampled):
    """As the study with longer times would; disks that pass the limit then are told."""
    found = contents(sampled)
    (followed,) = np.nonzero(~np.isnan(found["followed_severity"]))
    n = int(np.count_nonzero(found["status"]))
    np.testing.assert_array_equal(followed, range(1, n, 50))
    with open_result(sampled) as file:
        config = file.config
        steady = config.steady_state
        longer = {
            f"steady_state.{name}": 4.0 * getattr(steady, name)
            for name in ("first_check_s", "max_time_s")
        }
        sizes = largest_amplitudes(config.replace(longer), followed)
        severity = sizes / config.limits.amplitude
        np.testing.assert_array_equal(found["followed_severity"][followed], severity)
        before = found["peak_amplitude_m"][followed] > config.limits.amplitude
        assert bool(list(left_for_others(file))) == ((severity > 1.0) != before).any()


@pytest.mark.parametrize(
    ("peaks", "severity", "told", "worth"),
    [
        ([9.0, 9.0, 11.0], [0.9, np.nan, 1.1], None, None),
        ([9.0, 9.0, 11.0], [1.2, np.nan, 1.1], "of 2 disks that were followed four", SINGLE),
        ([9.0, 9.0, 11.0], [0.9, np.nan, 0.9], "only then by 0, and no more by 1", SINGLE),
        ([9.0] * 30, [1.1] + 29 * [0.9], "only then by 1, and no more by 0", SINGLE),
        ([9.0, 11.0], [1.1, 0.9], "only then by 1, and no more by 1", SINGLE),
        ([9.0] * 30, 4 * [1.1] + 26 * [0.9], "only then by 4, and no more by 0", SINGLE),  # 1 in 16
        ([9.0] * 30, 5 * [1.1] + 25 * [0.9], "only then by 5, and no more by 0", USELESS),  # in 32
        ([9.0] * 101, 5 * [1.1] + 96 * [0.9], "only then by 5, and no more by 0", SINGLE),
    ],
)
def test_disks_that_pass_the_limit_when_followed_longer_are_told(peaks, severity, told, worth):
    config = Config.from_yaml(STUDY)
    values = {"peak_amplitude_m": 1e-3 * np.array(peaks), "followed_severity": np.array(severity)}
    values["peak_stress_pa"] = np.full(len(peaks), np.nan)
    file = type("File", (), {"config": config, "read": staticmethod(values.get)})()
    found = list(left_for_others(file))
    assert len(found) == (told is not None)
    for finding in found:
        assert told in finding.advice
        assert finding.severity == worth


@pytest.mark.parametrize("size", [np.nan, 0.0])
def test_disks_without_a_result_or_that_do_not_touch_have_a_figure(sampled, tmp_path, size):
    shutil.copy(sampled, tmp_path / "lost.h5")
    with open_result(tmp_path / "lost.h5", mode="r+") as file:
        file.write({"peak_amplitude_m": np.full(N, size)}, ())
        assert bool(lines(plot.rare(file))) == np.isfinite(size)
        told = any("disks have no result" in finding.why for finding in rare.STUDY.findings(file))
        assert told == np.isnan(size)


def test_the_figure_has_the_probability_at_the_limit_where_all_disks_are_beyond(sampled, tmp_path):
    """It began at the smallest disks, beyond the limit, and had no point at its dotted line."""
    shutil.copy(sampled, tmp_path / "beyond.h5")
    with open_result(tmp_path / "beyond.h5", mode="r+") as file:
        file.write({"peak_amplitude_m": np.linspace(0.02, 0.03, N)}, ())
        chance = lines(plot.rare(file))[0]
    at, probability = np.transpose(chance)
    assert (at[0], probability[0]) == (1.0, 1.0)


@pytest.mark.parametrize(
    ("goal", "told"),
    [
        ("probability_below: 0.01", "below 0.01, even if none of them exceeds the limit; 597 can"),
        ("probability_below: 0.04", ""),
        ("probability_error: 0.01", "tell no probability to limits.probability_error 0.01"),
        ("probability_error: 0.1", ""),
    ],
)
def test_a_goal_that_all_samples_cannot_meet_is_refused_before(goal, told):
    """Without an event a probability of 0.01 is seen at ln(0.0025)/ln(0.99) = 596.2 disks."""
    config = Config.from_yaml(STUDY.replace("probability_error: 0.4", goal))
    found = [line for line in rare.STUDY.problems(config) if line.startswith("mistuning.samples")]
    assert len(found) == bool(told)
    assert told in "".join(found)


@pytest.mark.parametrize(
    "goal", ["probability_below: 0.01", "probability_error: 0.5, probability_below: 0.1"]
)
def test_samples_that_are_not_given_are_as_many_as_the_goal_needs(goal):
    text = f"study: rare\nlimits: {{amplitude_mm: 10, {goal}}}\n"
    config = Config.from_yaml(text)
    assert not [*rare.STUDY.problems(config)]
    assert config.mistuning.half_range_percent == (4.0,)
    n = config.mistuning.samples
    assert n < 50_000
    assert rare.goal_of(config).is_met(rare.supposed(config) * n, n)


@pytest.mark.parametrize("override", REFUSED)
def test_what_has_no_probability_is_refused(folder, override, capsys):
    assert REFUSED[override] in refused_study(folder, STUDY, override, capsys)


def test_a_goal_is_asked_for_before_anything_else():
    """The levels were refused first, which nobody had given."""
    first = next(iter(rare.STUDY.problems(Config.from_yaml("study: rare\n"))))
    assert first.startswith("limits: a rare study ends by")


def test_one_pattern_is_refused():
    pattern = STUDY.replace("half_range_percent: [4]", f"pattern: {list(range(12))}")
    config = Config.from_yaml(pattern)
    assert any("one pattern has no probability" in line for line in rare.STUDY.problems(config))
