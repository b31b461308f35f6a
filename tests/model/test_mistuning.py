"""Draws: functions of (seed, level, sample) alone, uniform or of another law.

The bits are those of Philox 4x64-10 (Salmon et al. 2011), written here once more and checked by
the known answer that its authors publish; sigma = 2 dE / sqrt(12) is equation (4). Other laws are
held against scipy's, and against the given blades.
"""

import numpy as np
import pytest
from scipy.special import ndtri
from scipy.stats import kstest, truncnorm
from scipy.stats import uniform as uniform_law

from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.model.mistuning import Law, stiffness_deviation
from hpcrub.setup.disks import deviation, sigma_of
from hpcrub.setup.problem import build_problem
from hpcrub.studies.contact.amplification import tuned_run


def draws(seed, level, samples, *law, half_range=0.04):
    return np.array([stiffness_deviation(seed, level, s, 12, half_range, *law) for s in samples])


def philox(counter, key):
    """Four words of 64 bits of Philox 4x64 with ten rounds, as its authors describe it."""
    word = 2**64
    for _ in range(10):
        left, right = counter[0] * 0xD2E7470EE14C6C93, counter[2] * 0xCA5A826395121157
        counter = [
            (right // word) ^ counter[1] ^ key[0],
            right % word,
            (left // word) ^ counter[3] ^ key[1],
            left % word,
        ]
        key = [(key[0] + 0x9E3779B97F4A7C15) % word, (key[1] + 0xBB67AE8584CAA73B) % word]
    return counter


def test_philox_here_has_the_known_answer():
    known = [0x16554D9ECA36314C, 0xDB20FE9D672D0FDC, 0xD7E772CEE186176B, 0x7E68B68AEC7BA23B]
    assert philox([0] * 4, [0] * 2) == known


@pytest.mark.parametrize("place", [(2020, 3, 4999), (2**64 + 5, 0, 2**64 - 1)])
def test_a_draw_is_its_place_through_philox(place):
    """Seed: key; level and sample: upper words of the counter, which counts from 1; 53 bits."""
    seed, level, sample = place
    key = [seed % 2**64, seed >> 64]
    words = [w for n in (1, 2, 3) for w in philox([n, 0, sample, level], key)]
    expected = [2 * (w >> 11) * 2.0**-53 - 1 for w in words]
    np.testing.assert_array_equal(stiffness_deviation(*place, 12, 1.0), expected)
    few = stiffness_deviation(*place, 5, 0.25)
    np.testing.assert_array_equal(few, np.array(expected[:5]) / 4)


N, HALF = 2000, 0.04


def drawn(law):
    """Deviations (N, 12) of many samples."""
    return draws(7, 1, range(N), law)


@pytest.mark.parametrize("truncation", [1.0, 3.0])
def test_a_normal_law_is_scipys_truncated_one(truncation):
    law = Law("normal", truncation)
    true = truncnorm(-truncation, truncation, scale=HALF / truncation)
    found = drawn(law)
    assert np.abs(found).max() <= HALF
    assert kstest(found.ravel(), true.cdf).pvalue > 1e-3
    assert HALF * law.sigma == pytest.approx(true.std(), rel=1e-12)


def test_a_normal_law_that_is_cut_off_early_is_uniform():
    """To the order t²/15 of exp(-x²/2) within t; sigma was no number with 1e-7."""
    for t in (1e-7, 1e-3, 1e-2):
        law = Law("normal", t)
        assert law.sigma == pytest.approx((1.0 - t**2 / 15.0) / np.sqrt(3.0), rel=t**4 + 1e-14)
    np.testing.assert_allclose(drawn(Law("normal", 1e-3)), drawn(Law()), rtol=1e-6, atol=1e-12)
    with pytest.raises(InputError, match=r"mistuning.truncation: 1e-07 .* from 0.001 up to 8"):
        Config(mistuning={"distribution": "normal", "truncation": 1e-7})


def test_measured_blades_are_drawn_with_equal_chances():
    blades = 0.01, -0.02, 0.005, 0.0
    law = Law("measured", measured=blades)
    found, counts = np.unique(drawn(law).ravel() / HALF * 0.02, return_counts=True)
    np.testing.assert_allclose(found, sorted(blades), atol=1e-15)
    assert np.abs(counts - N * 12 / 4).max() < 5 * np.sqrt(N * 12 * 3 / 16)
    assert HALF * law.sigma == pytest.approx(2 * np.std(blades), rel=1e-12)


@pytest.mark.parametrize("correlation", [0.3, 0.9])
def test_neighbours_are_correlated_and_each_blade_is_still_uniform(correlation):
    found = drawn(Law(neighbour_correlation=correlation))
    assert kstest(found[:, 5], uniform_law(-HALF, 2 * HALF).cdf).pvalue > 1e-3
    scores = ndtri((found / HALF + 1) / 2)
    for apart in (1, 2, 11):  # the last blade is a neighbour of the first
        expected = correlation ** min(apart, 12 - apart)
        measured = np.corrcoef(scores[:, 0], scores[:, apart])[0, 1]
        assert measured == pytest.approx(expected, abs=5 * (1 - expected**2) / np.sqrt(N))


def test_an_intentional_pattern_lies_beneath():
    plain, both = drawn(Law()), drawn(Law(intentional=(0.03, -0.03)))
    np.testing.assert_allclose(both - plain, np.tile([0.03, -0.03], (N, 6)), atol=1e-15)


def test_the_input_says_which_law():
    text = "mistuning: {distribution: normal, truncation: 2, intentional_percent: [5, -5, 0]}"
    config = Config.from_yaml(text)
    law = Law("normal", 2.0, intentional=(0.05, -0.05, 0.0))
    for level, half in enumerate((0.01, 0.02, 0.03, 0.04)):
        expected = stiffness_deviation(2020, level, 3, 12, half, law)
        np.testing.assert_allclose(deviation(config, level, 3), expected, rtol=1e-15)
    # the variances of independent parts add up, for all blades of many disks together
    pattern = np.std([0.05, -0.05, 0.0])
    expected = np.hypot(truncnorm(-2, 2, scale=0.02).std(), pattern)
    assert sigma_of(config)[3] == pytest.approx(expected, rel=1e-12)
    many = draws(2020, 3, range(N), law, half_range=0.04)
    assert many.std() == pytest.approx(expected, rel=0.01)
    assert sigma_of(Config())[3] == pytest.approx(0.04 / np.sqrt(3), rel=1e-15)


def test_a_disk_stays_itself_in_all_its_runs():
    """5,000 runs, the last of which was 15 % stiffer; d_max K bounds what stiffness does to omega.

    A range that n numbers fill evenly has no gap of more than a few n-ths.
    """
    config = Config(
        mistuning={"samples": 5000, "pattern": [0.0, 1.0] * 6, "reference": "symmetric"}
    )
    runs = np.array([deviation(config, 0, sample)[0] for sample in range(5000)])
    np.testing.assert_allclose(runs[:10], 3e-5 * np.arange(10), rtol=1e-12)
    assert runs.max() < 3e-4
    gaps = np.diff([*np.sort(runs), 3e-4])
    assert gaps.min() > 0.0
    assert gaps.max() < 5 * 3e-4 / 5000
    problem = build_problem(Config())
    tuned = config.replace({"mistuning.pattern": None, "mistuning.tuned_runs": 1000})
    first, last = (tuned_run(tuned, problem, run)[0].omega for run in (0, 999))
    assert (last / first).min() > 1.0
    assert (last / first).max() < np.sqrt(1.0 + 3e-4)
    highest = problem.reduced.tuned_eigenvalues[-1]  # a step that only the first run stands
    step = 0.99999 * 2.0 / np.sqrt(1.01 * highest)
    with pytest.raises(InputError, match=r"time.step_s: .* the stability limit"):
        build_problem(config.replace({"time.scheme": "central_difference", "time.step_s": step}))
