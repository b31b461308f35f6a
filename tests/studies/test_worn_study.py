"""A contact study on a coating: its statistics, what it says of depths, and how far to trust it."""

import numpy as np
import pytest

from hpcrub import plot
from hpcrub.commands import inspect
from hpcrub.contact.status import NOT_STEADY
from hpcrub.statistics.percentiles import running_percentiles
from hpcrub.studies import energy, open_result
from hpcrub.studies.contact import depths, summary, trust
from hpcrub.studies.contact.layout import KINDS
from tests.program import TINY, run_here

COATED = (
    TINY.replace("34.0, to_hz: 34.4", "35.6, to_hz: 36.0").replace("n_modes: 12", "n_modes: 60")
    + "casing: {bump_height_mm: 0.5}\ncontact: {law: abradable}\noutput: coated.h5\n"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder of a finished study."""
    folder = tmp_path_factory.mktemp("coated")
    (folder / "coated.yaml").write_text(COATED, encoding="utf-8")
    assert run_here("coated.yaml", folder=folder) == 0
    return folder


@pytest.fixture
def file(folder):
    """Its open result file."""
    file = open_result(folder / "coated.h5")
    yield file
    file.close()


def test_the_largest_of_every_disk_are_those_of_its_points(file):
    for name, of in (("deepest_m", "worn_depth_m"), ("peak_amplitude_m", "largest_amplitude_m")):
        largest = file.read(f"samples/{of}").max(axis=2)
        assert np.array_equal(file.read(f"samples/{name}"), largest)
    at = file.read("speeds_hz")[file.read("samples/worn_depth_m").argmax(axis=2)]
    assert np.array_equal(file.read("samples/deepest_speed_hz"), at)
    assert file.read("tuned/run_deepest_m")[0] == file.read("tuned/worn_depth_m").max()


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_percentiles_of_all_kinds_have_intervals_and_convergence(file, kind):
    for level, values in enumerate(file.read(f"samples/{kind.of}")):
        arguments = values, [1, 50, 99], 1, 2.81
        expected = running_percentiles(*arguments)._asdict()
        for key in set(expected) - {"samples_seen"}:
            stored = file.read(f"statistics/{kind.name}/{key}", level)
            np.testing.assert_array_equal(stored, expected[key])


def test_the_worst_disk_is_compared_with_the_tuned_one(folder, file):
    tuned, deepest = file.read("tuned/run_deepest_m"), file.read("samples/deepest_m").max(axis=1)
    found = list(depths.lines(file))
    assert len(found) == 3
    for line, depth in zip(found[1:], deepest, strict=True):
        ratio = depth / np.median(tuned)
        assert f"cuts {1e3 * depth:.3g} mm deep, {ratio:.2f} times the tuned one" in line
        # by the binomial distribution: (1 − p)² = 2.5 %, when none of two was deeper
        assert f"below {100 * (1 - np.sqrt(0.025)):.2g} %" in line
    printed = list(inspect.description(str(folder / "coated.h5")))
    assert [line.strip() for line in printed if line.strip() in found] == found
    assert summary.coating_table(file).row_count == 6


def test_disks_that_have_cut_through_are_counted(file, monkeypatch):
    """As if the coating had been as thin as the median disk has cut."""
    least = float(np.median(file.read("samples/deepest_m")))
    monkeypatch.setattr("hpcrub.model.coating.Coating.worn_through", least)
    assert list(depths.lines(file))[-1].startswith("2 of 4 disks cut through the coating")


def test_what_is_said_is_of_the_largest_amplitude_of_any_time(file):
    """And of the share of points that still wear, not of windows in the end."""
    found = trust.survey(file)
    assert found.largest == file.read("samples/peak_amplitude_m").max()
    left = (file.read("samples/point_status") == NOT_STEADY).mean()
    (ended, *rest) = trust.lines(file)
    assert ended.startswith(f"{100 - 100 * left:.0f} % of the points have ended")
    assert not any("averaged peaks" in line for line in rest)


def test_energy_of_the_disks_that_cut(folder, monkeypatch):
    """With what their wear has taken, as in the contact study that it starts from."""
    monkeypatch.chdir(folder)
    text = COATED.replace("coated.h5", "energy.h5")
    text += "study: energy\nsources: [coated.h5]\nenergy: {samples: 3}\n"
    (folder / "energy.yaml").write_text(text, encoding="utf-8")
    assert run_here("energy.yaml") == 0
    file, source = open_result("energy.h5"), open_result("coated.h5")
    level, number = file.read("level"), file.read("number")
    taken = source.read("samples/wear_energy_j")[level, number]
    assert taken.min() > 0.0
    assert np.array_equal(file.read("wear_energy_j"), taken)
    assert np.array_equal(file.read("tuned/wear_energy_j"), source.read("tuned/wear_energy_j"))
    assert (file.read("energy_j") > 0.0).all()
    *_, drawn = plot.energy(file)
    np.testing.assert_array_equal(drawn.lines[0].get_ydata(), taken.max(axis=1))
    assert any(line.startswith("wear takes ") for line in energy.report(file))
