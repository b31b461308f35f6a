"""Bisection of a probability: the truth lies in the interval, with few of all disks."""

import numpy as np
import pytest

from hpcrub.statistics.threshold import ABOVE, BELOW, Search

VALUES = np.linspace(0, 1, 33)


def searched(chance, target, most, seed):
    """A whole search among disks that are above the limit with a chance at every value."""
    drawn = np.random.default_rng(seed).uniform(size=most)  # the same disks at every value
    above = drawn < chance[:, None]
    return Search.followed(above, np.ones(above.shape, dtype=bool), target)


def test_a_search_goes_on_where_its_disks_end_whatever_else_is_known():
    above = np.random.default_rng(1).uniform(size=60) < np.linspace(0.0, 1.0, 9)[:, None]
    known, n_looks = np.zeros(above.shape, dtype=bool), 0
    known[3] = True  # looked at by another search
    while look := Search.followed(above, known, 0.3).next_look():
        value, n = look
        assert Search.followed(above, known, 0.3).n_done[value] < n <= 60
        known[value, :n] = True
        n_looks += 1
        assert n_looks < 500
    whole, found = (Search.followed(above, k, 0.3) for k in (np.ones_like(known), known))
    np.testing.assert_array_equal(found.n_done, whole.n_done)
    np.testing.assert_array_equal(found.n_above, whole.n_above)


@pytest.mark.parametrize(("target", "most"), [(0.01, 3000), (0.1, 1000), (0.5, 500)])
@pytest.mark.parametrize("falls", [True, False])
def test_the_crossing_is_found_with_a_fifth_of_all_disks(target, most, falls):
    """Of a logistic chance, forty times: in nine of ten the interval holds the truth."""
    sign = 25 if falls else -25
    truth = 0.6 + np.log(1 / target - 1) / sign
    chance = 1 / (1 + np.exp((VALUES - 0.6) * sign))
    held, width, disks = 0, [], []
    for seed in range(40):
        found = searched(chance, target, most, seed)
        crossing = found.crossing()
        assert crossing is not None
        assert found.is_monotone()
        low, high = VALUES[list(crossing)]
        held += low <= truth <= high
        width.append(high - low)
        disks.append(found.n_done.sum())
    assert held >= 36
    assert np.mean(width) < 3.5 / 32
    assert np.mean(disks) < 0.2 * len(VALUES) * most


@pytest.mark.parametrize("side", [BELOW, ABOVE])
def test_where_nothing_crosses_the_ends_say_so_with_few_disks(side):
    chance = np.full(33, 0.001 if side == BELOW else 0.9)
    found = searched(chance, 0.1, 1000, 3)
    assert found.crossing() is None
    assert found.sides()[0] == found.sides()[-1] == side
    assert found.n_done.sum() < 500


def test_a_probability_that_rises_and_falls_again_is_not_monotone():
    chance = np.where(np.abs(VALUES - 0.5) < 0.2, 0.9, 0.001)
    chance[-1] = 0.95
    assert not searched(chance, 0.1, 1000, 3).is_monotone()


def test_ends_that_stay_undecided_have_no_crossing():
    found = searched(np.full(33, 0.1), 0.1, 100, 1)
    assert found.crossing() is None
    assert (found.n_done[[0, -1]] == 100).all()
