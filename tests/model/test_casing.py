"""Bumps of the casing and their ramp (paper, equation 1)."""

import math

import numpy as np
import pytest

from hpcrub.model.casing import bump_height, bump_table, ramp


@pytest.mark.parametrize("n_bumps", [1, 3, 4, 7])
def test_bumps_repeat_and_peak(n_bumps):
    pitch = 2 * np.pi / n_bumps
    phi = np.linspace(-3.0, 3.0, 101)
    assert np.allclose(bump_height(phi + pitch, n_bumps, 2e-3), bump_height(phi, n_bumps, 2e-3))
    assert bump_height(0.0, n_bumps, 2e-3) == 2e-3
    assert bump_height(0.1 * pitch, n_bumps, 2e-3) == pytest.approx(2e-3 / math.e)


def test_table_is_the_function_at_the_end_of_each_step():
    angle = np.array([0.0, 0.3, 2.0])
    table = bump_table(angle, 4, 1e-3, 1200, 300)
    assert table.shape == (300, 3)
    assert np.allclose(table[299], bump_height(angle, 4, 1e-3))  # one pitch later
    assert np.allclose(table[0], bump_height(angle + 2 * np.pi / 1200, 4, 1e-3))


def test_growth():
    assert ramp(0.0, 0.01) == 0.0
    assert ramp(0.01, 0.01) == 1.0 == ramp(1.0, 0.01)
    assert ramp(0.004, 0.01) == pytest.approx((1 - math.exp(-2)) / (1 - math.exp(-5)))
    assert ramp(0.0, 0.0) == 0.0  # bumps of no ramp time are there after the first step
    assert ramp(1e-300, 0.0) == 1.0
