"""Interaction speeds of casing waves and blades: closed forms, with and without stiffening."""

import numpy as np
import pytest

from hpcrub.model.casing_modes import CasingModes
from hpcrub.model.crossings import family_frequency, interactions
from hpcrub.model.imported.cyclic import tuned_diameters as diameters_of


def casing_of(n, hz):
    count = len(n)
    return CasingModes(np.array(n), 2 * np.pi * np.array(hz), *np.ones((3, count)))


def met(reduced, slope, n):
    """First family with n diameters of K + slope W² M, by speed; sum and difference with 120 Hz."""
    one = np.eye(len(reduced.mass))
    disk = reduced._replace(stiffening=(slope * one, 0.0 * one))
    diameters = diameters_of(reduced)
    found = interactions(disk, diameters, casing_of([n], [120.0]), 2 * np.pi * 1e3)
    return family_frequency(disk, diameters, n, 0), found[0, 0]


def test_a_disk_that_does_not_stiffen_meets_waves_as_in_closed_form(reduced):
    """n Omega = w_c + w_b and |w_c - w_b|; waves n = 14, 10 and 2 fold to the same diameters."""
    casing = casing_of([0, 2, 4, 14, 10], [300.0, 50.0, 200.0, 700.0, 600.0])
    found = interactions(reduced, diameters_of(reduced), casing, 2 * np.pi * 1e4)
    assert np.isnan(found[0]).all()  # the breathing casing does not travel
    frequencies = np.sqrt(reduced.tuned_eigenvalues)
    diameters = diameters_of(reduced)
    for j, diameter in ((1, 2), (2, 4), (3, 2), (4, 2)):
        blades = frequencies[diameters == diameter][[0, 2]]  # each diameter twice
        n, omega = casing.n_waves[j], casing.omega[j]
        np.testing.assert_allclose(found[j, :, 0], (omega + blades) / n, rtol=1e-9)
        np.testing.assert_allclose(found[j, :, 1], abs(omega - blades) / n, rtol=1e-9)
    low = interactions(reduced, diameters, casing, 2 * np.pi * 10.0)
    assert np.isnan(low[1:, :, 0]).all()


def test_where_rotation_stiffens_the_blades_the_frequency_is_that_of_the_speed(reduced):
    """K + W^2 M: w_b^2 = w_0^2 + W^2, so that n W = w_c + sqrt(w_0^2 + W^2) is a quadratic."""
    n, omega = 3, 2 * np.pi * 120.0
    family, found = met(reduced, 1.0, n)
    rest = family(0.0)
    a, b, c = n**2 - 1.0, -2.0 * n * omega, omega**2 - rest**2
    speed = (-b + np.sqrt(b * b - 4 * a * c)) / (2 * a)
    assert found[0] == pytest.approx(speed, rel=1e-9)


def test_blades_that_stiffen_faster_than_the_wave_are_met_twice_and_the_first_counts(reduced):
    """n W = w_c - sqrt(w_0^2 + s W^2): with s > n^2 only below, and only the lower one is told."""
    omega = 2 * np.pi * 120.0
    family, found = met(reduced, 4.0, 1)
    rest = family(0.0)
    # |w_c - w_b| falls, then rises faster than W: (W - w_c)^2 = w_0^2 + 4 W^2
    speed = (-2 * omega + np.sqrt(4 * omega**2 + 12 * (omega**2 - rest**2))) / 6
    assert np.isnan(found[0])
    assert found[1] == pytest.approx(speed, rel=1e-9)


def test_where_rotation_has_taken_all_stiffness_nothing_is_met(reduced):
    """K - 100 W^2 M: w_b^2 = w_0^2 - 100 W^2 ends at W = w_0/10, before n W = w_c + w_b."""
    family, found = met(reduced, -100.0, 2)
    rest = family(0.0)
    assert 2 * rest / 10 < 2 * np.pi * 120.0  # a sum would need a faster rotor
    assert np.isnan(family(rest / 9))
    assert np.isnan(found[0])
