"""Damping ratios by mode, family and frequency band."""

import numpy as np
import pytest

from hpcrub.config.schema import Config
from hpcrub.contact.recurrence import coefficients
from hpcrub.model.damping import Damping, ratios

OMEGA = 2 * np.pi * np.array([80.0, 90.0, 100.0, 150.0, 200.0, 900.0])


@pytest.mark.parametrize(
    ("damping", "expected"),
    [
        (Damping((1e-3, 2e-3)), (1e-3, 2e-3, 2e-3, 2e-3, 2e-3, 2e-3)),
        (Damping((1e-3, 2e-3, 3e-3), family=2), (1e-3, 1e-3, 2e-3, 2e-3, 3e-3, 3e-3)),
        (
            Damping((1e-3, 2e-3, 3e-3), bands=(2 * np.pi * 100.0, 2 * np.pi * 200.5)),
            (1e-3, 1e-3, 1e-3, 2e-3, 2e-3, 3e-3),
        ),
        (0.01, 0.01),
    ],
)
def test_ratios_of_modes(damping, expected):
    np.testing.assert_array_equal(ratios(damping, OMEGA), expected)


@pytest.mark.parametrize("scheme", ["exact_modal", "central_difference"])
@pytest.mark.parametrize("h", [1e-6, 3.3e-5, 1e-3])
def test_equal_ratios_are_the_bits_of_the_single_one(scheme, h):
    omega = np.geomspace(1.0, 1e5, 4000)
    for ratio in (1e-6, 4e-3, 0.005, 1 / 3, 0.999):
        one = coefficients(scheme, omega, ratio, h)
        each = coefficients(scheme, omega, Damping((ratio,)).of_modes(omega), h)
        for a, b in zip(one, each, strict=True):
            assert a.tobytes() == b.tobytes()


def test_the_keys_of_damping():
    config = Config.from_yaml("material: {damping_ratios: [0.01, 0.02], damping_of: families}")
    assert config.damping == Damping((0.01, 0.02), family=12)
    config = Config.from_yaml(
        "material: {damping_ratios: [0.01, 0.02], damping_of: bands, damping_bands_hz: [100]}"
    )
    assert config.damping == Damping((0.01, 0.02), bands=(2 * np.pi * 100,))
    assert Config.from_yaml("material: {damping_ratio: 0.004}").damping == 0.004
