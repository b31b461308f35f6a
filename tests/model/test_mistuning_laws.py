"""Distributions of the blades' deviations: against scipy's, and against the given blades.

Whatever the law, draws depend on nothing but their place.
"""

import numpy as np
import pytest
from scipy.special import ndtri
from scipy.stats import kstest, truncnorm
from scipy.stats import uniform as uniform_law

from hpcrub.config.schema import Config
from hpcrub.model.mistuning import Law, stiffness_deviation
from hpcrub.setup.disks import deviation, sigma_of

N, BLADES, HALF = 2000, 12, 0.04


def drawn(law):
    """Deviations (N, BLADES) of many samples."""
    return np.array([stiffness_deviation(7, 1, s, BLADES, HALF, law) for s in range(N)])


@pytest.mark.parametrize("truncation", [1.0, 3.0])
def test_a_normal_law_is_scipys_truncated_one(truncation):
    law = Law("normal", truncation)
    true = truncnorm(-truncation, truncation, scale=HALF / truncation)
    found = drawn(law)
    assert np.abs(found).max() <= HALF
    assert kstest(found.ravel(), true.cdf).pvalue > 1e-3
    assert HALF * law.sigma == pytest.approx(true.std(), rel=1e-12)


def test_measured_blades_are_drawn_with_equal_chances():
    blades = 0.01, -0.02, 0.005, 0.0
    law = Law("measured", measured=blades)
    found, counts = np.unique(drawn(law).ravel() / HALF * 0.02, return_counts=True)
    np.testing.assert_allclose(found, sorted(blades), atol=1e-15)
    assert np.abs(counts - N * BLADES / 4).max() < 5 * np.sqrt(N * BLADES * 3 / 16)
    assert HALF * law.sigma == pytest.approx(2 * np.std(blades), rel=1e-12)


@pytest.mark.parametrize("correlation", [0.3, 0.9])
def test_neighbours_are_correlated_and_each_blade_is_still_uniform(correlation):
    found = drawn(Law(neighbour_correlation=correlation))
    assert kstest(found[:, 5], uniform_law(-HALF, 2 * HALF).cdf).pvalue > 1e-3
    scores = ndtri((found / HALF + 1) / 2)
    for apart in (1, 2, 11):  # the last blade is a neighbour of the first
        expected = correlation ** min(apart, BLADES - apart)
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
    assert sigma_of(config)[3] == pytest.approx(truncnorm(-2, 2, scale=0.02).std())
