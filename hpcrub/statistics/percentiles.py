"""Running percentiles of amplifications in sample order, and their convergence errors.

Joachim, Nyssen, Batailly (2020), section 4.1. For every `step` samples, p_i is the percentile of
the first i samples. The error of the sequence p_1 ... p_k is the standard error of its mean,

    error = Z sqrt(V / k),                                            (6)
    V = 1/(k - 1) sum_i |p_i - mean(p)|^2.                            (7)

The paper writes s for the number of samples and also for the number of terms of the sum; here k is
the number of percentile values (i = step, 2 step, ..., k step). The error is absolute: it has the
unit of the amplification and is not divided by the mean.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import bdtr, betaincinv, ndtr, stdtrit

MIN_VALUES = 10  # least percentile values to judge convergence by: two may agree by chance
Z_95 = 1.96  # normal quantile of 95 % confidence


def finite(values: np.ndarray) -> np.ndarray:
    """Those of some values (...) that are known, neither NaN nor infinite, in their order (n,)."""
    return values[np.isfinite(values)]


def mean_and_error(values: np.ndarray) -> tuple[float, float]:
    """Mean of a few values (n,), and half its 95 % interval (Student); NaN for fewer than two."""
    n = len(values)
    error = stdtrit(n - 1, 0.975) * values.std(ddof=1) / np.sqrt(n) if n > 1 else np.nan
    return float(values.mean()), float(error)


def probability_interval(count: npt.ArrayLike, n: npt.ArrayLike, z: float) -> np.ndarray:
    """Confidence interval of the probability of an event that had `count` of n independent trials.

    It contains the true probability with the confidence 2 Phi(z) - 1 or more, by the binomial
    distribution. count, n: of any shape. Returns both ends (2, ...); 0 and 1 without a trial.
    Source: Clopper, Pearson, Biometrika 26 (1934).
    """
    count, n, tail = np.asarray(count), np.asarray(n), ndtr(-z)
    low = np.where(count > 0, betaincinv(count, n - count + 1, tail), 0.0)
    high = np.where(count < n, betaincinv(count + 1, n - count, 1.0 - tail), 1.0)
    return np.array([low, high])


def side_of(target: float, count: npt.ArrayLike, n: npt.ArrayLike, z: float) -> np.ndarray:
    """Whether probabilities are certainly below (-1) or above (1) a target, or neither (0).

    count, n, z: as in `probability_interval`.
    """
    low, high = probability_interval(count, n, z)
    return (low > target).astype(int) - (high < target)


def widened(
    centre: np.ndarray, low: np.ndarray, high: np.ndarray, shared: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Widen the intervals of values by the uncertainty of a common factor, added in squares.

    centre, low, high: values and ends of their intervals, of any shape. shared: relative amounts by
    which all values may be lower and higher (2,); NaN counts as zero. Returns the new ends.
    """
    below, above = np.nan_to_num(shared)
    further_low = np.hypot(centre - low, below * centre)
    return centre - further_low, centre + np.hypot(high - centre, above * centre)


def interval_in_words(*ends: float, form: str = ".3f") -> str:
    """Text with both ends of an interval; "-" for an end that is NaN, from too few samples."""
    return " to ".join(f"{end:{form}}" if np.isfinite(end) else "-" for end in ends)


class RunningPercentiles(NamedTuple):
    """Percentiles of the first step, 2 step, ... samples, with their intervals and errors."""

    percentile: np.ndarray  # (P, K)
    percentile_low: np.ndarray  # (P, K), confidence interval; NaN: too few samples for an end
    percentile_high: np.ndarray  # (P, K)
    mean_of_percentile: np.ndarray  # (P, K), figure 10 of the paper
    convergence_error: np.ndarray  # (P, K), equation (6)


def running_percentiles(
    values: np.ndarray, percentiles: Sequence[float], step: int, z: float
) -> RunningPercentiles:
    """Percentiles of the first step, 2 step, ... samples with equations (6) and (7).

    values (n,): in sample order; NaN (a failed sample) counts as seen and is left out of the
    percentiles. percentiles (P,): in [0, 100], interpolated linearly as by numpy. step: samples
    between two percentile values. z: confidence coefficient Z.
    Returns RunningPercentiles with K = n // step; NaN where samples are too few. The intervals
    assume only that samples are independent: the number of n samples below the percentile q of the
    population is binomial (n, q), hence the interval between two order statistics contains this
    percentile with the confidence 2 Phi(z) - 1 or more. Of few samples the interpolated percentile
    may lie beyond such an end, which then is moved to it.
    Source of the intervals: David, Nagaraja, Order Statistics (2003), section 7.1.
    """
    q = np.asarray(percentiles, dtype=np.float64)[:, None] / 100.0
    n = (~np.isnan(values)).cumsum()[step - 1 :: step]  # valid values so far (K,)
    low, high = _interval_ranks(n, q, z)
    found = np.full((3, len(q), len(n)), np.nan)
    present = np.empty(0)  # all values so far, sorted
    for block in range(len(n)):
        new = values[block * step : (block + 1) * step]
        new = np.sort(new[~np.isnan(new)])
        present = np.insert(present, np.searchsorted(present, new), new)
        if len(present):
            found[0, :, block] = np.percentile(present, percentiles)
            for end, rank in ((1, low[:, block]), (2, high[:, block])):
                known = np.isfinite(rank)
                found[end, known, block] = present[rank[known].astype(int)]
    percentile, low, high = found[0], np.minimum(*found[:2]), np.maximum(*found[::2])
    return RunningPercentiles(percentile, low, high, *_mean_and_error(percentile, z))


