"""Rules that decide when the integration of a motion ends, and with which amplitude.

Rubbing is hardly ever periodic. The largest displacement of a few revolutions is then one draw of
many, so that a rule looks at the motion window by window, from the first check on:

- *steady*: three windows in succession agree. The damping sets how much they may differ: the
  remaining change of a slow transient must be below the change that the criteria allow.
- *averaged*: the mean of the windows' largest displacements has a standard error below `max_error`,
  and they show no trend. Integration ends, whether the motion would repeat itself later or never.
- *not steady*: the time is over before the motion is steady or averaged.

Only the later half of the windows counts, five at least, and no motion is averaged before
transients of the free disk have decayed. `docs/steady_state.md` explains the standard error, and
the gain of this rule.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.special import stdtrit

from hpcrub.contact.status import AVERAGED, NOT_STEADY, STEADY
from hpcrub.response.steady import SteadyCriteria, is_constant, is_repeated

ALIKE = 3  # windows in succession that agree in a steady motion
FEWEST = 5  # windows that a mean needs
SETTLED = 2.0  # time constants of the slowest mode before a motion is averaged
TREND = 1.7  # standard errors by which a slope must differ from 0 to count as a trend
TO_GO = 0.4  # share of max_error by which a trend may still lead away from the mean
MEMORY = 2.0  # time constants of the slowest mode between two windows that are independent
TWO_SIDED = 0.975  # two standard errors hold 95 %

Signals = Callable[[int], tuple[np.ndarray, np.ndarray]]


class Verdict(NamedTuple):
    """Verdict on a motion: its status and its amplitude."""

    status: int
    largest: np.ndarray  # largest magnitude of every observed displacement (O,) [m]
    amplitude: float  # [m]
    error: float  # standard error of the amplitude [m]; NaN: unknown
    scatter: float  # standard deviation of the windows' amplitudes [m]; NaN: unknown


class Watch:
    """A rule that ends the integration of one speed; `wear.Wearing` follows the coating, too."""

    always = False  # whether it needs every block from the start on, and worn depths (`keep`)

    def write(self, index: int, wear: Any) -> None:
        """Write the state of the coating to row ``index`` of ``wear`` (modified)."""


class LastWindow(Watch):
    """The paper's rule: two windows must agree, and the last one gives the amplitude."""

    def __init__(self, criteria: SteadyCriteria, decay: float, window: float) -> None:
        self.criteria, self.passed = criteria, 0

    def may_end(self, time: float) -> bool:
        """Whether the next check may end the motion; see `Windows.may_end`."""
        return self.passed + 1 >= self.criteria.confirmations

    def look(
        self, before: np.ndarray, last: np.ndarray, signals: Signals, time: float, over: bool
    ) -> Verdict | None:
        """Compare two windows; see `Windows.look`."""
        tip = int(np.argmax(last))
        passes = is_constant(before[tip], last[tip], self.criteria)
        passes = passes and is_repeated(*signals(tip), self.criteria)
        self.passed = self.passed + 1 if passes else 0
        if self.passed < self.criteria.confirmations and not over:
            return None
        status = STEADY if self.passed >= self.criteria.confirmations else NOT_STEADY
        return Verdict(status, last, float(last.max()), math.nan, math.nan)


class Windows(Watch):
    """The rule of an ensemble of windows, with the windows of one speed so far."""

    def __init__(self, criteria: SteadyCriteria, decay: float, window: float) -> None:
        """Start without windows.

        decay: rate of the slowest transient of the free disk [1/s]; window: length of a window [s].
        """
        self.criteria, self.decay = criteria, decay
        self.part = -math.expm1(-decay * window)  # share of a transient that decays in a window
        self.independent = min(1.0, decay * window / MEMORY)  # windows, share that is independent
        change = criteria.max_amplitude_change * self.part
        self.strict = criteria._replace(max_amplitude_change=change)
        self.alike, self.sizes = 1, list[np.ndarray]()

    def may_end(self, time: float) -> bool:
        """Whether the next call of `look`, at a time since the start [s], may give a verdict."""
        enough = len(self.sizes) + 1 >= FEWEST and self.decay * time >= SETTLED
        return enough or self.alike + 1 >= ALIKE

    def look(
        self, before: np.ndarray, last: np.ndarray, signals: Signals, time: float, over: bool
    ) -> Verdict | None:
        """Judge the motion with its last window; return None while it has to go on.

        before, last: (O,) largest observed displacements in the window before, and the last [m].
        signals: function that returns the history of one observed displacement in both windows.
        time: since the start [s]; over: whether there is no time for another window.
        """
        self.sizes += [last] if self.sizes else [before, last]
        tip = int(np.argmax(last))
        # largest over all tips: at the start another tip may have moved more
        same = is_constant(before.max(), last[tip], self.strict)
        self.alike = self.alike + 1 if same and is_repeated(*signals(tip), self.strict) else 1
        if self.alike >= ALIKE:
            return self._verdict(STEADY, ALIKE)
        enough = len(self.sizes) >= FEWEST and self.decay * time >= SETTLED
        if not enough and not over:
            return None
        n = max(FEWEST, math.ceil(len(self.sizes) / 2))
        verdict = self._verdict(NOT_STEADY, min(n, len(self.sizes)))
        known = enough and verdict.error <= self.criteria.max_error * verdict.amplitude
        if known and not self._goes_on(n, verdict.amplitude):
            return verdict._replace(status=AVERAGED)
        return verdict if over else None

    def _verdict(self, status, n):
        last = np.array(self.sizes[-n:])
        amplitudes = last.max(axis=1)
        scatter = amplitudes.std(ddof=1)
        mean, errors = amplitudes.mean(), stdtrit(n - 1, TWO_SIDED) / 2.0
        error = math.hypot(
            errors * scatter / math.sqrt(n * self.independent),
            self.criteria.max_amplitude_change * mean,
        )
        return Verdict(status, last.mean(axis=0), mean, error, scatter)

    def _goes_on(self, n, mean):
        """Whether the last n amplitudes show a trend that leads away from their mean."""
        amplitudes = np.array(self.sizes[-n:]).max(axis=1)
        t = np.arange(n) - (n - 1) / 2.0
        slope = t @ amplitudes / (t @ t)
        rest = amplitudes - mean - slope * t
        error = math.sqrt(rest @ rest / (n - 2) / (t @ t) / self.independent)
        to_go = abs(slope) / self.part
        return abs(slope) > TREND * error and to_go > TO_GO * self.criteria.max_error * mean
