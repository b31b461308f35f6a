"""Double sampling: without bias, with intervals that hold the truth, and cheaper than plain."""

import numpy as np
import pytest
from scipy.stats import chi2, expon, norm, weibull_max

from hpcrub.statistics.rare import (
    Counts,
    Goal,
    Rule,
    count,
    estimate,
    extrapolated,
    interval,
    n_needed,
    plan,
)

COSTS = 0.1, 1.0
PLAIN = Rule()
NONE = np.zeros(200_000, dtype=bool)  # disks without a result


def drawn(n, rho, limit, rng):
    """Looks and severities of n disks, log-normal with a correlation; P = 1 - Phi(limit)."""
    look = rng.normal(size=n)
    full = rho * look + np.sqrt(1 - rho**2) * rng.normal(size=n)
    return np.exp(0.1 * look), np.exp(0.1 * (full - limit))


def sampled(rule, look, severity, rng):
    """Estimate of one study, of which only the disks drawn are computed; their share."""
    inclusion = rule.inclusion(look)
    computed = rng.uniform(size=len(look)) < inclusion
    return *estimate(count(computed & (severity > 1.0), inclusion)), computed.mean()


@pytest.mark.parametrize("rho", [0.0, 0.8])
@pytest.mark.parametrize("chance", [0.003, 0.1])
def test_the_estimate_has_no_bias_and_the_interval_holds_the_truth(rho, chance):
    """Of 1,500 studies, with a rule made for a correlation of 0.8, whether that is true or not."""
    rng, limit = np.random.default_rng(33), norm.isf(chance)
    rule = Rule(0.8, -0.1 * limit, 0.06, 2.0, 0.0625)
    runs = np.array([sampled(rule, *drawn(3000, rho, limit, rng), rng) for _ in range(1500)])
    error = runs[:, 0].std() / np.sqrt(len(runs))
    assert abs(runs[:, 0].mean() - chance) < 3 * error
    held = (runs[:, 1] <= chance) & (chance <= runs[:, 2])
    assert held.mean() > 0.95 - 3 * np.sqrt(0.05 * 0.95 / len(runs))
    assert runs[:, 3].mean() < 0.6


def test_an_interval_of_plain_counts_is_garwoods():
    for events in (0, 1, 7, 120):
        ends = interval(Counts(events, events, 1.0, 1000))
        low = chi2.ppf(0.025, 2 * events) / 2000 if events else 0.0
        np.testing.assert_allclose(ends, (low, chi2.ppf(0.975, 2 * events + 2) / 2000), rtol=1e-10)


def test_the_numbers_of_disks_are_those_of_the_formulas():
    """(1.96/e)^2/P for a relative error e; 5.99/U where nothing is beyond a limit."""
    for error, chance in ((0.1, 1e-3), (0.05, 1e-2)):
        expected = (1.96 / error) ** 2 / chance
        n = n_needed(Goal(error, None), chance, chance, 1.0)
        assert expected < n < 1.1 * expected
    found = n_needed(Goal(None, 1e-3), 0.0, 0.0, 1.0)
    assert found == np.ceil(chi2.ppf(0.9975, 2) / 2 / 1e-3)


def test_a_look_that_correlates_costs_less_and_another_is_left_out():
    """Of the predicted numbers of disks, against 200,000 disks of the same kind."""
    rng, limit = np.random.default_rng(1), norm.isf(1e-3)
    goal = Goal(0.1, None)
    plain = float(n_needed(goal, 1e-3, 1e-3, 1.0))
    for rho, most in ((0.9, 0.6), (0.8, 0.75)):
        look, severity = drawn(200_000, rho, limit, rng)
        known = np.where(np.arange(len(look)) < 400, severity, np.nan)
        found = plan(look, known, NONE[: len(look)], np.ones(len(look)), COSTS, goal)
        inclusion = found.rule.inclusion(look)
        squares = ((severity > 1.0) / inclusion).mean()
        n = n_needed(goal, 1e-3, squares, 1.0 / inclusion.mean())
        assert n * (COSTS[0] + inclusion.mean()) < most * plain
    look, severity = drawn(400, 0.0, 1.0, rng)
    assert plan(look, severity, NONE[:400], np.ones(400), COSTS, goal).rule == PLAIN