def confidence(z: float) -> float:
    """Probability that a normal variable lies within z standard deviations of its mean."""
    return 1.0 - 2.0 * ndtr(-z)


def percentile_interval(
    values: np.ndarray, percentiles: Sequence[float], z: float
) -> tuple[np.ndarray, np.ndarray]:
    """Ends (P,) of the confidence intervals of percentiles of all `values`."""
    if not len(values):
        return np.full(len(percentiles), np.nan), np.full(len(percentiles), np.nan)
    running = running_percentiles(values, percentiles, len(values), z)
    return running.percentile_low[:, -1], running.percentile_high[:, -1]


def with_interval(
    values: np.ndarray, percentiles: Sequence[float], shared: npt.ArrayLike = (0.0, 0.0)
) -> np.ndarray:
    """Percentiles (P,) of all `values`, and both ends of their 95 % intervals, (3, P).

    shared: uncertainty that all values have in common, see `widened`. NaN: no values, or too few
    for an end.
    """
    if not len(values):
        return np.full((3, len(percentiles)), np.nan)
    centre = np.percentile(values, percentiles)
    ends = percentile_interval(values, percentiles, Z_95)
    return np.array([centre, *widened(centre, *ends, np.asarray(shared))])


def _interval_ranks(n: Any, q: Any, z: Any) -> tuple[Any, Any]:
    """Positions (P, K) of the intervals' lower and upper ends among n (K,) sorted values.

    NaN where there is no such end. Both are binomial quantiles, each from its own small tail,
    because 1 - tail would be rounded to 1 for large z.
    """
    tail = ndtr(-z)
    low, high = _binomial_quantile(tail, n, q), n - _binomial_quantile(tail, n, 1.0 - q)
    return np.where(low >= 1, low - 1, np.nan), np.where(high < n, high, np.nan)


def _binomial_quantile(tail: Any, n: Any, q: Any) -> Any:
    """Least k such that a binomial variable (n, q) is at most k with probability `tail` or more.

    The function is `scipy.stats.binom.ppf`, whose import would take a second of every study.
    """
    below, found, q = np.broadcast_arrays(-1, n, q)
    while (found - below > 1).any():
        middle = (below + found) // 2
        enough = bdtr(middle, n, q) >= tail
        below, found = np.where(enough, below, middle), np.where(enough, middle, found)
    return found


def judged_error(criterion: str, found: Mapping[str, np.ndarray]) -> np.ndarray:
    """Error by which convergence is judged (..., P, K).

    criterion: "standard_error", equation (6), or "interval", half of the confidence interval.
    found: values by their names in RunningPercentiles.
    """
    if criterion == "standard_error":
        return found["convergence_error"]
    return (found["percentile_high"] - found["percentile_low"]) / 2.0


def first_converged(error: np.ndarray, target: float) -> int | None:
    """Number of percentile values after which every error is below the target.

    error (..., K): `judged_error` of all levels and percentiles.
    Returns the smallest such number, at least MIN_VALUES; None while there is none.
    """
    if error.shape[-1] < MIN_VALUES:
        return None
    worst = error.reshape(-1, error.shape[-1]).max(axis=0)  # NaN stays NaN, which is not converged
    below = np.flatnonzero(worst[MIN_VALUES - 1 :] < target)
    return int(below[0]) + MIN_VALUES if len(below) else None


def _mean_and_error(percentile: Any, z: Any) -> tuple[Any, Any]:
    """Mean of p_1 ... p_k and equation (6) for every k; percentile (P, K), NaN left out."""
    known = np.isfinite(percentile)
    count = known.cumsum(axis=1)
    rows = zip(percentile, known, strict=True)
    first = np.array([[p[is_known][:1].sum()] for p, is_known in rows])  # 0 without a value
    # from one of the values cancellation costs a factor of k in rounding at most, and the error of
    # values that are all alike is exactly 0
    off = np.where(known, percentile - first, 0.0)
    total, squares = off.cumsum(axis=1), (off * off).cumsum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.where(count > 0, first + total / count, np.nan)
        variance = np.maximum(squares - total * total / count, 0.0) / (count - 1)  # (7)
        error = np.where(count > 1, z * np.sqrt(variance / count), np.nan)  # (6)
    return mean, error
