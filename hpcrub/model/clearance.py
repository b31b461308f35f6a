"""Running clearance: between tips and casing at a speed of rotation.

Centrifugal growth, untwist and heat change it with the speed. What they come to is measured, or
computed by another program; here it is a table or a polynomial.
"""

from typing import NamedTuple

import numpy as np


class RunningClearance(NamedTuple):
    """Clearance over the speed: straight lines between points, or a polynomial."""

    points: tuple[tuple[float, float], ...] = ()  # speed, increasing [Hz], and clearance [m]
    coefficients: tuple[float, ...] = ()  # of the powers of the speed, from the zeroth [m/Hz^k]

    def at(self, speed_hz: float | np.ndarray) -> np.ndarray:
        """Clearance [m] at speeds [Hz] of any shape; beyond the points that of the nearest."""
        if self.points:
            return np.interp(speed_hz, *np.array(self.points).T)
        return np.polynomial.polynomial.polyval(speed_hz, np.array(self.coefficients))
