"""Stiffness over the speed of rotation: K0 + W^2 K1 + W^4 K2."""

from collections.abc import Sequence
from typing import Any

import numpy as np


def polynomial(stiffness: Sequence, speeds: np.ndarray) -> tuple:
    """K0 [N/m], K1 [N s2/m], K2 [N s4/m] of the parabola through three speeds (3,) [rad/s]."""
    square = np.asarray(speeds, dtype=float) ** 2
    coefficients = np.linalg.inv(np.vander(square / square.max(), 3, increasing=True))
    return tuple(
        sum(c * k for c, k in zip(row, stiffness, strict=True)) / square.max() ** power
        for power, row in enumerate(coefficients)
    )


def stiffness_at(stiffness: Sequence, speed: float) -> Any:
    """K0 + W^2 K1 + W^4 K2 at a speed of rotation [rad/s]."""
    return sum(k * speed ** (2 * power) for power, k in enumerate(stiffness))
