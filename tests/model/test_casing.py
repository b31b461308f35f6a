"""Shape of the casing and its ramp: bumps (paper, equation 1), harmonics, measured points."""

import math

import numpy as np
import pytest

from hpcrub.model.casing import (
    Profile,
    bump_height,
    bump_table,
    casing_height,
    outline,
    ramp,
    repeats,
    width_of_rest,
)


@pytest.mark.parametrize("n_bumps", [1, 3, 4, 7])
def test_bumps_repeat_and_peak(n_bumps):
    pitch = 2 * np.pi / n_bumps
    phi = np.linspace(-3.0, 3.0, 101)
    assert np.allclose(bump_height(phi + pitch, n_bumps, 2e-3), bump_height(phi, n_bumps, 2e-3))
    assert bump_height(0.0, n_bumps, 2e-3) == 2e-3
    assert bump_height(0.1 * pitch, n_bumps, 2e-3) == pytest.approx(2e-3 / math.e)


def test_harmonics_are_cosines_beside_the_bumps():
    angle, turns = np.array([0.0, 0.3, 2.0]), 2 * np.pi * (np.arange(600) + 1) / 1200
    profile = Profile(harmonics=((2, 4e-4, 0.7), (5, 1e-4, -1.0)))
    phi = turns[:, None] + angle
    expected = 4e-4 * np.cos(2 * (phi - 0.7)) + 1e-4 * np.cos(5 * (phi + 1.0))
    np.testing.assert_allclose(
        bump_table(angle, 3, 0.0, 1200, 600, profile), expected, rtol=0, atol=1e-17
    )
    both = bump_table(angle, 3, 1e-3, 1200, 600, profile)
    np.testing.assert_allclose(both, expected + bump_height(phi, 3, 1e-3), rtol=0, atol=1e-17)


def test_measured_points_are_joined_by_lines_around_the_casing():
    profile = Profile(measured=((0.5, 1e-3), (2.5, 3e-3), (2 * np.pi - 0.5, 2e-3)))
    phi = np.array([0.5, 1.5, 2.5, -0.5, 0.0, 2 * np.pi, 7.5])
    heights = 1e-3 * np.array([1.0, 2.0, 3.0, 2.0, 1.5, 1.5, 2.0 + (7.5 - 2 * np.pi - 1.5)])
    np.testing.assert_allclose(profile.height(phi), heights, rtol=1e-12)


def test_bumps_given_by_points_differ_by_the_error_of_interpolation():
    n, height, spacing = 4, 1.25e-3, 2 * np.pi / 720
    angle = spacing * np.arange(720)
    measured = Profile(measured=tuple(zip(angle, bump_height(angle, n, height), strict=True)))
    phi = np.linspace(-4.0, 9.0, 20_001)
    error = np.abs(measured.height(phi) - bump_height(phi, n, height)).max()
    steepest = 2 * height / (0.1 * 2 * np.pi / n) ** 2  # largest second derivative of a bump
    assert 0.1 * steepest * spacing**2 / 8 < error <= steepest * spacing**2 / 8


def test_a_casing_repeats_itself_as_often_as_all_its_parts_do():
    oval, waves = Profile(harmonics=((2, 1e-3, 0.0),)), Profile(harmonics=((6, 1, 0), (9, 1, 0)))
    assert repeats(4, 1e-3, Profile()) == 4
    assert repeats(4, 1e-3, oval) == 2
    assert repeats(3, 1e-3, oval) == 1
    assert repeats(4, 0.0, waves) == 3
    assert repeats(4, 0.0, oval._replace(measured=((0.0, 0.0), (1.0, 1e-3)))) == 1
    for n, height, profile in ((4, 1e-3, oval), (4, 0.0, waves)):
        phi = np.linspace(0.0, 6.0, 77)
        turned = phi + 2 * np.pi / repeats(n, height, profile)
        np.testing.assert_allclose(
            casing_height(turned, n, height, profile),
            casing_height(phi, n, height, profile), atol=1e-12,
        )  # fmt: skip


