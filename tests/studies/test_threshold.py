"""The value of a key that meets a limit: beside brute force, after a stop."""

import re
import shutil

import h5py
import numpy as np
import pytest

from hpcrub.commands import inspect
from hpcrub.config.schema import Config
from hpcrub.ranks.progress import duration
from hpcrub.results.verdict import USELESS
from hpcrub.runs import cost
from hpcrub.statistics.percentiles import probability_interval
from hpcrub.studies import open_result
from hpcrub.studies.contact.trials import beyond
from hpcrub.studies.threshold import STUDY as THRESHOLD
from tests.program import TINY, computed, datasets, load, run_here
from tests.studies.common import (
    largest_amplitudes,
    lines_of_progress,
    refused_study,
)

N = 60
STUDY = (
    TINY.replace("samples: 2", f"samples: {N}").replace("[2, 4]", "[4]")
    + """\
study: threshold
threshold: {key: casing.clearance_mm, lowest: 0.2, highest: 1.4, tolerance: 0.3, probability: 0.4}
limits: {amplitude_mm: 10}
"""
)
REFUSED = {
    "threshold.key=casing.clearance": "casing.clearance: unknown key",
    "threshold.key=limits.amplitude_mm": "limits.amplitude_mm changes no disk",
    "threshold.lowest=2": "threshold.highest: is not above threshold.lowest",
    "limits.amplitude_mm=null": "needs limits.amplitude_mm or limits.stress_mpa",
    "mistuning.half_range_percent=[1, 2]": "a threshold study is of one level",
    "threshold.lowest=-1": "casing.clearance_mm",
    "threshold.key=casing.n_bumps": "casing.n_bumps",
    "threshold.key=mistuning.tuned_runs": "mistuning.tuned_runs changes no disk",
    "casing.clearance_hz_mm=[[30, 0.3], [40, 0.2]]": "it cannot be combined with casing.clear",
    "threshold.tolerance=1e-4": "threshold.tolerance: 0.0001 divides the range into more than 1024",
}


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


def test_every_disk_is_that_of_brute_force_and_the_crossing_is_there(brute):
    folder, peaks, limit = brute
    with h5py.File(folder / "one.h5", "r") as file:
        n, above, found = (file[name][()] for name in ("n_disks", "n_above", "peak_amplitude_m"))
        low, high = file["crossing"][()]
        values, side = file["value"][()], file["side"][()]
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


def test_the_time_left_is_told_for_as_many_disks_as_a_search_takes(brute, capsys):
    """It was told for all disks at all values, "at most hours", where minutes were left."""
    folder, *_ = brute
    shutil.copy(folder / "one.h5", folder / "stopped.h5")
    with h5py.File(folder / "stopped.h5", "r+") as file:
        n = file["n_disks"][()].sum()
        file["status"][0, :5] = 0
    told = lines_of_progress(folder, capsys, "--output", "stopped.h5", "--resume")
    assert len(told) == 5
    for line in told:
        expected = int(re.search(r" of about (\d+) \(at most 300\), about .* left", line)[1])
        assert 0.5 < expected / n < 2.0


def test_what_is_there_is_told_of_the_disks_that_are_expected(brute, capfd):
    """`--status`, `inspect` and a dry run that resumes counted of all disks at all values."""
    folder, *_ = brute
    expected = THRESHOLD.cost(load(folder / "study.yaml")).disks
    shutil.copy(folder / "one.h5", folder / "begun.h5")
    with h5py.File(folder / "begun.h5", "r+") as file:
        file["status"][:, 10:] = 0
        file["n_disks"][:] = 0
        n = np.count_nonzero(file["status"])
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


def test_a_file_is_complete_once_its_answer_is_written_with_whatever_rounding(brute):
    folder, *_ = brute
    shutil.copy(folder / "one.h5", folder / "rounded.h5")
    with open_result(folder / "rounded.h5", mode="r+") as file:
        low = file.read("probability_low")
        file.write({"probability_low": low * (1.0 + 1e-12)}, ())
        assert THRESHOLD.is_enough(file)
        assert not THRESHOLD.next_round(file).tasks
        file.write({"crossing": np.full(2, np.nan)}, ())  # as if killed before
        assert not THRESHOLD.is_enough(file)


def test_disks_without_a_result_count_as_beyond_the_limit_and_are_told(brute):
    folder, *_ = brute
    shutil.copy(folder / "one.h5", folder / "lost.h5")
    with open_result(folder / "lost.h5", mode="r+") as file:
        n = file.read("n_disks")
        file.write({"peak_amplitude_m": np.full(n[0], np.nan)}, (0, slice(n[0])))
        assert beyond(file)[0, : n[0]].all()
        (lost,) = (f for f in THRESHOLD.findings(file) if "no result" in f.why)
    assert lost.why == f"{n[0]} of {n.sum()} disks have no result"
    assert lost.severity == USELESS


@pytest.mark.parametrize("override", REFUSED)
def test_what_cannot_be_searched_for_is_refused(folder, override, capsys):
    assert REFUSED[override] in refused_study(folder, STUDY, override, capsys)


def test_a_dry_run_estimates_with_disks_of_the_whole_range(folder, monkeypatch, capfd):
    """It tried one at the input's own clearance, beside the range, and told a quarter of the time.

    A disk that takes as many seconds as its clearance has millimetres takes 0.8 s on average.
    """
    own = lambda config, *_: cost.Trial(config.casing.clearance_mm)  # noqa: E731
    monkeypatch.setattr(cost, "trial", own)
    (folder / "study.yaml").write_text(STUDY)
    options = "--dry-run", "--set", "casing.clearance_mm=0.1"
    assert run_here("study.yaml", *options, folder=folder) == 0
    said, disks = capfd.readouterr().out, THRESHOLD.cost(Config.from_yaml(STUDY)).disks
    assert f"run time:   {duration(0.8 * disks)} on 1 rank" in said
    assert "one disk takes:       0.2 s to 1.4 s" in said


@pytest.mark.parametrize(
    ("key", "ends", "told"),
    [
        ("casing.clearance_mm", (0.2, 1.4), []),
        ("casing.clearance_mm", (0.2, 12.0), ["2.4 %", "(at casing.clearance_mm = 12)"]),
        ("casing.clearance_mm", (12.0, 30.0), ["2.4 %", "clearance_mm = 12; also at 30)"]),
        ("contact.friction", (0.0, 0.3), ["12 %", "casing.clearance_mm is in mm"]),
    ],
)
def test_what_is_not_plausible_is_told_of_both_ends_of_the_range(folder, key, ends, told, capfd):
    """It was told of the input's own value alone, which is not computed; so was "contact: none"."""
    (folder / "study.yaml").write_text(STUDY)
    keys = {"key": key, "lowest": ends[0], "highest": ends[1], "tolerance": np.ptp(ends)}
    options = [f"--set=threshold.{name}={value}" for name, value in keys.items()]
    options.append("--set=casing.clearance_mm=60")
    assert run_here("study.yaml", "--dry-run", *options, folder=folder) == 0
    said = capfd.readouterr().out
    found = [line for line in said.splitlines() if " units: " in line]
    assert len(found) == bool(told)
    for line in found:
        assert f"the clearance is {told[0]}" in line
        assert line.endswith(told[1])
    assert ("contact:              none" in said) == (ends[0] != 0.2)
