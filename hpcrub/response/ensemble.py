"""When a motion is followed no longer, and what its amplitude is.

Rubbing is hardly ever periodic. The largest displacement of a few revolutions is then one draw of
many, so that a motion is watched window by window, from the first check on:

- *steady*: three windows in succession are alike. By how much they may differ follows from the
  damping: what a transient still has to go must be below the change allowed.
- *averaged*: the mean of the windows' largest displacements has a standard error below `max_error`,
  and they show no trend. The motion is followed no further: it may repeat itself later, or never.
- *not steady*: neither is true when the time is over.

Only the later half of the windows counts, five at least, and no motion is averaged before
transients of the free disk have decayed. `docs/steady_state.md` says what is in the standard error,
and what the rule gains.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.special import stdtrit

from hpcrub.contact.status import AVERAGED, NOT_STEADY, STEADY
from hpcrub.response.steady import SteadyCriteria, is_constant, is_repeated

ALIKE = 3  # windows in succession of a steady motion
FEWEST = 5  # windows that a mean is made of
SETTLED = 2.0  # time constants of the slowest mode before a motion is averaged
TREND = 1.7  # standard errors of a slope that is not chance
TO_GO = 0.4  # of max_error, that a trend may lead away from the mean
MEMORY = 2.0  # time constants of the slowest mode: apart by so many, windows are independent
TWO_SIDED = 0.975  # two standard errors hold 95 %

Signals = Callable[[int], tuple[np.ndarray, np.ndarray]]


class Verdict(NamedTuple):
    """What is said of a motion in the end."""

    status: int
    largest: np.ndarray  # of every observed displacement (O,) [m]
    amplitude: float  # [m]
    error: float  # standard error of the amplitude [m]; NaN: unknown
    scatter: float  # standard deviation of the windows' amplitudes [m]; NaN: unknown


class Watch:
    """A rule that follows the motion of a speed until its end; that of a coating follows more."""

    always = False  # whether it sees every block from the start on, and worn depths

    def see(self, amplitude: float, time: float) -> None:
        """Take the largest displacement of the next block [m], and its end since the start [s]."""

    def keep(self, revolutions: int, worn: np.ndarray) -> None:
        """Keep the worn depth of every bar (Z, S) [m] after some revolutions since the start."""

    def write(self, index: int, wear: Any) -> None:
        """What became of the coating, as speed ``index`` of ``wear`` (modified)."""


class LastWindow(Watch):
    """The paper's rule: two windows are compared, and the last one tells the amplitude."""

    def __init__(self, criteria: SteadyCriteria, decay: float, window: float) -> None:
        self.criteria, self.passed = criteria, 0

    def may_end(self, time: float) -> bool:
        """As `Windows.may_end`."""
        return self.passed + 1 >= self.criteria.confirmations

    def look(
        self, before: np.ndarray, last: np.ndarray, signals: Signals, time: float, over: bool
    ) -> Verdict | None:
        """As `Windows.look`."""
        tip = int(np.argmax(last))
        passes = is_constant(before[tip], last[tip], self.criteria)
        passes = passes and is_repeated(*signals(tip), self.criteria)
        self.passed = self.passed + 1 if passes else 0
        if self.passed < self.criteria.confirmations and not over:
            return None
        status = STEADY if self.passed >= self.criteria.confirmations else NOT_STEADY
        return Verdict(status, last, float(last.max()), math.nan, math.nan)


class Windows(Watch):
    """What the windows of one speed have shown so far."""

    def __init__(self, criteria: SteadyCriteria, decay: float, window: float) -> None:
        """None yet.

        decay: rate of the slowest transient of the free disk [1/s]; window: length of a window [s].
        """
        self.criteria, self.decay = criteria, decay
        self.part = -math.expm1(-decay * window)  # of a transient, that a window takes
        self.independent = min(1.0, decay * window / MEMORY)  # of the windows, that count as such
        change = criteria.max_amplitude_change * self.part
        self.strict = criteria._replace(max_amplitude_change=change)
        self.alike, self.sizes = 1, list[np.ndarray]()

    def may_end(self, time: float) -> bool:
        """Whether the next look, at a time since the start [s], may find the motion known."""
        enough = len(self.sizes) + 1 >= FEWEST and self.decay * time >= SETTLED
        return enough or self.alike + 1 >= ALIKE

    def look(
        self, before: np.ndarray, last: np.ndarray, signals: Signals, time: float, over: bool
    ) -> Verdict | None:
        """Take note of a window; returns None to go on.

        before, last: (O,) largest observed displacements in the window before, and in this one [m].
        signals: gives the history of one observed displacement in both.
        time: since the start [s]; over: whether there is no time for another window.
        """
        self.sizes += [last] if self.sizes else [before, last]
        tip = int(np.argmax(last))
        # of all displacements: another one may have been larger before, as at the start
        same = is_constant(before.max(), last.max(), self.strict)
        self.alike = self.alike + 1 if same and is_repeated(*signals(tip), self.strict) else 1
        if self.alike >= ALIKE:
            return self._verdict(STEADY, ALIKE)
        enough = len(self.sizes) >= FEWEST and self.decay * time >= SETTLED
        if not enough and not over:
            return None
        n = max(FEWEST, math.ceil(len(self.sizes) / 2))
        found = self._verdict(NOT_STEADY, min(n, len(self.sizes)))
        known = enough and found.error <= self.criteria.max_error * found.amplitude
        if known and not self._goes_on(n, found.amplitude):
            return found._replace(status=AVERAGED)
        return found if over else None

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
