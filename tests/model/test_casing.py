"""Shape of the casing and its ramp: bumps (paper, equation 1), harmonics, measured points."""

import math

import numpy as np
import pytest

from hpcrub.model.casing import CasingShape, Profile, bump_height, outline, ramp, smoothed


def test_harmonics_are_cosines_beside_the_bumps():
    angle, turns = np.array([0.0, 0.3, 2.0]), 2 * np.pi * (np.arange(600) + 1) / 1200
    profile = Profile(harmonics=((2, 4e-4, 0.7), (5, 1e-4, -1.0)))
    phi = turns[:, None] + angle
    expected = 4e-4 * np.cos(2 * (phi - 0.7)) + 1e-4 * np.cos(5 * (phi + 1.0))
    np.testing.assert_allclose(
        CasingShape(3, 0.0, profile).table(angle, 1200, 600), expected, rtol=0, atol=1e-17
    )
    both = CasingShape(3, 1e-3, profile).table(angle, 1200, 600)
    np.testing.assert_allclose(both, expected + bump_height(phi, 3, 1e-3), rtol=0, atol=1e-17)


def test_measured_points_are_joined_by_lines_around_the_casing():
    profile = Profile(measured=((0.5, 1e-3), (2.5, 3e-3), (2 * np.pi - 0.5, 2e-3)))
    phi = np.array([0.5, 1.5, 2.5, -0.5, 0.0, 2 * np.pi, 7.5])
    heights = 1e-3 * np.array([1.0, 2.0, 3.0, 2.0, 1.5, 1.5, 2.0 + (7.5 - 2 * np.pi - 1.5)])
    np.testing.assert_allclose(profile.height(phi), heights, rtol=1e-12)


def test_a_casing_repeats_itself_as_often_as_all_its_parts_do():
    oval, waves = Profile(harmonics=((2, 1e-3, 0.0),)), Profile(harmonics=((6, 1, 0), (9, 1, 0)))
    assert CasingShape(4, 1e-3, Profile()).repeats == 4
    assert CasingShape(4, 1e-3, oval).repeats == 2
    assert CasingShape(3, 1e-3, oval).repeats == 1
    assert CasingShape(4, 0.0, waves).repeats == 3
    assert CasingShape(4, 0.0, oval._replace(measured=((0.0, 0.0), (1.0, 1e-3)))).repeats == 1
    for n, height, profile in ((4, 1e-3, oval), (4, 0.0, waves)):
        phi = np.linspace(0.0, 6.0, 77)
        casing = CasingShape(n, height, profile)
        turned = phi + 2 * np.pi / casing.repeats
        np.testing.assert_allclose(casing.height(turned), casing.height(phi), atol=1e-12)


def test_outline_of_a_harmonic_and_of_bumps():
    oval = outline(CasingShape(4, 0.0, Profile(harmonics=((2, 4e-4, 0.7),))))
    assert oval.orders == (2,)
    np.testing.assert_allclose(oval[:5], (4e-4, -4e-4, 0.0, 2 * 4e-4, 4 * 4e-4), atol=1e-9)
    bumps = outline(CasingShape(5, 1e-3))
    assert bumps.orders == (5, 10, 15, 20, 25, 30)
    width = 0.1 * 2 * np.pi / 5
    assert (bumps.highest, bumps.lowest) == (1e-3, 0.0)
    assert bumps.mean == pytest.approx(1e-3 * width * np.sqrt(np.pi) * 5 / (2 * np.pi), rel=1e-6)
    assert bumps.slope == pytest.approx(1e-3 * np.sqrt(2 / np.e) / width, rel=1e-14)
    assert bumps.curvature == pytest.approx(2 * 1e-3 / width**2, rel=1e-14)


@pytest.mark.parametrize("width", [0.25, 0.002])
def test_the_outline_is_that_of_the_whole_casing(width):
    """Bumps of any width, harmonics and points together, by differences of heights alone."""
    angle = 2 * np.pi * np.arange(90) / 90
    points = tuple(zip(angle, 2e-4 * np.sin(5 * angle), strict=True))
    profile = Profile(((1, 8e-4, 0.3), (7, 1e-4, 2.0)), points, 2 * np.pi / 50)
    casing = CasingShape(3, 4e-4, profile, width)
    found = outline(casing)
    phi = np.linspace(0.0, 2 * np.pi, 1_500_001)
    height, step = casing.height(phi), phi[1]
    assert found.highest == pytest.approx(height.max(), rel=1e-4)
    assert found.lowest == pytest.approx(height.min(), rel=1e-4)
    assert found.slope == pytest.approx(np.abs(np.diff(height)).max() / step, rel=0.02)
    wide = 92  # lines join the 2^14 angles at which points are smoothed
    second = height[2 * wide :] - 2 * height[wide:-wide] + height[: -2 * wide]
    second /= (wide * step) ** 2
    assert found.curvature == pytest.approx(-second.min(), rel=0.05)


