"""Search for a probability: the truth lies in the range found, with few of all disks."""

import numpy as np
import pytest
from scipy.special import ndtri
from scipy.stats import binomtest

from hpcrub.statistics.threshold import ABOVE, BELOW, FIRST_DISKS, Search, needed_below

VALUES = np.linspace(0, 1, 33)
SCATTER = 0.1  # of the logarithm of the severities of disks


def drawn(middle, most, seed):
    """Severities of the same disks at every value, with the logarithm of their median there."""
    scatter = SCATTER * np.random.default_rng(seed).normal(size=most)
    return np.exp(np.asarray(middle)[:, None] + scatter)


def searched(middle, target, most, seed):
    """A whole search among such disks."""
    severity = drawn(middle, most, seed)
    return Search.followed(severity, np.ones(severity.shape, dtype=bool), target)


def test_a_search_goes_on_where_its_disks_end_whatever_else_is_known():
    severity = drawn(0.3 - VALUES[:9], 60, 1)
    known, n_rounds = np.zeros(severity.shape, dtype=bool), 0
    known[3] = True  # looked at by another search
    while looks := (search := Search.followed(severity, known, 0.3)).next_looks():
        for value, n in looks:
            assert search.n_done[value] < n <= 60
            known[value, :n] = True
        n_rounds += 1
        assert n_rounds < 100
    whole, found = (Search.followed(severity, k, 0.3) for k in (np.ones_like(known), known))
    np.testing.assert_array_equal(found.n_done, whole.n_done)


@pytest.mark.parametrize(
    ("target", "most", "falls"),
    [
        pytest.param(0.002, 10_000, True, marks=pytest.mark.long),
        (0.01, 3000, False),
        (0.1, 1000, True),
        (0.5, 500, False),
    ],
)
def test_the_crossing_is_found_with_little_more_than_one_value_needs(target, most, falls):
    """The truth lies in the range found, twenty times; a value on the safe side needs 5.3/P."""
    middle = 3.0 * (VALUES - 0.4) * (-1 if falls else 1)
    truth = 0.4 + SCATTER * ndtri(target) / 3.0 * (1 if not falls else -1)
    held, width, disks = 0, [], []
    for seed in range(20):
        found = searched(middle, target, most, seed)
        ((a, b),) = found.crossings()
        held += VALUES[a] <= truth <= VALUES[b]
        width.append(b - a)
        disks.append(found.n_done.sum())
    assert held >= 18
    assert np.mean(width) < 3.0
    assert np.mean(disks) < len(VALUES) + 10 * FIRST_DISKS + 2.5 * needed_below(target, 0)


def test_a_resonance_that_passes_between_coarse_values_is_found():
    """The probability is 1 at 13 and 14 of 33 values and 0 at all others."""
    middle = np.full(33, -0.5)
    middle[13:15] = 0.5
    found = searched(middle, 0.2, 400, 1)
    assert found.crossings() == [(12, 13), (14, 15)]
    assert found.n_done.sum() < 300


def test_a_crossing_beside_the_end_of_the_range_is_made_certain():
    """Only the first value is beyond the target, 35 % beside 20 %: twenty disks cannot tell it."""
    middle = np.full(9, -0.5)
    middle[0] = SCATTER * ndtri(0.35)
    found = [searched(middle, 0.2, 400, seed) for seed in range(20)]
    assert sum(search.crossings() == [(0, 1)] for search in found) >= 18
    assert all(not search.doubtful().size for search in found if search.crossings())
    middle[0] = SCATTER * ndtri(0.22)  # so close that 60 disks cannot tell it
    found = [searched(middle, 0.2, 60, seed) for seed in range(20)]
    undecided = [search for search in found if search.n_done[0] == 60 and not search.crossings()]
    assert len(undecided) >= 10
    assert all(search.doubtful().tolist() == [0] for search in undecided)


@pytest.mark.parametrize("side", [BELOW, ABOVE])
def test_where_nothing_crosses_one_value_speaks_for_all(side):
    """A hopeless range took all disks at five values: 5.3/P each."""
    found = searched(side * (1.0 + VALUES), 0.001, 20_000, 3)
    assert not found.crossings()
    assert found.sides()[0] == side
    assert not (found.sides() == -side).any()
    most = needed_below(0.001, 0) if side == BELOW else 0
    assert found.n_done.sum() <= len(VALUES) + 10 * FIRST_DISKS + most


def test_a_probability_that_is_the_target_everywhere_is_on_no_side():
    found = searched(np.full(33, SCATTER * ndtri(0.1)), 0.1, 100, 1)
    assert not found.crossings()


@pytest.mark.parametrize("n_above", [0, 1, 7])
def test_so_many_disks_are_the_least_that_show_a_probability_below(n_above):
    n = needed_below(0.01, n_above)
    ends = [
        binomtest(n_above, disks).proportion_ci(0.99, method="exact").high for disks in (n - 1, n)
    ]
    assert ends[1] < 0.01 <= ends[0]
    assert needed_below(0.001, 0) == 5296  # ln(200) / 0.001


def test_disks_that_touch_nothing_or_have_no_result_have_a_severity():
    severity = np.zeros((5, 600))
    severity[0] = np.nan
    found = Search.followed(severity, np.ones(severity.shape, dtype=bool), 0.01)
    assert found.crossings() == [(0, 1)]


def test_a_crossing_is_narrowed_as_long_as_a_value_within_can_be_told():
    """Twice the target is told from it by 300 disks, but had a quarter of what the safe end has."""
    chance = np.array([0.6, 0.5, 0.4, 0.3, 0.2, 0.12, 0.03, 1e-4, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5])
    widths = []
    for seed in range(20):
        ((a, b),) = searched(SCATTER * ndtri(chance), 0.05, 400, seed).crossings()
        assert a <= 5 < b
        widths.append(b - a)
    assert np.mean(np.array(widths) <= 2) >= 0.9
