"""The trust block of files whose points are made up, and the bending stress at the root."""

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.stats import binom

from evidence.program import TINY
from hpcrub import studies
from hpcrub.config.schema import Config
from hpcrub.contact.status import AVERAGED, NOT_STEADY, STEADY
from hpcrub.errors import InputError
from hpcrub.model.elements import frame_element, rectangular_beam
from hpcrub.model.root_stress import root_stress
from hpcrub.results.layout import DONE
from hpcrub.runs import result_files
from hpcrub.statistics.percentiles import percentile_interval, probability_interval, widened
from hpcrub.studies.contact import file as contact_file
from hpcrub.studies.contact import trust

RUNS = np.array([31.0, 29.0, 30.0, 33.0, 28.0, 30.0, 31.0, 32.0, 30.0]) * 1e-3


@pytest.fixture
def file(tmp_path):
    """Four disks of two levels: peaks at the lowest, the highest and twice the middle speed."""
    config = Config.from_yaml(TINY + "limits: {amplitude_mm: 35, stress_mpa: 1e4}\n")
    config = config.replace({"output": str(tmp_path / "x.h5")})
    result_files.lay_out(config.output, studies.run_of(config))
    sizes = np.array([[40, 30, 20], [10, 20, 50], [28, 30, 29], [10, 30, 12]]) * 1e-3
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
                "peak_amplitude_m": size.max(), "point_status": np.array(state, np.uint8),
            }  # fmt: skip
            contact_file.write_sample(found, i // 2, i % 2, values)
        yield found


def test_peaks_are_counted_by_what_they_are_and_where_they_lie(file):
    found = trust.survey(file)
    assert [found.peaks[s] for s in (STEADY, AVERAGED, NOT_STEADY)] == [1, 2, 1]
    assert (found.lowest, found.highest, found.alone) == (1, 1, 1)
    assert found.points.sum() == 12
    np.testing.assert_allclose(found.averaged, [0.05, 0.07, 0.8])
    assert found.largest == pytest.approx(0.05)
    text = "\n".join(trust.lines(file, found))
    assert "25 % of the peaks steady" in text
    assert "known (0.8 s), and not until it repeats itself" in text
    assert "standard error of 5.0 %, windows that scatter by 7.0 %" in text
    assert "1 of 4 peaks lie at the lowest speed" in text
    assert "speeds.to_hz above 34.4" in text
    assert "at 1 of 4 peaks both neighbouring speeds are more than 10 % lower" in text


def test_the_reference_is_as_uncertain_as_the_median_of_the_tuned_runs(file):
    below, above = trust.shared_uncertainty(file)
    low, high = np.ravel(percentile_interval(RUNS, [50.0], 1.96))
    assert 1.0 - below == pytest.approx(0.03 / high)
    assert 1.0 + above == pytest.approx(0.03 / low)
    assert below > 0.0
    assert above > 0.0


def test_limits_have_a_probability_with_its_interval(file):
    text = "\n".join(trust.lines(file))
    assert "±2 %: 2 of 2 disks exceed 35 mm, a probability of 16 to 1e+02 %" in text
    assert "±4 %: 0 of 2 disks exceed 35 mm" in text
    assert "±2 %: 0 of 2 disks exceed 10000 MPa" in text


def test_stress_of_a_model_file_is_refused():
    with pytest.raises(InputError, match=r"limits.stress_mpa: a model file"):
        Config(disk={"model": "x.h5"}, limits={"stress_mpa": 100.0})
    known = {"stress_mpa": 100.0, "stress_mpa_per_mm": 40.0}
    config = Config(disk={"model": "x.h5"}, limits=known)
    assert trust.stress_per_metre(config) == pytest.approx(40e6 / 1e-3)


@pytest.mark.parametrize(("count", "n"), [(0, 20), (3, 20), (20, 20)])
def test_an_interval_of_a_probability_leaves_the_tails_of_the_binomial(count, n):
    """Its ends are the probabilities for which so few, or so many, are just improbable."""
    low, high = probability_interval(count, n, 1.96)
    if count > 0:
        assert binom.sf(count - 1, n, low) == pytest.approx(0.025, rel=1e-3)
    if count < n:
        assert binom.cdf(count, n, high) == pytest.approx(0.025, rel=1e-3)
    assert low <= count / n <= high


def test_a_shared_uncertainty_adds_in_squares():
    low, high = widened(np.array([2.0]), np.array([1.7]), np.array([2.4]), np.array([0.2, 0.15]))
    assert (low[0], high[0]) == pytest.approx((1.5, 2.5))
    alone = widened(np.array([2.0]), np.array([1.7]), np.array([np.nan]), np.array([np.nan, 0.0]))
    assert alone[0][0] == pytest.approx(1.7)
    assert np.isnan(alone[1][0])


def clamped(beam, length, n):
    """First bending mode of a clamped beam of n elements: across and turned at its first node, and
    across at its end."""
    mass, stiffness = np.zeros((2, 3 * n + 3, 3 * n + 3))
    for e in range(n):
        dof = np.ix_(range(3 * e, 3 * e + 6), range(3 * e, 3 * e + 6))
        of_mass, of_stiffness = frame_element(beam, length / n)
        mass[dof] += of_mass
        stiffness[dof] += of_stiffness
    shape = eigh(stiffness[3:, 3:], mass[3:, 3:], subset_by_index=[0, 0])[1][:, 0]
    return shape[1], shape[2], shape[-2]


def test_root_stress_is_that_of_a_clamped_beam():
    """E t/2 times the curvature at the root, that of the cubic of the first of many elements."""
    config, n = Config(disk={"blade": {"lean_deg": 0.0, "bow": 0.0}}), 40
    disk, modulus = config.disk, config.material.young_modulus
    length = disk.tip_radius - disk.hub_radius
    beam = rectangular_beam(disk.width, disk.blade.thickness, modulus, config.material.density)
    across, turned, tip = clamped(beam, length, n)
    curvature = (6.0 * across - 2.0 * turned * length / n) / (length / n) ** 2
    stress = modulus * disk.blade.thickness / 2.0 * abs(curvature / tip)
    assert root_stress(disk, config.material) == pytest.approx(stress, rel=1e-3)
