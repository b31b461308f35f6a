"""A small probability: known when it is said to be, by as many disks as the formulas say."""

import numpy as np
import pytest

from hpcrub.statistics.percentiles import Z_95, probability_interval
from hpcrub.statistics.rare import MOST_DISKS, Goal, n_needed

N = (100 * 1.3 ** np.arange(28)).astype(int)  # disks of all estimates, up to 100,000


def n_above(chance, studies, rng):
    """Events among the first N disks of many studies (28, studies)."""
    return rng.binomial(np.diff(N, prepend=0)[:, None], chance, (len(N), studies)).cumsum(axis=0)


def test_the_numbers_of_disks_are_those_of_the_formulas():
    """(1.96/e)^2 (1 - P)/P for a relative error e; (1 - U)^n = 0.0025 where no disk is beyond."""
    for error, chance in ((0.1, 1e-3), (0.05, 1e-2), (0.05, 0.3)):
        expected = (1.96 / error) ** 2 * (1.0 - chance) / chance
        assert expected < n_needed(Goal(error, None), chance) < 1.1 * expected
    expected = np.log(0.0025) / np.log1p(-1e-3)
    assert n_needed(Goal(None, 1e-3), 0.0) == pytest.approx(expected, abs=1.0)


def test_no_number_of_disks_tells_what_cannot_be_told():
    assert n_needed(Goal(0.1, None), 0.0) == pytest.approx(MOST_DISKS, rel=1e-9)
    assert n_needed(Goal(None, 0.01), 0.01) > 1e9


@pytest.mark.parametrize("chance", [0.3, 0.05, 0.01])
def test_a_study_that_ends_when_it_knows_enough_holds_the_truth(chance):
    """Of 4,000 studies: a bias below a quarter of the error asked for."""
    goal, above = Goal(0.25, None), n_above(chance, 4000, np.random.default_rng(5))
    met = goal.is_met(above, N[:, None])
    assert met.any(axis=0).all()
    end = met.argmax(axis=0)
    above, n = above[end, np.arange(4000)], N[end]
    low, high = probability_interval(above, n, Z_95)
    assert abs((above / n).mean() / chance - 1.0) < 0.25 * goal.error
    assert ((low <= chance) & (chance <= high)).mean() > 0.93
    assert (high - low <= 2.0 * goal.error * above / n).all()


def test_a_probability_at_the_target_is_seldom_called_below_or_above_it():
    """Of 4,000 studies; intervals of 95 % would name a side in a third, in 28 tests of each."""
    rng = np.random.default_rng(7)
    for target in (0.05, 0.01):
        sides = Goal(None, target).side(n_above(target, 4000, rng), N[:, None])
        assert (sides == -1).any(axis=0).mean() < 0.035
        assert (sides == 1).any(axis=0).mean() < 0.035
