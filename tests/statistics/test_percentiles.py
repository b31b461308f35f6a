"""Percentiles and convergence errors against a direct evaluation of (6) and (7); pairs of numbers
against Spearman's correlation as scipy has it."""

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from scipy.stats import binom, gaussian_kde, spearmanr

from hpcrub.statistics import pairs
from hpcrub.statistics.percentiles import (
    MIN_VALUES,
    first_converged,
    percentile_interval,
    probability_interval,
    running_percentiles,
    widened,
    with_interval,
)

PERCENTILES = [1, 50, 99]


def direct(values, percentiles, step, z):
    """Equations (6) and (7) as they are written, one percentile value at a time."""
    n_blocks = len(values) // step
    percentile, mean, error = np.full((3, len(percentiles), n_blocks), np.nan)
    for p, q in enumerate(percentiles):
        seen = []
        for k in range(n_blocks):
            first = values[: (k + 1) * step]
            first = first[~np.isnan(first)]
            if len(first):
                percentile[p, k] = np.percentile(first, q)
                seen.append(percentile[p, k])
            if seen:
                mean[p, k] = sum(seen) / len(seen)
            if len(seen) > 1:
                variance = sum((x - mean[p, k]) ** 2 for x in seen) / (len(seen) - 1)
                error[p, k] = z * np.sqrt(variance / len(seen))
    return percentile, mean, error


@pytest.mark.parametrize("step", [1, 7, 10])
@pytest.mark.parametrize("kind", ["plain", "failed", "ties", "all_alike", "first_block_failed"])
def test_against_direct_computation(step, kind):
    rng = np.random.default_rng(5)
    values = 1.0 + rng.gamma(4.0, 0.1, 303)
    if kind == "failed":
        values[rng.random(303) < 0.2] = np.nan
    if kind == "ties":
        values = np.round(values, 1)
    if kind == "all_alike":
        values[:] = 1.25
    if kind == "first_block_failed":
        values[:25] = np.nan
    result = running_percentiles(values, PERCENTILES, step, 2.81)
    percentile, mean, error = direct(values, PERCENTILES, step, 2.81)
    np.testing.assert_array_equal(result.percentile, percentile)  # the same bits as numpy's
    np.testing.assert_allclose(result.mean_of_percentile, mean, rtol=1e-14)
    np.testing.assert_allclose(result.convergence_error, error, rtol=1e-10, atol=1e-15)


