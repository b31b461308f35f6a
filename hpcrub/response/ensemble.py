"""Rules that decide when the integration of a motion ends, and with which amplitude.

Rubbing is hardly ever periodic. The largest displacement of a few revolutions is then one draw of
many, so that a rule looks at the motion window by window, from the first check on:

- *steady*: three windows in succession agree, all waves of the disk included. The damping sets how
  much they may differ: the remaining change of a slow transient must be below the change that the
  criteria allow.
- *averaged*: the mean of the windows' largest displacements has a standard error below `max_error`,
  in which a trend counts with all that it still leads away. Integration ends, whether the motion
  would repeat itself later or never.
- *not steady*: the time is over before the motion is steady or averaged.

No motion is steady or averaged while a wave of the disk grows (`growth`). Only the later half of
the windows counts, five at least, and never the first of all, which begins at rest. No motion is
averaged before transients of the free disk have decayed. `docs/steady_state.md` explains the
standard error, and the gain of this rule.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.special import stdtrit

from hpcrub.contact.status import AVERAGED, GROWING, NONE, NOT_STEADY, STEADY
from hpcrub.response.growth import MEMORY, Growth, trend
from hpcrub.response.steady import SteadyCriteria, first_windows, is_constant, is_repeated

ALIKE = 3  # windows in succession that agree in a steady motion
# Largest change of a wave in windows alike, of that which the criteria allow: a wave moves a tip by
# up to 2√2 times its root mean square, and several waves add.
REPEATED = 0.25
FEWEST = 5  # windows that a mean needs
AT_LAST = 4  # windows with which it has to do when the time is over
SETTLED = 2.0  # time constants of the slowest mode before a motion is averaged
TREND = 1.7  # standard errors by which a slope must differ from 0 to count as a trend
TO_GO = 0.4  # share of max_error by which a trend may still lead away from the mean
TWO_SIDED = 0.975  # two standard errors hold 95 %


class Recent(NamedTuple):
    """The last two windows of a motion, the older one first."""

    sizes: np.ndarray  # largest observed displacements in each (2, O) [m]
    # function that returns the history of one observed displacement in both, (R,) each [m]
    signals: Callable[[int], tuple[np.ndarray, np.ndarray]]
    # function that returns the motion of the waves in one of them (R, 2, G) [m]; see `growth.Waves`
    waves: Callable[[int], np.ndarray]


class Verdict(NamedTuple):
    """Verdict on a motion: its status and its amplitude."""

    status: int
    largest: np.ndarray  # largest magnitude of every observed displacement (O,) [m]
    amplitude: float  # [m]
    error: float  # standard error of the amplitude [m]; NaN: unknown
    scatter: float  # standard deviation of the windows' amplitudes [m]; NaN: unknown
    shows: float = math.nan  # time at which a wave that grows will show [s]; NaN: none grows

    @property
    def reason(self) -> int:
        """Code of ``status`` for a reason against it that is not an error."""
        return NONE if math.isnan(self.shows) else GROWING


class Watch:
    """A rule that ends the integration of one speed; `wear.Wearing` follows the coating, too."""

    always = False  # whether it needs every block from the start on, and worn depths (`keep`)

    def may_end(self, time: float) -> bool:
        """Whether the next call of `look`, at a time since the start [s], may give a verdict."""
        raise NotImplementedError

    def look(self, recent: Recent, time: float, over: bool) -> Verdict | None:
        """Judge the motion with its last two windows; return None while it has to go on.

        time: since the start [s]; over: whether there is no time for another window.
        """
        raise NotImplementedError

    def write(self, index: int, wear: Any) -> None:
        """Write the state of the coating to row ``index`` of ``wear`` (modified)."""


class LastWindow(Watch):
    """The paper's rule: two windows must agree, and the last one gives the amplitude."""

    def __init__(self, criteria: SteadyCriteria, decay: float, window: float) -> None:
        self.criteria, self.passed = criteria, 0

    def may_end(self, time: float) -> bool:
        """Whether the next check may end the motion; see `Watch`."""
        return self.passed + 1 >= self.criteria.confirmations

    def look(self, recent: Recent, time: float, over: bool) -> Verdict | None:
        """Compare two windows; see `Watch`."""
        before, last = recent.sizes
        tip = int(np.argmax(last))
        passes = is_constant(before[tip], last[tip], self.criteria)
        passes = passes and is_repeated(*recent.signals(tip), criteria=self.criteria)
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
        self.first = (first_windows(criteria, window) - 0.5) * window  # no verdict before it [s]
        self.growth = Growth(decay, window)
        self.part = -math.expm1(-decay * window)  # share of a transient that decays in a window
        self.independent = min(1.0, decay * window / MEMORY)  # windows, share that is independent
        change = criteria.max_amplitude_change * self.part
        self.strict = criteria._replace(max_amplitude_change=change)
        self.alike, self.sizes = 1, list[np.ndarray]()

    def may_end(self, time: float) -> bool:
        """Whether the next check may end the motion; see `Watch`."""
        enough = len(self.sizes) + 1 >= FEWEST and self.decay * time >= SETTLED
        return enough or self.alike + 1 >= ALIKE

    def look(self, recent: Recent, time: float, over: bool) -> Verdict | None:
        """Judge the motion with its last two windows; see `Watch`."""
        self.growth.see(recent.waves)
        if time < self.first and not over:
            return None
        verdict = self._found(recent, time, over)
        if verdict is None or not self.criteria.watches_growth:
            return verdict
        shows = self.growth.shows(time, verdict.amplitude)
        if math.isnan(shows):
            return verdict
        if over:
            return verdict._replace(status=NOT_STEADY, shows=shows)
        # windows of a motion that is being left say nothing of the one that follows
        self.alike, self.sizes = 1, self.sizes[-1:]
        return None

    def _found(self, recent: Recent, time: Any, over: Any) -> Any:
        """Verdict on the windows alone, whether a wave grows or not; None: go on."""
        before, last = recent.sizes
        # the first window of all begins at rest, and counts only where there is no other
        is_first = time < 2.5 * self.growth.window and not over
        self.sizes = [*(self.sizes or ([] if is_first else [before])), last]
        tip = int(np.argmax(last))
        # largest over all tips: at the start another tip may have moved more
        same = is_constant(before.max(), last[tip], self.strict)
        same = same and is_repeated(*recent.signals(tip), criteria=self.strict)
        allowed = REPEATED * self.strict.max_amplitude_change * last[tip]
        same = same and self.growth.largest <= allowed
        self.alike = self.alike + 1 if same else 1
        if self.alike >= ALIKE:
            return self._verdict(STEADY, ALIKE)
        fewest = AT_LAST if over else FEWEST
        enough = len(self.sizes) >= fewest and self.decay * time >= SETTLED
        if not enough and not over:
            return None
        n = min(max(FEWEST, math.ceil(len(self.sizes) / 2)), len(self.sizes))
        verdict = self._verdict(NOT_STEADY, n)
        allowed = self.criteria.max_error * verdict.amplitude
        known = enough and verdict.error <= allowed and self._to_go(n) <= TO_GO * allowed
        if known and (over or verdict.error <= self.criteria.aim * allowed):
            return verdict._replace(status=AVERAGED)
        return verdict if over else None

    def _verdict(self, status: Any, n: Any) -> Any:
        """Verdict by the last n windows, whose amplitudes may still be on their way elsewhere."""
        last = np.array(self.sizes[-n:])
        amplitudes = last.max(axis=1)
        scatter = amplitudes.std(ddof=1)
        mean, errors = amplitudes.mean(), stdtrit(n - 1, TWO_SIDED) / 2.0
        error = math.hypot(
            errors * scatter / math.sqrt(n * self.independent),
            self.criteria.max_amplitude_change * mean,
            self._to_go(n),
        )
        return Verdict(status, last.mean(axis=0), mean, error, scatter)

    def _to_go(self, n: Any) -> Any:
        """How far a trend of the last n amplitudes still leads away from their mean [m]."""
        if n <= ALIKE:
            return 0.0
        slope, error = trend(np.array(self.sizes[-n:]).max(axis=1))
        counts = abs(slope) > TREND * error / math.sqrt(self.independent)
        return abs(slope) / self.part if counts else 0.0
