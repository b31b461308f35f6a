"""A small probability by double sampling: beside brute force, on ranks, after a stop."""

import re
import shutil

import h5py
import numpy as np
import pytest

from hpcrub import plot
from hpcrub.config.schema import Config
from hpcrub.setup.disks import deviation
from hpcrub.statistics.percentiles import probability_interval
from hpcrub.studies import open_result, rare
from tests.plot.drawn import lines
from tests.program import TINY, contents, datasets, load, run_here
from tests.studies.common import (
    assert_two_ranks_give,
    largest_amplitudes,
    lines_of_progress,
    refused_study,
)

N = 200
STUDY = (
    TINY.replace("samples: 2", f"samples: {N}").replace("[2, 4]", "[4]")
    + """\
study: rare
limits: {amplitude_mm: 10, probability_error: 0.2}
"""
)
REFUSED = {
    "limits.probability_error=null": "limits.probability_error or limits.probability_below",
    "limits.probability_error=0": "limits.probability_error",
    "limits.probability_below=1.5": "limits.probability_below",
    "limits.amplitude_mm=null": "a rare study needs limits.amplitude_mm or limits.stress_mpa",
    "mistuning.half_range_percent=[1, 2]": "a rare study is of one level",
    "part.samples=[0, 10]": "only a contact study can be computed in parts, not rare",
}


@pytest.fixture(scope="module")
def brute(tmp_path_factory):
    """Folder with the input, its limit exceeded by one of five, and the peaks of all disks.

    A first look is made cheap, so that it is taken: nine checks later a motion has ended.
    """
    folder = tmp_path_factory.mktemp("rare")
    peaks = largest_amplitudes(Config.from_yaml(STUDY), range(N))
    limit = round(1e3 * float(np.quantile(peaks, 0.8)), 3)
    (folder / "study.yaml").write_text(STUDY.replace("_mm: 10", f"_mm: {limit}"))
    return folder, peaks, limit / 1e3


@pytest.fixture(scope="module")
def sampled(brute):
    """The result of one rank, with a first look that costs nothing."""
    folder, *_ = brute
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rare, "costs", lambda file, speeds: (0.01 * len(speeds), 10.0))
        assert run_here("study.yaml", "--output", "one.h5", folder=folder) == 0
    return folder / "one.h5"


def test_every_disk_computed_is_that_of_brute_force_and_the_interval_holds_it(brute, sampled):
    _, peaks, limit = brute
    with h5py.File(sampled, "r") as file:
        names = "computed", "inclusion", "look", "peak_amplitude_m", "n_disks", "probability"
        computed, inclusion, look, found, n_disks, chance = (file[name][()] for name in names)
        low, high = (file[f"probability_{end}"][()] for end in ("low", "high"))
    known = np.isfinite(chance)
    n = n_disks[known][-1]
    computed = computed[:n] == 1
    np.testing.assert_array_equal(found[:n][computed], peaks[:n][computed])
    assert np.isnan(found[:n][~computed]).all()
    assert 100 < np.count_nonzero(computed) < n
    assert np.isfinite(look[:n]).all()
    assert (inclusion[:100] == 1.0).all()
    assert (inclusion[100:n] < 1.0).any()
    weighted = ((found[:n] > limit) & computed) / inclusion[:n]
    np.testing.assert_allclose(chance[known][-1], weighted.mean(), rtol=1e-12)
    truth = probability_interval(int((peaks > limit).sum()), N, 1.96)
    assert low[known][-1] < truth[1]
    assert high[known][-1] > truth[0]


@pytest.mark.mpi
def test_two_ranks_and_a_stop_give_the_same_bits(brute):
    folder, *_ = brute
    options = "--set", "mistuning.samples=130"
    assert run_here("study.yaml", "--output", "a.h5", *options, folder=folder) == 0
    n_done = assert_two_ranks_give(datasets(folder / "a.h5"), folder, *options)
    assert n_done == np.count_nonzero(contents(folder / "two.h5")["status"])


def test_a_stop_changes_no_bit(brute, sampled, monkeypatch):
    folder, *_ = brute
    first = datasets(sampled)
    monkeypatch.setattr(rare, "costs", lambda file, speeds: (0.01 * len(speeds), 10.0))
    with h5py.File(sampled, "r+") as file:  # as if it had been stopped on its way
        for name in ("look", "peak_amplitude_m", "inclusion", "time_s"):
            file[name][140:] = np.nan
        for name in ("status", "computed", "peak_status"):
            file[name][140:] = 0
        for name in rare.ESTIMATE:
            file[name][1:] = np.nan
    assert run_here("study.yaml", "--output", "one.h5", "--resume", folder=folder) == 0
    assert datasets(sampled) == first


def test_the_time_left_is_told_once_the_pilot_tells_how_many_disks_are_needed(brute, capsys):
    """It was told for all samples, "at most hours", of which a goal may need a few."""
    options = "--output", "soon.h5", "--set", "limits.probability_error=0.4"
    told = lines_of_progress(brute[0], capsys, *options)
    assert 100 < len(told) < N
    assert not any("left" in line for line in told[:100])
    expected = int(re.search(r" of about (\d+) \(at most 200\), about .* left", told[100])[1])
    assert 0.5 < expected / len(told) < 2.0
    with h5py.File(brute[0] / "soon.h5", "r+") as file:  # as if it had been stopped there
        file["status"][101:] = 0
        file["probability"][1:] = np.nan
    assert run_here("study.yaml", *options, "--status", folder=brute[0]) == 75
    assert f"101 of about {expected} disks (at most 200)" in capsys.readouterr().out


@pytest.mark.parametrize("size", [np.nan, 0.0])
def test_disks_without_a_result_or_that_do_not_touch_have_a_figure(sampled, tmp_path, size):
    shutil.copy(sampled, tmp_path / "lost.h5")
    with open_result(tmp_path / "lost.h5", mode="r+") as file:
        file.write({"peak_amplitude_m": np.full(N, size)}, ())
        tail = plot.rare(file)[1]
        assert bool(lines(tail)) == np.isfinite(size)
        told = any("disks have no result" in finding.why for finding in rare.STUDY.findings(file))
        assert told == np.isnan(size)


def test_the_draws_are_uniform_and_depend_on_seed_and_sample_alone(brute):
    config = load(brute[0] / "study.yaml")
    found = np.array([rare.drawn(config, sample) for sample in range(2000)])
    assert abs(found.mean() - 0.5) < 4 / np.sqrt(12 * 2000)
    assert found.min() < 0.01 < 0.99 < found.max() < 1.0
    stiffness = [deviation(config, 0, sample)[0] for sample in range(N)]
    assert abs(np.corrcoef(found[:N], stiffness)[0, 1]) < 4 / np.sqrt(N)


@pytest.mark.parametrize("override", REFUSED)
def test_what_has_no_probability_is_refused(folder, override, capsys):
    assert REFUSED[override] in refused_study(folder, STUDY, override, capsys)


def test_one_pattern_is_refused():
    pattern = STUDY.replace("half_range_percent: [4]", f"pattern: {list(range(12))}")
    config = Config.from_yaml(pattern)
    assert any("one pattern has no probability" in line for line in rare.STUDY.problems(config))