def test_the_error_is_zero_while_a_percentile_has_not_changed():
    """Of percentiles 0 and 100 up to the next extreme, where it was rounding. Then it is that of a
    direct computation, however far the extreme lies."""
    values = 1.0 + np.random.default_rng(5).gamma(4.0, 0.1, 3000)
    values[[3, 5]] = 0.9, 9.0
    values[[905, 906]] = -50.0, 1e4
    result = running_percentiles(values, [0, 100], 10, 2.81)
    assert (result.convergence_error[:, 1:90] == 0.0).all()
    percentile, mean, error = direct(values, [0, 100], 10, 2.81)
    np.testing.assert_array_equal(result.percentile, percentile)
    np.testing.assert_allclose(result.mean_of_percentile, mean, rtol=1e-14)
    np.testing.assert_allclose(result.convergence_error, error, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("values", [np.empty(0), np.ones(9), np.full(20, np.nan)])
def test_nothing_to_say_is_nan_or_empty(values):
    result = running_percentiles(values, PERCENTILES, 10, 2.81)
    assert result.percentile.shape == (3, len(values) // 10)
    assert np.isnan(result.percentile).all()
    assert np.isnan(result.convergence_error).all()
    assert first_converged(result.convergence_error, 0.1) is None
    assert np.isnan(percentile_interval(values[:0], PERCENTILES, 2.81)).all()


def test_first_converged_needs_every_level_and_percentile():
    error = np.full((2, 3, 40), 0.001)
    assert first_converged(error, 0.005) == MIN_VALUES
    error[1, 2, :25] = 0.006
    assert first_converged(error, 0.005) == 26
    error[0, 0, :30] = np.nan
    assert first_converged(error, 0.005) == 31
    error[0, 0] = np.nan
    assert first_converged(error, 0.005) is None


@pytest.mark.parametrize("n", range(1, 51))
def test_an_interval_contains_its_estimate(n):
    """Of two values 1 and 2, percentile 1 is interpolated as 1.01, and the smaller one is above the
    population's with 98 %: an end that moves outward to the estimate is right all the more often.
    """
    values = np.random.default_rng(n).gamma(4.0, 0.1, n)
    percentiles = [0.0, 0.1, *np.linspace(0.5, 99.5, 199), 99.9, 100.0]
    estimate, low, high = with_interval(values, percentiles)
    assert not (low > estimate).any()
    assert not (high < estimate).any()


def test_running_intervals_are_those_of_the_first_samples():
    values = np.random.default_rng(8).gamma(4.0, 0.1, 97)
    values[::9] = np.nan
    running = running_percentiles(values, PERCENTILES, 10, 1.0)
    for k in range(9):
        first = values[: 10 * (k + 1)]
        low, high = percentile_interval(first[~np.isnan(first)], PERCENTILES, 1.0)
        np.testing.assert_array_equal(running.percentile_low[:, k], low)
        np.testing.assert_array_equal(running.percentile_high[:, k], high)


@pytest.mark.parametrize(
    ("n", "percentile", "z"),
    [(300, p, z) for p in (0, 1, 50, 99, 100) for z in (1.96, 8.0)] + [(2000, 1, 8.0)],
)
def test_interval_ends_are_binomial_quantiles(n, percentile, z):
    """In whole numbers, however small the tail: n trials of 100^-n of the terms of (q + 1 - q)^n.

    The values are their own ranks.
    """
    low, high = (end[0] for end in percentile_interval(np.arange(float(n)), [percentile], z))
    tail = int(Fraction(math.erfc(z / math.sqrt(2)) / 2) * 100**n)
    terms = [math.comb(n, k) * percentile**k * (100 - percentile) ** (n - k) for k in range(n + 1)]
    below = list(itertools.accumulate(terms))  # of k or fewer successes
    first = next(k for k in range(n + 1) if below[k] >= tail)
    last = next(k for k in range(n + 1) if below[n] - below[k] <= tail)
    np.testing.assert_equal(low, first - 1 if first >= 1 else np.nan)
    np.testing.assert_equal(high, last if last < n else np.nan)


def test_pairs_on_a_line_have_no_density():
    x = np.linspace(1.0, 2.0, 20)
    assert pairs.density(x, 2.0 * x)[2] is None


def test_pairs_have_the_density_and_the_rank_correlation_of_scipy():
    x, y = np.random.default_rng(4).multivariate_normal([0, 0], [[1, 0.6], [0.6, 2]], 30).T.round(1)
    grid_x, grid_y, density = pairs.density(x, y)
    exact = gaussian_kde([x, y])([part.ravel() for part in np.meshgrid(grid_x, grid_y)])
    np.testing.assert_allclose(density.T.ravel(), exact / exact.max(), atol=1e-12)
    assert len(set(x)) < len(x)  # with ties
    assert pairs.rank_correlation(x, y)[0] == pytest.approx(spearmanr(x, y).statistic, rel=1e-12)


def test_rank_interval_covers_as_often_as_it_says():
    random = np.random.default_rng(3)
    true = 6 / np.pi * np.arcsin(0.6 / 2)  # Spearman's correlation of normal pairs
    hits = 0
    for _ in range(250):
        x, y = random.multivariate_normal([0, 0], [[1, 0.6], [0.6, 1]], 80).T
        found, low, high = pairs.rank_correlation(x, y)
        hits += low <= true <= high
    assert 0.91 < hits / 250 < 0.985


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
