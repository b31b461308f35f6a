"""Rows of the reproduction on made-up results: truth is how these were made."""

import numpy as np
import pytest

from evidence.reproduce import numbers, pattern, rows, sensitivity
from hpcrub.config.schema import Config
from hpcrub.contact.status import STEADY
from hpcrub.results.layout import DONE

RNG = np.random.default_rng(0)
SPEEDS = np.arange(33.5, 35.51, 0.05)


class File:
    """Arrays of a result file by name; an index takes the first axes."""

    def __init__(self, config=None, **data):
        self.data, self.config = data, config

    def read(self, name, at=()):
        return np.asarray(self.data[name.replace("/", "_")])[at]

    def status(self):
        return np.full(self.data["samples_amplification"].shape, DONE)


class Results(rows.Results):
    """Files made up, by pattern."""

    def __init__(self, folder=None, **files):
        super().__init__(folder)
        self.files = files

    def file(self, pattern):
        name = pattern.removeprefix("contact/").split(".h5")[0].rstrip("_*").replace("=", "")
        if name not in self.files:
            raise rows.MissingError(f"no {pattern}")
        return self.files[name]


def one_disk(amplitude, local):
    return File(speeds_hz=SPEEDS, samples_amplitude_m=[[amplitude]], samples_localisation=[[local]])


def test_the_pattern_is_read_at_its_peak_and_at_its_largest_localisation():
    amplitude, local = np.full((2, 41), 0.03)
    amplitude[25], local[25] = 0.0581, 0.49  # 34.75 Hz
    amplitude[3], local[3] = 0.0389, 0.679  # 33.65 Hz
    local[10] = 0.17
    local[local == 0.03] = 0.2
    found = pattern.table2(Results(table2=one_disk(amplitude, local)))
    assert [row.agrees for row in found] == ["yes"] * 6 + ["near"]  # 17 and 67.9, not 65
    assert found[-1].ours == "17.0, 67.9"
    found = pattern.printed_order(Results(table2_printed=one_disk(amplitude, 0.5 * local)))
    assert [row.agrees for row in found] == ["yes", "no"]


def coexisting_file(upper, where):
    """Five starts at 401 speeds, of which two are on another branch within a range of speeds."""
    speeds = np.arange(33.5, 35.5001, 0.005)
    inside = (speeds > where[0]) & (speeds < where[1])
    amplitude, local = np.full((5, 401), 0.05), np.full((5, 401), 0.174)
    amplitude[3:, inside], local[3:, inside] = upper
    noise = RNG.standard_normal((2, 5, 401, 60))
    return File(
        speeds_hz=speeds, point_status=np.full((5, 401), STEADY),
        window_amplitude_m=amplitude[..., None] + 0.001 * noise[0],
        window_localisation=local[..., None] + 0.005 * noise[1],
    )  # fmt: skip


def test_coexistence_where_the_paper_has_it():
    found = pattern.coexistence(Results(branches=coexisting_file((0.06, 0.259), pattern.ZONE)))
    assert [row.agrees for row in found] == ["yes"] * 3
    assert "34.180–34.290" in found[0].ours
    assert [row.ours[:4] for row in found[1:]] == ["17.4", "25.9"]


def test_coexistence_elsewhere_or_nowhere_does_not_agree():
    elsewhere = coexisting_file((0.06, 0.259), (34.6025, 34.7975))
    (row,) = pattern.coexistence(Results(branches=elsewhere))
    assert row.agrees == "no"
    assert "34.605–34.795" in row.ours
    (row,) = pattern.coexistence(Results(branches=coexisting_file((0.05, 0.174), pattern.ZONE)))
    assert row.agrees == "no"
    assert "together: none" in row.ours


@pytest.fixture
def responses(monkeypatch):
    """Responses that differ by chance alone, but with few modes by more."""
    scatter = 0.002 * RNG.standard_normal((5, 41)) + 0.05
    modes = 0.002 * RNG.standard_normal((6, 41)) + 0.05
    modes[0] += 0.02
    found = {
        "time_step": (np.array([1e-6, 2e-6, 5e-6, 1e-5, 2e-5]), scatter),
        "reduction": (np.array([12, 24, 36, 48, 60, 84]), modes),
    }
    monkeypatch.setattr(pattern, "_responses", lambda results, folder, key: found[folder])
    return found


