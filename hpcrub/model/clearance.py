"""Running clearance: between tips and casing at a speed of rotation.

Centrifugal growth, untwist and heat change it with the speed. What they come to is measured, or
computed by another program; here it is a table.
"""

from typing import NamedTuple

import numpy as np


class RunningClearance(NamedTuple):
    """Clearance over the speed: straight lines between points."""

    points: tuple[tuple[float, float], ...]  # speed, increasing [Hz], and clearance [m]

    def at(self, speed_hz: float | np.ndarray) -> np.ndarray:
        """Clearance [m] at speeds [Hz] of any shape; beyond the points that of the nearest."""
        return np.interp(speed_hz, *np.array(self.points).T)
