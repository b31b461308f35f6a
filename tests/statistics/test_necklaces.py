"""Patterns around a disk: all of them, those that are tried, and when one is worse for certain."""

from itertools import product

import numpy as np
import pytest

from hpcrub.statistics.necklaces import candidates, compare, count, first_rotation, necklaces


@pytest.mark.parametrize(("n_blades", "n_types"), [(1, 2), (6, 2), (5, 3), (8, 2), (4, 4)])
def test_necklaces_are_all_words_but_for_rotations(n_blades, n_types):
    words = {first_rotation(word) for word in product(range(n_types), repeat=n_blades)}
    assert list(necklaces(n_blades, n_types)) == sorted(words)
    assert count(n_blades, n_types) == len(words)


def test_of_twelve_blades_there_are_352_and_of_more_those_that_repeat_themselves_come_first():
    assert count(12, 2) == 352
    assert len(candidates(12, 2, 2000, 1)) == 350
    found = candidates(22, 2, 300, 1)
    periodic = [word for word in found if word[:11] == word[11:]]
    assert len(found) == len(set(found)) == 300
    assert len(periodic) == count(11, 2) - 2
    assert (0, 1) * 11 not in periodic  # its period of 2 does not fit 11 blades
    assert found[0] == (0, 1) * 11
    assert all(first_rotation(word) == word for word in found)
    assert found == candidates(22, 2, 400, 1)[:300] != candidates(22, 2, 300, 2)


def test_a_pattern_is_called_worse_where_it_is_and_seldom_where_it_is_not():
    drawn, wrong = np.random.default_rng(4), 0
    for _ in range(100):
        disks = drawn.normal(size=400)
        alike = disks + 0.1 * drawn.normal(size=(2, 400))
        known, low = compare(np.vstack([alike, disks + 0.5]), 90.0)
        np.testing.assert_array_equal(known[2], np.sort(disks + 0.5)[360])
        assert low[2] > 0.0
        assert low[np.argmin(known)] == 0.0
        wrong += max(low[:2]) > 0.0
    assert wrong <= 5  # 1 of 200 expected


def test_disks_without_a_result_make_a_pattern_worse():
    values = np.vstack([np.linspace(1, 2, 50), np.linspace(1, 2, 50)])
    values[1, 20:] = np.inf
    known, low = compare(values, 90.0)
    assert known[1] == np.inf
    assert low[0] == 0.0
    assert low[1] > 0.0


@pytest.mark.parametrize(("percentile", "n", "most"), [(99.0, 64, 3), (90.0, 256, 3)])
def test_of_patterns_that_are_equal_hardly_any_is_called_worse(percentile, n, most):
    drawn, wrong = np.random.default_rng(5), 0
    for _ in range(200):  # 0.5 % of them: 1
        values = drawn.normal(size=n) + drawn.normal(size=(30, n))
        wrong += (compare(values, percentile)[1] > 0.0).any()
    assert wrong <= most


def test_how_much_worse_is_a_low_end_of_what_is_true():
    drawn = np.random.default_rng(6)
    values = drawn.normal(size=2048) + 0.3 * drawn.normal(size=(2, 2048))
    values[1] += 1.0
    low = compare(values, 90.0)[1]
    assert 0.5 < low[1] < 1.0