def test_a_study_that_ends_when_it_knows_enough_holds_the_truth():
    """With looks at 1.3 times more disks each: a bias below a quarter of the error asked for."""
    rng, chance, goal = np.random.default_rng(5), 0.05, Goal(0.25, None)
    limit, found = norm.isf(chance), []
    for _ in range(40):
        look, severity = drawn(20_000, 0.8, limit, rng)
        chosen, n = rng.uniform(size=20_000), 100
        inclusion = np.ones(n)
        while True:
            known = np.where(chosen[:n] < inclusion, severity[:n], np.nan)
            counts = count(known > 1.0, inclusion)
            if goal.is_met(counts):
                break
            rule = plan(look[:n], known, NONE[:n], inclusion, COSTS, goal).rule
            more = rule.inclusion(look[n : int(1.3 * n)])
            inclusion = np.concatenate([inclusion, more])
            n = len(inclusion)
        found.append(estimate(counts))
    values, low, high = np.array(found).T
    assert abs(values.mean() / chance - 1) < 0.25 * goal.error
    assert ((low <= chance) & (chance <= high)).mean() > 0.87  # 35 of 40


def test_a_disk_without_a_look_is_computed():
    rule = Rule(1.0, 0.0, 0.1, 1.0, 0.1)
    np.testing.assert_array_equal(rule.inclusion(np.array([np.nan, 0.0, 1e-9])), [1.0, 1.0, 0.1])
    found = plan(np.full(3, np.nan), np.ones(3), NONE[:3], np.ones(3), COSTS, Goal(0.1, None))
    assert found.rule == PLAIN


def test_a_probability_at_the_target_is_seldom_called_below_or_above_it():
    """Of 4,000 studies with tests at 1.3 times more disks each, up to 100,000 disks.

    Intervals of 95 % name a side in a third of them, because each study is tested 28 times.
    """
    rng, n = np.random.default_rng(7), (100 * 1.3 ** np.arange(28)).astype(int)
    for target in (0.05, 0.01):
        events = rng.binomial(np.diff(n, prepend=0)[:, None], target, (28, 4000)).cumsum(axis=0)
        sides = Goal(None, target).side(Counts(events, events, 1.0, n[:, None]))
        assert (sides == -1).any(axis=0).mean() < 0.035
        assert (sides == 1).any(axis=0).mean() < 0.035


def test_disks_without_a_result_count_in_the_plan_as_in_the_estimate():
    """A tenth of the disks has none: plain sampling then needs (1.96/e)^2/P disks with P = 0.1."""
    rng = np.random.default_rng(2)
    look, severity = drawn(400, 0.95, norm.isf(1e-4), rng)
    lost = rng.uniform(size=400) < 0.1
    severity[lost] = np.nan
    found = plan(look, severity, lost, np.ones(400), COSTS, Goal(0.1, None))
    assert found.n_disks == pytest.approx(19.6**2 / lost.mean(), rel=0.5)


def test_distributions_that_are_fitted_to_their_own_draws_say_the_truth():
    """Of Weibull draws with an upper end, and of exponential ones, whose Pareto shape is zero."""
    draws = weibull_max(4.0, 1.5, 0.5).ppf((np.arange(4000) + 0.5) / 4000)
    at = weibull_max(4.0, 1.5, 0.5).isf([0.1, 0.01])
    low, _, high = extrapolated(draws, np.ones(4000), at, runs=8)["three-parameter Weibull"]
    assert (low < [0.11, 0.012]).all()
    assert (high > [0.09, 0.008]).all()
    draws = 1.0 + expon.ppf((np.arange(4000) + 0.5) / 4000)
    at = 1.0 - np.log([0.05, 0.002])
    low, _, high = extrapolated(draws, np.ones(4000), at, 8)["generalised Pareto"]
    assert (low < [0.052, 0.003]).all()
    assert (high > [0.048, 0.0013]).all()
    assert (high - low < [0.02, 0.01]).all()


def test_severities_whose_largest_are_alike_have_no_pareto_tail():
    """Nothing lies beyond their 90th percentile; the fit failed there, and with it the figure."""
    severity = np.repeat([0.5, 0.8, 1.2], [2, 3, 5])
    found = extrapolated(severity, np.ones(10), np.array([1.0, 2.0]), runs=3)
    assert np.isnan(found["generalised Pareto"]).all()
    assert np.isfinite(found["three-parameter Weibull"]).all()
