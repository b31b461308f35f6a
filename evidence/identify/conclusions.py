"""The paper's conclusions, tested on one disk after another.

Each is a difference that the paper says is positive (one says zero). Its interval is a bootstrap
over the samples, 95 %: what lies above zero holds, what lies below fails, else so few samples do
not tell.
"""

from typing import NamedTuple

import numpy as np

from evidence.identify import disks, stages

N_SAMPLES = 16
N_BOOT = 1000
BUMPS = tuple(stages.SPEEDS)
LEVELS = "0.6", "2.3"  # σ [%]
NEAR = 0.03  # of a speed: a peak that close to the tuned disk's is the same interaction


class Conclusion(NamedTuple):
    """A statement of the paper that can be read off samples."""

    name: str
    text: str
    margin: object  # function of the resampled numbers to what must be positive


class Answer(NamedTuple):
    """What one disk says to a conclusion."""

    margin: float
    low: float
    high: float

    @property
    def verdict(self):
        """In one word."""
        return "holds" if self.low > 0 else "fails" if self.high < 0 else "open"


def measure(dimensions, draw):
    """Amplifications of a disk at every n_d, two levels, and with less damping at n_d = 4.

    Parameters
    ----------
    dimensions : Dimensions
    draw : int

    Returns
    -------
    dict
        Clouds (3, n): contact and linear amplification, speed of the peak [Hz]; and the tuned
        peaks [Hz].
    """
    reduced = disks.reduced(dimensions)
    found = {}
    for n in BUMPS:
        low, high = stages.amplifications(reduced, n, draw, N_SAMPLES)
        found |= {f"{n}, 0.6": np.array(low), f"{n}, 2.3": np.array(high)}
        found[f"tuned {n}"] = stages.tuned_peak(reduced, n, draw)
    (less,) = stages.amplifications(reduced, 4, draw, N_SAMPLES, (1,), stages.LESS_DAMPING)
    return found | {"less damping": np.array(less)}


def _above(found):
    """Smallest median of A_nl/A_lin - 1 of n_d = 3, 4, 5 at both levels."""
    return min(np.median(c[0] / c[1]) - 1 for c in _clouds(found, (3, 4, 5)))


def _below(found):
    """One less the largest median of A_nl/A_lin of n_d = 6."""
    return 1 - max(np.median(c[0] / c[1]) for c in _clouds(found, (6,)))


def _worst(found):
    """Median A_nl of n_d = 4, less the largest of the others, at σ = 2.3 %."""
    median = {n: np.median(found[f"{n}, 2.3"][0]) for n in BUMPS}
    return median.pop(4) - max(median.values())


def _uncorrelated(found):
    """A correlation of 0.5 explains a quarter of the variance; how far A_nl's stays below it."""
    contact, linear, _ = found["4, 2.3"]
    return 0.5 - abs(np.corrcoef(contact, linear)[0, 1])


def _damping(found):
    """Relative shift of A_nl's median with less damping, less that of A_lin's; n_d = 4."""
    more, less = found["4, 2.3"], found["less damping"]
    shift = [np.median(less[i]) / np.median(more[i]) for i in (0, 1)]
    return shift[0] - shift[1]


def _speeds(found):
    """NEAR, less the largest median distance of the samples' peaks from the tuned ones."""
    return NEAR - max(
        np.median(np.abs(found[f"{n}, {level}"][2] / found[f"tuned {n}"] - 1))
        for n in BUMPS
        for level in LEVELS
    )


def _clouds(found, bumps):
    return [found[f"{n}, {level}"] for n in bumps for level in LEVELS]


CONCLUSIONS = (
    Conclusion("above", "A_nl above A_lin for n_d = 3, 4 and 5, σ = 0.6 and 2.3 %", _above),
    Conclusion("uncorrelated", "no correlation of A_nl with A_lin, n_d = 4", _uncorrelated),
    Conclusion("worst", "A_nl largest for n_d = 4", _worst),
    Conclusion("below", "A_nl below A_lin for n_d = 6, σ = 0.6 and 2.3 %", _below),
    Conclusion("damping", "a fifth less damping raises A_nl more than A_lin, n_d = 4", _damping),
    Conclusion("speeds", "mistuned peaks within 3 % of the tuned speeds, every n_d", _speeds),
)


def answers(found):
    """What a disk says to every conclusion.

    Parameters
    ----------
    found : dict
        By `measure`, or read back from a book.

    Returns
    -------
    dict
        Answer by the conclusion's name.
    """
    clouds = {name: np.array(values) for name, values in found.items()}
    rng = np.random.default_rng(0)
    n = next(c for c in clouds.values() if c.ndim == 2).shape[1]
    # the same samples at every n_d and damping, so they are drawn together
    draws = rng.integers(0, n, (N_BOOT, n))
    again = [{k: c[:, d] if c.ndim == 2 else c for k, c in clouds.items()} for d in draws]
    return {c.name: _answer(c, clouds, again) for c in CONCLUSIONS}


def _answer(conclusion, clouds, again):
    low, high = np.percentile([conclusion.margin(found) for found in again], (2.5, 97.5))
    return Answer(conclusion.margin(clouds), low, high)
