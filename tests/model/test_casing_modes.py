"""Waves of an elastic casing: frequencies, static compliance, and how blades in rotation see them.

Truths: the free ring of 20 mm steel has its flexural modes at 50.657, 143.274, 274.710, 444.261,
651.717, 897.002 and 1180.08 Hz (n = 2 to 8, R = 502.5 mm); curved beam elements of this program's
disk, which share no line with it; under a point load a free inextensional ring gives by
R³/(πEI) Σ 1/(n² − 1)², the sum from 2 being π²/12 − 11/16, and the first N terms leave out
R³/(3πEI (N + ½)³).
"""

import numpy as np
import pytest
from scipy.linalg import eigh

from evidence.truth.chain import assemble
from evidence.truth.disk import STEEL
from hpcrub.model.casing_modes import ring_modes
from hpcrub.model.elements import rectangular_beam, ring_element

WAVES = np.arange(2, 9)
KNOWN_HZ = 50.657, 143.274, 274.710, 444.261, 651.717, 897.002, 1180.08


def test_a_free_ring_has_the_known_frequencies():
    found = ring_modes(STEEL, WAVES, 0.005).omega / (2 * np.pi)
    np.testing.assert_allclose(found, KNOWN_HZ, rtol=1e-5)
    beam = rectangular_beam(STEEL.width, STEEL.thickness, STEEL.young, STEEL.density)
    element = ring_element(beam, 2 * np.pi * STEEL.radius / 64, STEEL.radius)
    mass, stiffness = assemble(element, 64, closed=True)
    of_elements = np.sqrt(eigh(stiffness, mass, eigvals_only=True)[3:17]) / (2 * np.pi)
    np.testing.assert_allclose(np.repeat(found, 2), of_elements, rtol=1e-3)


def test_a_free_ring_under_a_point_load():
    R, inertia = STEEL.radius, STEEL.width * STEEL.thickness**3 / 12
    unit = R**3 / (np.pi * STEEL.young * inertia)
    for n_max in (20, 100):
        modes = ring_modes(STEEL, np.arange(2, n_max + 1), 0.0)
        found = np.sum((modes.radial / modes.omega) ** 2)
        left_out = 1 / (3 * (n_max + 0.5) ** 3)
        assert found == pytest.approx(unit * (np.pi**2 / 12 - 11 / 16 - left_out), rel=2e-4)


def test_the_breathing_ring():
    modes = ring_modes(STEEL, np.array([0]), 0.0)
    assert modes.omega[0] == pytest.approx(np.sqrt(STEEL.young / STEEL.density) / STEEL.radius)
    mass = STEEL.density * 2 * np.pi * STEEL.radius * STEEL.width * STEEL.thickness
    assert modes.radial[0] == pytest.approx(1 / np.sqrt(mass))
    radial, tangential = modes.rows(np.array([0.3, 2.0]))
    assert not tangential.any()
    np.testing.assert_allclose(radial, [[1 / np.sqrt(mass), 0]] * 2)


def test_a_wave_that_nothing_holds_is_refused():
    with pytest.raises(ValueError, match="n = 1"):
        ring_modes(STEEL, np.array([1, 2]), 0.005)
    held = ring_modes(STEEL._replace(bed_radial=2e6, bed_tangential=5e5), np.array([1]), 0.005)
    assert held.omega[0] > 0


def test_a_turning_wave_is_at_rest_for_who_turns_with_it():
    modes = ring_modes(STEEL, WAVES, 0.0)
    angle, turned = np.linspace(0, 6, 7), 0.4
    c, s = np.random.default_rng(1).normal(size=(2, len(WAVES)))
    at_rest = np.ravel(np.column_stack([c, s]))
    cosine, sine = np.cos(WAVES * turned), np.sin(WAVES * turned)
    seen = np.ravel(np.column_stack([c * cosine + s * sine, s * cosine - c * sine]))
    for fixed, rotating in zip(modes.rows(angle + turned), modes.rows(angle), strict=True):
        np.testing.assert_allclose(rotating @ seen, fixed @ at_rest, atol=1e-14)