@pytest.mark.parametrize("order", [12, 200])
def test_smoothing_is_the_spline_filter_of_roundness(order):
    """ISO 16610-22: of an order n is left 1/(1 + (n/n_c)⁴), one half at the cut-off."""
    angle = 2 * np.pi * np.arange(3600) / 3600
    points = tuple(zip(angle, 1e-3 * np.cos(order * angle + 0.4), strict=True))
    left = 1.0 / (1.0 + (order / 50) ** 4)
    phi = np.linspace(-4.0, 7.0, 999)
    profile = Profile(measured=points, cut_off=2 * np.pi / 50)
    height, slope, second = (profile.height(phi, k) for k in range(3))
    lines = 1.5 * (np.pi * order / 3600) ** 2  # error of lines between the points, relative
    expected = 1e-3 * left * np.cos(order * phi + 0.4)
    assert np.abs(height - expected).max() < 1e-3 * left * lines + 1e-8 * left
    rate = -1e-3 * left * order * np.sin(order * phi + 0.4)
    assert np.abs(slope - rate).max() < 2e-3 * left * order * lines + 1e-5 * left * order
    assert np.abs(second + order**2 * expected).max() < 1e-3 * left * order**2 * (lines + 0.01)
    away = outline(CasingShape(4, 0.0, profile)).smoothed_away
    assert away == pytest.approx(1e-3 * (1.0 - left), rel=0.05, abs=2e-9)


def test_smoothing_of_nothing_are_the_lines_between_the_points():
    points = tuple((np.radians(a), h) for a, h in ((0, 0.0), (90, 1e-3), (200, 5e-4), (300, 0.0)))
    phi = np.linspace(0.0, 6.2, 500)
    rough, fine = (Profile(measured=points, cut_off=c).height(phi) for c in (0.0, 1e-4))
    np.testing.assert_allclose(fine, rough, atol=1e-7)
    assert smoothed(points, 1e-9).shape[1] <= 2**17


def test_noise_far_below_the_shape_does_not_count():
    angle = np.linspace(0.0, 2 * np.pi, 1800, endpoint=False)
    noise = 1e-6 * np.random.default_rng(5).standard_normal(angle.size)
    rough = Profile(measured=tuple(zip(angle, 4e-4 * np.cos(3 * angle) + noise, strict=True)))
    assert outline(CasingShape(4, 0.0, rough)).orders == (3,)
    smooth = outline(CasingShape(4, 0.0, rough._replace(cut_off=2 * np.pi / 50)))
    assert smooth.curvature < 1.2 * 9 * 4e-4 < 0.01 * outline(CasingShape(4, 0.0, rough)).curvature


def test_growth():
    assert ramp(0.0, 0.01) == 0.0
    assert ramp(0.01, 0.01) == 1.0 == ramp(1.0, 0.01)
    assert ramp(0.004, 0.01) == pytest.approx((1 - math.exp(-2)) / (1 - math.exp(-5)))
    assert ramp(0.0, 0.0) == 0.0  # bumps of no ramp time are there after the first step
    assert ramp(1e-300, 0.0) == 1.0


@pytest.mark.parametrize("width", [0.02, 0.1, 0.2])
def test_a_bump_has_the_width_that_is_asked_for(width):
    """1/e of the height at the width, in every function that knows bumps; area of a Gaussian."""
    n, height = 5, 1e-3
    pitch = 2 * np.pi / n
    at = np.array([0.0, width * pitch, -width * pitch])
    expected = height * np.array([1.0, 1 / math.e, 1 / math.e])
    np.testing.assert_allclose(bump_height(at, n, height, width), expected)
    casing = CasingShape(n, height, bump_width=width)
    np.testing.assert_allclose(casing.height(at), expected)
    np.testing.assert_allclose(casing.table(at - 2 * np.pi / 1000, 1000, 1)[0], expected)
    mean = outline(casing).mean
    assert mean == pytest.approx(height * width * math.sqrt(math.pi), rel=1e-3)


def test_a_cliff_between_two_close_points_is_seen():
    """0.5 mm within a thousandth of a degree, which no evenly spaced points would see."""
    points = tuple((np.radians(a), h) for a, h in ((0, 0.0), (90, 0.0), (90.001, 5e-4), (200, 0.0)))
    found = outline(CasingShape(4, 0.0, Profile(measured=points)))
    width, flank = np.radians(0.001), 5e-4 / np.radians(0.001)
    assert found.curvature == pytest.approx(flank / width, rel=0.01)
    assert found.slope >= 0.49 * flank