def test_convergence_is_judged_against_the_scatter(responses):
    results = Results(modal=File(reduced_frequencies_hz=np.array([90.0, 8971.0])))
    assert [row.agrees for row in pattern.time_step(results)] == ["yes", "no"]  # 3.55 is not 5
    (row,) = pattern.reduction(results)
    assert row.agrees == "yes"
    responses["reduction"][1][4] += 0.02  # 60 modes are not enough
    (row,) = pattern.reduction(results)
    assert row.agrees == "no"
    responses["time_step"][1][4] += 0.02
    assert pattern.time_step(results)[0].agrees == "no"


def contact(level=1.5, n_samples=2000, peak_mm=65.0):
    """A contact study whose amplifications scatter around a level."""
    shape = 4, n_samples
    amplification = level + 0.05 * RNG.standard_normal(shape)
    return File(
        Config(), samples_amplification=amplification,
        samples_linear_amplification=np.full(shape, 1.4),
        samples_peak_amplitude_m=np.full(shape, 1e-3 * peak_mm),
        samples_peak_speed_hz=np.full(shape, 34.4), sigma=np.arange(4), speeds_hz=SPEEDS,
        tuned_reference_amplitude_m=0.04, tuned_run_peaks_m=np.array([0.039, 0.042]),
        tuned_peak_speed_hz=34.4,
    )  # fmt: skip


def test_damping_that_does_nothing_is_called_so():
    same = Results(n_bumps4=contact(), contact_low=contact())
    first, second = numbers.amplification(same)
    assert first.agrees == second.agrees == "no"
    assert "no effect" in second.remark
    assert "What it depends on" in first.remark
    assert "What it depends on" not in second.remark  # that table has one damping
    other = Results(n_bumps4=contact(), contact_low=contact(1.7))
    assert "an effect" in numbers.amplification(other)[1].remark


def test_rows_that_the_search_used_are_marked():
    files = {f"n_bumps{n}": contact(peak_mm=mm) for n, mm in ((3, 65), (4, 40), (5, 40), (6, 70))}
    tuned, three, six = numbers.amplitudes(Results(**files))
    assert tuned.fitted
    assert not three.fitted
    assert (three.agrees, six.agrees) == ("yes", "no")
    assert all("What it depends on" not in row.remark for row in (tuned, three, six))


def test_peaks_at_an_edge_do_not_agree():
    files = {f"n_bumps{n}": contact() for n in (3, 4, 5, 6)}
    files["n_bumps4"].data["samples_peak_speed_hz"][0, :200] = 33.5
    assert [row.agrees for row in numbers.ranges(Results(**files))] == ["yes", "no", "yes", "yes"]


def test_median_beside_percentile_99_by_the_common_criterion():
    (row,) = numbers.medians(Results(n_bumps4=contact(1.4)))
    assert row.agrees == "yes"
    (row,) = numbers.medians(Results(n_bumps4=contact(1.45)))
    assert row.agrees == "near"


def test_sensitivity_has_the_share_above_the_linear_amplification(tmp_path, monkeypatch):
    (tmp_path / "sensitivity").mkdir()
    made = {}
    for name, lean, level in (("lean_deg=45.41", 45.41, 1.4), ("lean_deg=44.4", 44.4, 1.6)):
        path = tmp_path / "sensitivity" / f"{name}.h5"
        path.touch()
        made[path] = contact(level)
        made[path].config = Config(disk={"blade": {"lean_deg": lean}})
        made[path].path, made[path].close = path, lambda: None
    monkeypatch.setattr(sensitivity.ResultFile, "open", made.get)
    first, second = sensitivity.table(Results(tmp_path)).splitlines()[-2:]
    assert first.startswith("| nothing | 40.0 mm [39.0, 42.0] at 34.40 Hz | 1.40")
    assert second.startswith("| lean_deg 45.41 → 44.4 |")
    assert 45 < float(first.split("|")[-2].split()[0]) < 55
    assert float(second.split("|")[-2].split()[0]) == 100.0
