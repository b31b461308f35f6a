"""Waves of the disk that still grow: whether a motion that looks steady stays.

A periodic motion may be unstable. It is then left exponentially, from the smallest difference
between blades or from rounding, and its amplitude shows nothing of that until the end. What shows
it from the beginning is the *change* of every wave, which is its difference between two windows at
the same angles of rotation: a transient makes it decay, an unstable motion makes it grow, however
large the forced motion of the same wave is. In a transient that is not over the *size* of a wave
drifts, while the largest displacement of all may stand still. Each nodal diameter is looked at for
itself, because those that decay hide those that grow. `docs/steady_state.md` has the measurements.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from hpcrub.model.casing_modes import Pairs
from hpcrub.model.interface import corresponding

RECORDS = 32  # of a window that count, about
SPAN = 1.5  # time constants of the slowest mode over which a change must grow
FEWEST, MOST = 4, 12  # changes that count, at least and at most
MEMORY = 2.0  # time constants of the slowest mode between two windows that are independent
CERTAIN = 3.0  # standard errors by which a trend must differ from 0
RISE = 0.1  # least growth over these changes, as a logarithm
FAINT = 1e-10  # of the amplitude: smaller changes are rounding
SHOWS = 0.03  # of the amplitude: a change that shows
MIXED = 0.2  # of the amplitude: a larger change is no more the begin of another motion
DRIFT = 0.007  # of the amplitude: change of a wave's size in a time constant, which matters


class Waves(NamedTuple):
    """How to see the waves of disk and casing in the records of a window."""

    # Fourier series over the blades, a cosine and a sine for every nodal diameter and place of a
    # blade (O, 2, G), and radial displacement by a unit motion of each pair of the casing (J,)
    disk: np.ndarray
    casing: np.ndarray  # [1/√kg]

    @classmethod
    def of(cls, observed_blade: np.ndarray, pairs: Pairs) -> "Waves":
        """Waves of a disk, whose observed displacements (O,) belong to blades, and of a casing.

        Where a blade has more places than others, those beyond are left out.
        """
        places = corresponding(observed_blade)
        n_blades, n_places = places.shape
        series = np.fft.rfft(np.eye(n_blades)) / n_blades  # (N, N // 2 + 1)
        disk = np.zeros((len(observed_blade), 2, series.shape[1], n_places))
        for (blade, place), row in np.ndenumerate(places):
            disk[row, :, :, place] = series[blade].real, series[blade].imag
        return cls(disk.reshape(len(disk), 2, -1), pairs.radial)

    def seen(self, observed: np.ndarray, casing: np.ndarray) -> np.ndarray:
        """Motion of all waves at R records of a window (R, 2, G) [m].

        observed: displacements (..., O) [m]; casing: coordinates of the pairs (..., 2J) [m·√kg].
        """
        n, _, n_waves = self.disk.shape
        moved = observed.reshape(-1, n) @ self.disk.reshape(n, -1)
        disk = moved.reshape(-1, 2, n_waves)
        if not len(self.casing):
            return disk
        pairs = casing.reshape(len(disk), -1, 2).swapaxes(1, 2) * self.casing
        return np.concatenate([disk, pairs], axis=2)


def record_step(n_blocks: int, per_block: int) -> int:
    """Step between the records of a block that count; n_blocks: of a window, per_block: records."""
    return min(max(1, n_blocks * per_block // RECORDS), per_block)


class Growth:
    """Changes and sizes of the waves from window to window at one speed."""

    def __init__(self, decay: float, window: float) -> None:
        """Start without a window; decay: of the slowest transient [1/s]; window: its length [s]."""
        self.window, self.decayed = window, decay * window
        self.n = min(max(FEWEST, math.ceil(SPAN / self.decayed)), MOST)
        self.last: Any = None  # motion of the waves in the last window (R, 2, G) [m]
        self.changes: list[np.ndarray] = []  # of every wave (G,) [m]
        self.sizes: list[np.ndarray] = []  # of every wave (G,) [m]

    def see(self, waves: Callable[[int], np.ndarray]) -> None:
        """Note the motion of the waves in a window that follows the one that was noted before.

        waves: function that returns it, (R, 2, G) [m], for the window before (0) and the last (1).
        """
        before, self.last = waves(0) if self.last is None else self.last, waves(1)
        self.changes = [*self.changes[1 - self.n :], _rms(self.last - before)]
        self.sizes = [*self.sizes[1 - self.n :], _rms(self.last)]

    @property
    def largest(self) -> float:
        """Largest change of a wave in the last window [m]."""
        return float(self.changes[-1].max())

    def shows(self, time: float, amplitude: float) -> float:
        """Time since the start at which the fastest growing wave shows [s]; NaN: none grows.

        time: of the last window's end since the start [s]; amplitude: of the motion [m].
        """
        change, size = np.array(self.changes), np.array(self.sizes)
        if len(change) < FEWEST:
            return math.nan
        with np.errstate(divide="ignore", invalid="ignore"):
            rate, error = trend(np.log(change))
            grows = (rate > CERTAIN * error) & (rate * (len(change) - 1) > RISE)
            grows &= (change[-1] > FAINT * amplitude) & (change[-1] < MIXED * amplitude)
            to_go = np.log(np.maximum(SHOWS * amplitude / change[-1], 1.0)) / rate
            slope, error = trend(size)
            drifts = np.abs(slope) > CERTAIN * error / math.sqrt(min(1.0, self.decayed / MEMORY))
            drifts &= np.abs(slope) > DRIFT * amplitude * self.decayed
        if drifts.any():
            return time
        return time + self.window * float(to_go[grows].min()) if grows.any() else math.nan


def _rms(motion: Any) -> Any:
    """Root mean square of every wave (G,) over the records of a window (R, 2, G)."""
    return np.sqrt(np.einsum("rcg,rcg->g", motion, motion) / len(motion))


def trend(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Slope of values (n, ...) from window to window, and its standard error, (...) each."""
    t = np.arange(len(values)) - (len(values) - 1) / 2.0
    slope = t @ values / (t @ t)
    rest = values - values.mean(axis=0) - np.multiply.outer(t, slope)
    return slope, np.sqrt((rest**2).sum(axis=0) / (len(t) - 2) / (t @ t))