def test_outline_of_a_harmonic_and_of_bumps():
    oval = outline(4, 0.0, Profile(harmonics=((2, 4e-4, 0.7),)))
    assert oval.orders == (2,)
    np.testing.assert_allclose(oval[:3], (4e-4, 0.0, 4 * 4e-4), atol=1e-9)
    bumps = outline(5, 1e-3, Profile())
    assert bumps.orders == (5, 10, 15, 20, 25, 30)
    width = 0.1 * 2 * np.pi / 5
    assert bumps.highest == 1e-3
    assert bumps.mean == pytest.approx(1e-3 * width * np.sqrt(np.pi) * 5 / (2 * np.pi), rel=1e-6)
    assert bumps.curvature == pytest.approx(2 * 1e-3 / width**2, rel=0.05)


def test_noise_far_below_the_shape_does_not_count():
    angle = np.linspace(0.0, 2 * np.pi, 1800, endpoint=False)
    noise = 1e-6 * np.random.default_rng(5).standard_normal(angle.size)
    rough = Profile(measured=tuple(zip(angle, 4e-4 * np.cos(3 * angle) + noise, strict=True)))
    assert outline(4, 0.0, rough).orders == (3,)


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
    np.testing.assert_allclose(casing_height(at, n, height, Profile(), width), expected)
    turned = bump_table(at - 2 * np.pi / 1000, n, height, 1000, 1, Profile(), width)
    np.testing.assert_allclose(turned[0], expected)
    mean = outline(n, height, Profile(), width).mean
    assert mean == pytest.approx(height * width * math.sqrt(math.pi), rel=1e-3)


def profile_of(height):
    angle = 2 * np.pi * np.arange(len(height)) / len(height)
    return Profile(measured=tuple(zip(angle, height, strict=True)))


@pytest.mark.parametrize("width_deg", [0.2, 1.0, 5.0])
def test_a_triangle_is_as_wide_as_the_gaussian_of_its_slope(width_deg):
    """A Gaussian of height H and half width w is steepest with H sqrt(2/e) / w."""
    angle = np.degrees(2 * np.pi * np.arange(3600) / 3600)
    off = np.abs(angle - 100.0)
    triangle = 1e-3 * np.maximum(0.0, 1.0 - off / width_deg)
    oval = 1e-3 * np.cos(2 * np.radians(angle))
    found = outline(4, 0.0, profile_of(oval + triangle))
    equal = np.radians(width_deg) * np.sqrt(2 / np.e)  # half width w
    assert width_of_rest(found, 1e-3) == pytest.approx(2 * equal, rel=0.25)


def test_only_what_changes_by_a_tenth_of_the_height_that_is_met_counts():
    noise = 2e-6 * np.random.default_rng(2).uniform(-1.0, 1.0, 720)
    angle = 2 * np.pi * np.arange(720) / 720
    found = outline(4, 0.0, profile_of(1e-3 * np.cos(2 * angle) + noise))
    assert width_of_rest(found, 1e-4) == math.inf
    assert width_of_rest(found, 2e-5) < np.radians(20.0)
    smooth = outline(4, 0.0, profile_of(1e-3 * np.cos(2 * angle)))
    assert width_of_rest(smooth, 2e-5) > np.radians(20.0)


def test_a_cliff_between_two_close_points_is_seen():
    """0.5 mm within a thousandth of a degree, which no evenly spaced points would see."""
    points = tuple((np.radians(a), h) for a, h in ((0, 0.0), (90, 0.0), (90.001, 5e-4), (200, 0.0)))
    width = width_of_rest(outline(4, 0.0, Profile(measured=points)), 5e-4)
    assert width == pytest.approx(np.radians(0.001) * 2 * np.sqrt(2 / np.e), rel=0.2)
