"""Growth of disk and casing seen from the rotor: free waves, energy, the sum and the difference."""

import numpy as np
import pytest

from hpcrub.model.casing_modes import CasingModes, Ring, ring_modes
from hpcrub.model.reduction import Modes, mistuned_modes
from hpcrub.response.casing_stability import eigenvalues, growth, turned_matrices

THIN = Ring(0.5025, 0.005, 0.1, 2.1e11, 7800.0, 2e6, 5e5)  # of steel, on a bed


def disk_in(reduced, ring, waves):
    casing = ring_modes(ring, np.array(waves), 0.005)
    return mistuned_modes(reduced._replace(casing=casing), np.zeros(12))


def spectrum(modes, damping, speed, coupling=None):
    """Eigenvalues of disk and casing, coupled by springs."""
    ratios = modes.damping_ratios(damping)
    D, S = turned_matrices(modes, ratios, speed)
    return eigenvalues(np.eye(len(D)), D, S + (0.0 if coupling is None else coupling))[0]


def test_a_free_wave_has_its_two_frequencies_seen_from_the_rotor(reduced):
    modes, speed = disk_in(reduced, THIN, [3, 5]), 2 * np.pi * 34.0
    found = spectrum(modes, 0.005, speed)
    decay = 0.005 * modes.pairs.omega
    turning = modes.pairs.omega * np.sqrt(1 - 0.005**2)
    for n, omega, rate in zip(modes.pairs.n_waves, turning, decay, strict=True):
        for seen in (n * speed + omega, n * speed - omega):
            near = found[np.abs(found.imag - seen).argmin()]
            assert near.imag == pytest.approx(seen, rel=0, abs=1e-6 * omega)
            assert near.real == pytest.approx(-rate, rel=1e-6)


def test_below_all_waves_nothing_grows_without_friction(reduced):
    """The energy seen from the rotor is positive there; above, contact feeds the waves."""
    modes = disk_in(reduced, THIN, [1, 2, 3, 4, 5, 6])
    critical = np.min(modes.pairs.omega / modes.pairs.n_waves) / (2 * np.pi)
    assert critical == pytest.approx(31.6, abs=0.1)
    pairs = modes.pairs._replace(damping_ratio=0.0 * modes.pairs.damping_ratio)
    undamped = modes._replace(pairs=pairs)
    for speed in (0.3 * critical, 0.9 * critical):
        assert growth(undamped, 0.0, 0.0, speed).rate < 1e-3
        assert growth(modes, 0.005, 0.0, speed).rate < 0.0
    above = growth(modes, 0.005, 0.0, 35.0)
    assert above.rate > 100.0
    assert above.waves == 6


def blades_of_two_modes(n, omega, speed_of_casing):
    """A disk of twelve tips whose cos nφ and sin nφ have one frequency, in a casing of one pair."""
    angle = 2 * np.pi * np.arange(12) / 12
    shapes = np.stack([np.cos(n * angle), np.sin(n * angle)], axis=1)
    modes = Modes.planar(np.full(2, omega), shapes, 0.0 * shapes)
    none, one = np.zeros(1), np.ones(1)
    casing = CasingModes(np.array([n]), np.array([speed_of_casing]), none, one, none)
    return modes._replace(pairs=casing.seen_from(angle))


@pytest.mark.parametrize(("damping", "k"), [(0.0, 50.0), (1e-3, 50.0), (1e-3, 400.0)])
def test_springs_at_all_tips_grow_at_the_sum_and_not_at_the_difference(damping, k):
    """At the sum two waves with the decay rates a and b grow by √((a − b)²/4 + g²) − (a + b)/2.

    g = κ/(2√(ω_b ω_c)) of a mass-normalised coupling κ: nothing grows where g² < ab.
    """
    n, blades, casing = 3, 600.0, 900.0
    modes = blades_of_two_modes(n, blades, casing)
    modes = modes._replace(pairs=modes.pairs._replace(damping_ratio=np.full(1, damping)))
    rows = modes.rows.normal
    coupling = k * rows.T @ rows
    own = k * 6.0  # the springs stiffen both by as much as they couple them
    stiff_blades, stiff_casing = np.sqrt(blades**2 + own), np.sqrt(casing**2 + own)
    kappa = 6.0 * k
    expected = kappa / (2 * np.sqrt(stiff_blades * stiff_casing))
    a, b = damping * blades, damping * casing
    expected = np.hypot((a - b) / 2, expected) - (a + b) / 2
    speeds = (stiff_casing + stiff_blades) / n + np.linspace(-0.5, 0.5, 201)
    rates = [spectrum(modes, damping, s, coupling).real.max() for s in speeds]
    assert max(rates) == pytest.approx(expected, rel=0.02)
    speeds = (stiff_casing - stiff_blades) / n + np.linspace(-0.5, 0.5, 51)
    assert max(spectrum(modes, damping, s, coupling).real.max() for s in speeds) < 1e-6
