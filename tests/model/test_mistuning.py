"""Draws: uniform, and a function of (seed, level, sample) alone.

The bits are those of Philox 4x64-10 (Salmon et al. 2011), written here once more and checked by
the known answer that its authors publish; sigma = 2 dE / sqrt(12) is equation (4).
"""

import numpy as np
import pytest
from scipy.stats import kstest

from hpcrub.model.mistuning import stiffness_deviation, uniform

N_BLADES = 12


def draws(seed, level, samples, half_range=0.04):
    return np.array([stiffness_deviation(seed, level, s, N_BLADES, half_range) for s in samples])


def test_draws_are_uniform_with_the_spread_of_equation_4():
    values = draws(2020, 0, range(4000))
    assert kstest(values.ravel(), "uniform", args=(-0.04, 0.08)).pvalue > 0.01
    assert np.abs(values).max() <= 0.04
    assert values.std() == pytest.approx(2 * 0.04 / np.sqrt(12), rel=0.01)


def test_draws_do_not_depend_on_order_or_company():
    forward = draws(7, 2, range(50))
    backward = draws(7, 2, reversed(range(50)))[::-1]
    np.testing.assert_array_equal(forward, backward)
    fewer_blades = stiffness_deviation(7, 2, 31, 5, 0.04)
    np.testing.assert_array_equal(forward[31, :5], fewer_blades)
    np.testing.assert_array_equal(forward / 4, draws(7, 2, range(50), half_range=0.01))


def test_streams_share_no_draw():
    places = [(stream, v, n) for stream in range(3) for v in range(4) for n in range(10)]
    values = [uniform(2020, *place, 96) for place in places]
    assert len(np.unique(values)) == len(places) * 96


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
