"""A sweep as the program makes it, and the windows of the time that follows, as its truth."""

import time
from typing import NamedTuple

import numpy as np

from hpcrub.contact.status import AVERAGED, NOT_STEADY, STEADY
from hpcrub.response import history
from hpcrub.response.revolution import cut_revolution
from hpcrub.response.sweep import Motion, run_sweep

BATCHES = 10  # of windows, whose scatter is the error of the truth
KINDS = {"steady": STEADY, "averaged": AVERAGED, "marked": NOT_STEADY}


class Followed(NamedTuple):
    """Points of a disk: what the sweep said, and what they are in the time that follows."""

    state: np.ndarray  # (S,) code of ``status``
    time: np.ndarray  # (S,) simulated [s]
    amplitude: np.ndarray  # (S,) [m]
    error: np.ndarray  # (S,) its standard error [m]; NaN: none is told
    truth: np.ndarray  # (S,) mean of all windows that follow [m]
    truth_error: np.ndarray  # (S,) standard error of this mean, by batches [m]
    seconds: float  # processor time of the sweep

    @property
    def errors_off(self):
        """How many standard errors the amplitude is off, that of the truth included (S,)."""
        known = np.hypot(np.nan_to_num(self.error), self.truth_error)
        return np.abs(self.amplitude - self.truth) / known

    @property
    def off(self):
        """Relative error of the amplitude (S,)."""
        return self.amplitude / self.truth - 1.0


def follow(modes, scene, speeds_hz, seconds):
    """Sweep one disk, and follow every speed on for some seconds of simulated time."""
    motion = Motion.at_rest(len(speeds_hz), modes.n_rows)
    began = time.process_time()
    result = run_sweep(modes, scene, speeds_hz, motion=motion)
    cost = time.process_time() - began
    truth = np.full((2, len(speeds_hz)), np.nan)
    for group in history.groups(speeds_hz):
        truth[:, group] = _truth(modes, scene, speeds_hz[group], motion, group, seconds)
    said = result.point_status, result.time, result.amplitude, result.error
    return Followed(*said, *truth, cost)


def _truth(modes, scene, speeds_hz, motion, group, seconds):
    """Mean of the windows of a few speeds, and its error (2, S) [m]; motion: of all speeds."""
    start = Motion(*(values[group] for values in motion))
    grid = cut_revolution(speeds_hz.min(), scene)
    per_window = scene.steady.window_revolutions * grid.blocks_per_revolution
    pieces = history.integrate(modes, scene, speeds_hz, seconds, start)
    peak = np.array([piece.peak.max(axis=0) for piece in pieces])  # (blocks, S)
    n = len(peak) // per_window
    windows = peak[: n * per_window].reshape(n, per_window, -1).max(axis=1)
    batches = np.array([part.mean(axis=0) for part in np.array_split(windows, min(BATCHES, n))])
    return windows.mean(axis=0), batches.std(axis=0, ddof=1) / np.sqrt(len(batches))


def shares(parts):
    """Rows (kind, points, beyond 2 and 3 errors, beyond 5 %, worst) of Followed of many disks."""
    state, beyond, off = (
        np.concatenate([getattr(part, name) for part in parts])
        for name in ("state", "errors_off", "off")
    )
    for kind, code in KINDS.items():
        there = (state == code) & np.isfinite(off)
        if there.any():
            of_kind, far = beyond[there], np.abs(off[there])
            told = (f"{100 * np.mean(of_kind > n):.1f} %" for n in (2, 3))
            both = np.mean((far > 0.05) & (of_kind > 2))
            yield kind, int(there.sum()), *told, f"{100 * both:.1f} %", f"{100 * far.max():.0f} %"
