"""Steady state, amplitude and localisation from recorded tip displacements."""

import math
from typing import Any, NamedTuple

import numpy as np


class SteadyCriteria(NamedTuple):
    """Criteria by which a motion is checked and accepted; see `ensemble`.

    Defaults are from Joachim, Nyssen, Batailly (2020), section 3.1, except for `max_time`.
    """

    first_check: float = 0.5  # [s]
    window_revolutions: int = 3
    extend_revolutions: int = 10
    min_correlation: float = 0.95
    max_amplitude_change: float = 0.01
    max_time: float = 2.0  # [s]
    confirmations: int = 1  # checks to pass in succession; the paper asks for 1
    rule: str = "last_window"  # the paper's rule, or "ensemble"
    max_error: float = 0.15  # largest standard error of a mean amplitude, over the mean
    # the rule ensemble, not set by keys:
    watches_growth: bool = True  # whether a motion goes on while a wave grows
    aim: float = 1.0  # part of max_error below which an average ends before its time is over


def first_windows(steady: Any, window: float) -> int:
    """Windows of a length [s] until the first verdict of the rule ensemble, at least two."""
    return max(math.ceil(steady.first_check / window * (1.0 - 1e-12)), 2)


def check_blocks(steady: Any, speed_hz: float, per_turn: int) -> tuple[int, int]:
    """Blocks until the first check of a motion, and from one check to the next.

    The rule ensemble looks at all windows from half of the first check on, to see what grows.
    steady: SteadyCriteria; speed_hz: of rotation [Hz]; per_turn: blocks of a revolution.
    """
    window = steady.window_revolutions * per_turn
    if steady.rule == "ensemble":  # whole windows, so that all lanes are checked together
        first = first_windows(steady, steady.window_revolutions / speed_hz)
        return max(first // 2, 2) * window, window
    first = math.ceil(steady.first_check * speed_hz * per_turn)
    return max(first, 2 * window), steady.extend_revolutions * per_turn


def correlation(a: np.ndarray, b: np.ndarray) -> float:
    """Pearson correlation of two signals (n,); 1 if both are constant, 0 if only one is."""
    a, b = _unit(a), _unit(b)
    if not (a.any() and b.any()):
        return 0.0 if a.any() or b.any() else 1.0
    return float(a @ b)


def _unit(signal: Any) -> Any:
    """Signal (n,) without its mean, scaled to norm 1; zero if the signal is constant.

    Scaled twice, because squares of numbers below 1e-160 or above 1e150 leave the floating range.
    """
    off = signal - signal.mean()
    largest = np.abs(off).max()
    if not largest > 0.0:
        return off
    off = off / largest
    return off / np.sqrt(off @ off)


def is_constant(before: float, last: float, criteria: SteadyCriteria) -> bool:
    """Whether the amplitudes [m] of two successive windows agree; False for NaN."""
    return bool(abs(last - before) <= criteria.max_amplitude_change * last)


def is_repeated(before: np.ndarray, last: np.ndarray, criteria: SteadyCriteria) -> bool:
    """Whether a displacement (n,) [m] repeats itself in two successive windows; False for NaN."""
    return correlation(before, last) > criteria.min_correlation


def localisation(blade_amplitude: np.ndarray) -> np.ndarray:
    """Localisation factor of a vibration: 0 if all blades move alike, 1 if one blade moves alone.

    blade_amplitude: (..., N) largest displacement of each blade [m].
    Returns (...); factor [-]; 0 where nothing moves.
    Source: Joachim, Nyssen, Batailly (2020), equations (8) to (10).
    """
    n = blade_amplitude.shape[-1]
    largest = blade_amplitude.max(axis=-1)
    if n == 1:
        return np.zeros_like(largest)
    scale = np.where(largest > 0.0, largest, 1.0)
    rms = np.sqrt(np.mean((blade_amplitude / scale[..., None]) ** 2, axis=-1))
    zeta = 1.0 / np.where(rms > 0.0, rms, 1.0)
    return np.where(largest > 0.0, (zeta - 1.0) / (np.sqrt(n) - 1.0), 0.0)
