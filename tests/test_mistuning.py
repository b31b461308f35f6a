"""Draws: uniform, and a function of (seed, level, sample) alone.

The bits are those of Philox 4x64-10 (Salmon et al. 2011), checked by the known answer that its
authors publish; sigma = 2 dE / sqrt(12) is equation (4).
"""

import numpy as np
import pytest
from scipy.stats import kstest

from hpcrub.mistuning import stiffness_deviation

N_BLADES = 12


def draws(seed, level, samples, half_range=0.04):
    return np.array([stiffness_deviation(seed, level, s, N_BLADES, half_range) for s in samples])


def test_draws_are_uniform_with_the_spread_of_equation_4():
    values = draws(2020, 0, range(4000))
    assert kstest(values.ravel(), "uniform", args=(-0.04, 0.08)).pvalue > 0.01
    assert np.abs(values).max() <= 0.04
    assert values.std() == pytest.approx(2 * 0.04 / np.sqrt(12), rel=0.01)


@pytest.mark.parametrize("axis", ["sample", "level", "seed"])
def test_successive_places_are_uncorrelated(axis):
    n = 2000
    values = {
        "sample": lambda: draws(1, 0, range(n)),
        "level": lambda: np.array([stiffness_deviation(1, k, 0, N_BLADES, 1) for k in range(n)]),
        "seed": lambda: np.array([stiffness_deviation(k, 0, 0, N_BLADES, 1) for k in range(n)]),
    }[axis]()
    assert kstest(values.ravel(), "uniform", args=(values.min(), np.ptp(values))).pvalue > 0.01
    between = np.corrcoef(values[:-1].ravel(), values[1:].ravel())[0, 1]
    blades = np.corrcoef(values.T) - np.eye(N_BLADES)
    assert abs(between) < 4 / np.sqrt(values.size)
    assert np.abs(blades).max() < 4.5 / np.sqrt(n)


def test_draws_do_not_depend_on_order_or_company():
    forward = draws(7, 2, range(50))
    backward = draws(7, 2, reversed(range(50)))[::-1]
    np.testing.assert_array_equal(forward, backward)
    fewer_blades = stiffness_deviation(7, 2, 31, 5, 0.04)
    np.testing.assert_array_equal(forward[31, :5], fewer_blades)
    np.testing.assert_array_equal(forward / 4, draws(7, 2, range(50), half_range=0.01))


def test_no_two_places_share_a_draw():
    places = [(s, v, n) for s in (0, 1, 2**64) for v in range(4) for n in range(40)]
    values = [stiffness_deviation(*p, n_blades=96, half_range=1) for p in places]
    assert len(np.unique(values)) == len(places) * 96


def test_bits_are_those_of_philox():
    """Known answer for counter 0 and key 0: numpy counts up first, hence all ones here."""
    ones = np.full(4, 2**64 - 1, dtype=np.uint64)
    bits = np.random.Philox(counter=ones, key=np.zeros(2, dtype=np.uint64)).random_raw(4)
    known = [0x16554D9ECA36314C, 0xDB20FE9D672D0FDC, 0xD7E772CEE186176B, 0x7E68B68AEC7BA23B]
    assert bits.tolist() == known


def test_draws_stay_the_same_for_ever():
    """Values of the first release: results of a finished study can always be redrawn."""
    first = [0.8959191257024375, -0.3482816601690151, 0.8614755155960787, 0.3762235253938686]
    np.testing.assert_array_equal(stiffness_deviation(2020, 3, 4999, 4, 1.0), first)
