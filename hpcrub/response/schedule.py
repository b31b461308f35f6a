"""Speed of rotation over time, and the angle by which the disk has turned."""

from functools import cached_property

import numpy as np


class Schedule:
    """Speeds of rotation at some times, with straight lines between; the first one before, too."""

    def __init__(self, time: np.ndarray, speed_hz: np.ndarray) -> None:
        """time: increasing from 0 (T,) [s]; speed_hz: positive (T,) [Hz]."""
        self.time, self.speed_hz = np.asarray(time, dtype=float), np.asarray(speed_hz, dtype=float)

    @cached_property
    def turned(self) -> np.ndarray:
        """Revolutions at the times (T,)."""
        mean = (self.speed_hz[1:] + self.speed_hz[:-1]) / 2.0
        return np.append(0.0, np.cumsum(mean * np.diff(self.time)))

    @cached_property
    def slopes(self) -> np.ndarray:
        """Gain of speed from each time on (T,) [Hz/s], 0 from the last one on."""
        return np.append(np.diff(self.speed_hz) / np.diff(self.time), 0.0)

    @cached_property
    def leg_ends(self) -> np.ndarray:
        """Times at which the legs end, in which the speed never falls, or never rises (D,) [s].

        A part of constant speed belongs to the leg before it.
        """
        ways = np.sign(self.slopes)
        moving = np.flatnonzero(ways)
        turns = moving[1:][np.diff(ways[moving]) != 0.0]
        return np.append(self.time[turns], self.time[-1])

    @property
    def leg_rises(self) -> np.ndarray:
        """Whether the speed rises in each leg (D,) bool; a constant speed counts as rising."""
        return np.diff(self.at(np.append(0.0, self.leg_ends))) >= 0.0

    def at(self, time: np.ndarray) -> np.ndarray:
        """Speeds at times of any shape [Hz]."""
        return np.interp(time, self.time, self.speed_hz)

    def when(self, revolutions: np.ndarray) -> np.ndarray:
        """Times [s] at which the disk has turned so often, of any shape; negative before the start.

        After the end the disk goes on at the last speed.
        """
        part = np.maximum(np.searchsorted(self.turned, revolutions, side="right") - 1, 0)
        left, speed = revolutions - self.turned[part], self.speed_hz[part]
        slope = np.where(revolutions < 0.0, 0.0, self.slopes[part])
        # the root of f t + a t²/2 = n, without cancellation
        root = np.sqrt(np.maximum(speed * speed + 2.0 * slope * left, 0.0))
        return self.time[part] + 2.0 * left / (speed + root)

    @classmethod
    def of_rate(
        cls, from_hz: float, to_hz: float, hz_per_s: float, hold_s: float = 0.0,
        back: bool = False, passes: int = 1,
    ) -> "Schedule":  # fmt: skip
        """Schedule at one rate: there, hold, and back if asked; several times.

        Between passes the disk goes back at the same rate.
        """
        lasts = abs(to_hz - from_hz) / hz_per_s
        there = [(lasts, to_hz)] + [(hold_s, to_hz)] * (hold_s > 0.0)
        home = [(lasts, from_hz)]
        legs = there + (home + there) * (passes - 1) + home * back
        time, speed = np.array([(0.0, from_hz), *legs]).T
        return cls(np.cumsum(time), speed)
