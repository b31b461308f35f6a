"""Amplifications in sample order to running percentiles and their convergence errors.

Joachim, Nyssen, Batailly (2020), section 4.1. For every `step` samples, p_i is the percentile of
the first i samples. The error of the sequence p_1 ... p_k is the standard error of its mean,

    error = Z sqrt(V / k),                                            (6)
    V = 1/(k - 1) sum_i |p_i - mean(p)|^2.                            (7)

The paper writes s for the number of samples and also for the number of terms of the sum; here k is
the number of percentile values (i = step, 2 step, ..., k step). The error is absolute: it has the
unit of the amplification and is not divided by the mean.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import ndtr

from hpcrub.contact.jit import compiled

MIN_VALUES = 10
"""The fewest percentile values on which convergence may be declared (two may agree by chance)."""


Z_95 = 1.96
"""Normal quantile of 95 % confidence."""


class Intervals(NamedTuple):
    """Confidence intervals of percentiles; NaN where there are too few samples for an end."""

    percentile_low: np.ndarray  # (P, K)
    percentile_high: np.ndarray  # (P, K)


class RunningPercentiles(NamedTuple):
    """Percentiles of the first samples_seen samples, and how far they have converged."""

    samples_seen: np.ndarray  # (K,) int64
    percentile: np.ndarray  # (P, K)
    mean_of_percentile: np.ndarray  # (P, K), figure 10 of the paper
    convergence_error: np.ndarray  # (P, K), equation (6)


def running_percentiles(values, percentiles, step, z):
    """Percentiles of the first step, 2 step, ... samples with equations (6) and (7).

    values (n,): in sample order; NaN (a failed sample) counts as seen and is left out of the
    percentiles. percentiles (P,): in [0, 100], by linear interpolation as numpy does. step: samples
    between two percentile values. z: confidence coefficient Z.
    Returns RunningPercentiles with K = n // step; NaN where nothing can be said.
    """
    rank = _percentile_ranks(_n_valid(values, step), percentiles)
    return _with_errors(_order_statistics(values, step, rank), step, z)


def running_intervals(values, percentiles, step, z):
    """Confidence intervals of the percentiles of the first step, 2 step, ... samples.

    Arguments as `running_percentiles`. Nothing is assumed but independent samples: of n of them,
    the number below the percentile q of the population is binomial (n, q), hence the interval
    between two order statistics holds it with the confidence 2 Phi(z) - 1 or more.
    Returns Intervals. Source: David, Nagaraja, Order Statistics (2003), section 7.1.
    """
    rank = _interval_ranks(_n_valid(values, step), percentiles, z)
    return Intervals(*np.split(_order_statistics(values, step, rank), 2))


def running_statistics(values, percentiles, step, z):
    """`running_percentiles` and `running_intervals` of the same values in one pass."""
    n = _n_valid(values, step)
    rank = np.concatenate([_percentile_ranks(n, percentiles), _interval_ranks(n, percentiles, z)])
    percentile, low, high = np.split(_order_statistics(values, step, rank), 3)
    return _with_errors(percentile, step, z), Intervals(low, high)


def confidence(z):
    """Probability that a normal variable lies within z standard deviations of its mean."""
    return 1.0 - 2.0 * ndtr(-z)


def percentile_interval(values, percentiles, z):
    """Ends (P,) of the confidence intervals of percentiles of all `values`."""
    ends = running_intervals(values, percentiles, max(len(values), 1), z)
    return Intervals(*(end[:, -1] if len(values) else np.full(len(end), np.nan) for end in ends))


def _with_errors(percentile, step, z):
    mean, error = _mean_and_error(percentile, z)
    seen = step * np.arange(1, percentile.shape[1] + 1, dtype=np.int64)
    return RunningPercentiles(seen, percentile, mean, error)


def _percentile_ranks(n, percentiles):
    """Positions (P, K) of percentiles among n (K,) sorted values, as numpy has them."""
    return (n - 1) * (np.asarray(percentiles, dtype=np.float64)[:, None] / 100.0)


def _interval_ranks(n, percentiles, z):
    """Positions (2 P, K) of the intervals' lower, then upper ends among n (K,) sorted values; NaN
    for none."""
    low, high = np.empty((2, len(percentiles), len(n)))
    tail = ndtr(-z)
    for p, percentile in enumerate(percentiles):
        _binomial_quantiles(n, percentile / 100.0, tail, low[p])
        _binomial_quantiles(n, percentile / 100.0, 1.0 - tail, high[p])
    low, high = np.where(low >= 1, low - 1, np.nan), np.where(high < n, high, np.nan)
    return np.concatenate([low, high])


@compiled
def _binomial_quantiles(n, q, probability, found):
    """Fill found (K,) (modified) with the least k at which the distribution of a binomial (n, q)
    variable reaches a probability; n (K,) not decreasing. From n to n + 1 the distribution F and
    its terms f change by a factor, so that the whole takes a time proportional to the last n.
    """
    k, f, total = 0, 1.0, 1.0  # f(k) and F(k) of no trial at all
    trials = 0
    for i in range(len(n)):
        if q <= 0.0 or q >= 1.0:
            found[i] = n[i] if q >= 1.0 else 0
            continue
        while trials < n[i]:
            total -= q * f
            trials += 1
            f *= (1.0 - q) * trials / (trials - k)
            while total < probability and k < trials:
                f *= (trials - k) / (k + 1.0) * q / (1.0 - q)
                k += 1
                total += f
        found[i] = k


def _n_valid(values, step):
    """Number of values among the first step, 2 step, ... that are not NaN (K,)."""
    n_blocks = len(values) // step
    return (~np.isnan(values)).cumsum()[step - 1 : n_blocks * step : step]


def _order_statistics(values, step, rank):
    """Values at the positions rank (R, K) among the first step, 2 step, ... sorted ones."""
    values = np.ascontiguousarray(values, dtype=np.float64)[: rank.shape[1] * step]
    order = np.argsort(values)  # NaN last
    n_valid = len(values) - int(np.count_nonzero(np.isnan(values)))
    place = np.empty(len(values), dtype=np.int32)  # small: the walk jumps about in it
    place[order] = np.arange(len(values), dtype=np.int32)
    found = np.full(rank.shape, np.nan)
    _walk_backwards(values[order], place, n_valid, np.ascontiguousarray(rank), step, found)
    return found


def judged_error(criterion, read):
    """The error by which convergence is judged (..., P, K).

    criterion: "standard_error", equation (6), or "interval", half of the confidence interval.
    read: function of a name in RunningPercentiles or Intervals that returns the values.
    """
    if criterion == "standard_error":
        return read("convergence_error")
    return (read("percentile_high") - read("percentile_low")) / 2.0


def first_converged(error, target):
    """Number of percentile values after which every error is below the target.

    error (..., K): `judged_error` of all levels and percentiles.
    Returns the smallest such k (1-based, at least MIN_VALUES), or None.
    """
    if error.shape[-1] < MIN_VALUES:
        return None
    worst = error.reshape(-1, error.shape[-1]).max(axis=0)  # NaN stays NaN: not converged
    below = np.flatnonzero(worst[MIN_VALUES - 1 :] < target)
    return int(below[0]) + MIN_VALUES if len(below) else None


def _mean_and_error(percentile, z):
    """Mean of p_1 ... p_k and equation (6) for every k; percentile (P, K), NaN values left out."""
    known = np.isfinite(percentile)
    count = known.cumsum(axis=1)
    centre = np.where(known, percentile, 0.0).sum(axis=1, keepdims=True)
    centre /= np.maximum(known.sum(axis=1, keepdims=True), 1)
    off = np.where(known, percentile - centre, 0.0)  # small numbers: no cancellation below
    total, squares = off.cumsum(axis=1), (off * off).cumsum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.where(count > 0, centre + total / count, np.nan)
        variance = np.maximum(squares - total * total / count, 0.0) / (count - 1)  # (7)
        error = np.where(count > 1, z * np.sqrt(variance / count), np.nan)  # (6)
    return mean, error


@compiled
def _walk_backwards(ordered, place, n_valid, rank, step, found):
    """Fill found (P, K) (modified) by taking samples away from the last to the first.

    ordered (n,): all values sorted, NaN last. place (n,): position of sample i in `ordered`. rank
    (P, K): positions among the values present, between two of them when fractional, NaN for none.
    The values still present form a linked list, so a percentile's place moves by a few links per
    block: the whole takes a time proportional to n.
    """
    before = np.arange(-1, n_valid - 1).astype(np.int32)
    after = np.arange(1, n_valid + 1).astype(np.int32)
    at = np.zeros(len(rank), dtype=np.int64)  # position in `ordered`, per percentile
    index = np.zeros(len(rank), dtype=np.int64)  # its number among the values present
    present = n_valid
    for block in range(found.shape[1] - 1, -1, -1):
        if present == 0:
            return
        for p in range(len(rank)):
            virtual = rank[p, block]
            if np.isnan(virtual):
                continue
            _walk(p, int(virtual), before, after, at, index)
            a = ordered[at[p]]
            b = ordered[after[at[p]]] if index[p] + 1 < present else a
            found[p, block] = _interpolate(a, b, virtual - index[p])
        for sample in range(block * step, (block + 1) * step):
            if place[sample] < n_valid:
                _take_away(place[sample], before, after, at, index)
                present -= 1


@compiled
def _walk(p, target, before, after, at, index):
    """Move percentile p along the links to the value of number `target` (at, index modified)."""
    while index[p] > target:
        at[p] = before[at[p]]
        index[p] -= 1
    while index[p] < target:
        at[p] = after[at[p]]
        index[p] += 1


@compiled
def _take_away(gone, before, after, at, index):
    """Unlink the value at position `gone` (all arrays modified)."""
    last = after[gone] == len(after)
    if before[gone] >= 0:
        after[before[gone]] = after[gone]
    if not last:
        before[after[gone]] = before[gone]
    for p in range(len(at)):
        if gone < at[p]:
            index[p] -= 1
        elif gone == at[p] and last:
            at[p] = before[gone]
            index[p] -= 1
        elif gone == at[p]:
            at[p] = after[gone]


@compiled
def _interpolate(a, b, t):
    """Point t of the way from a to b, rounded as numpy.percentile rounds it."""
    return b - (b - a) * (1.0 - t) if t >= 0.5 else a + (b - a) * t
