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

from hpcrub.jit import compiled

MIN_VALUES = 10
"""The fewest percentile values on which convergence may be declared (two may agree by chance)."""


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
    values = np.ascontiguousarray(values, dtype=np.float64)
    fractions = np.asarray(percentiles, dtype=np.float64) / 100.0
    n_blocks = len(values) // step
    values = values[: n_blocks * step]
    order = np.argsort(values)  # NaN last
    n_valid = len(values) - int(np.count_nonzero(np.isnan(values)))
    place = np.empty(len(values), dtype=np.int64)
    place[order] = np.arange(len(values))
    percentile = np.full((len(fractions), n_blocks), np.nan)
    _percentiles_backwards(values[order], place, n_valid, fractions, step, percentile)
    mean, error = _mean_and_error(percentile, z)
    seen = step * np.arange(1, n_blocks + 1, dtype=np.int64)
    return RunningPercentiles(seen, percentile, mean, error)


def first_converged(error, target):
    """Number of percentile values after which every error is below the target.

    error (..., K): convergence errors of all levels and percentiles.
    Returns the smallest such k (1-based, at least MIN_VALUES), or None.
    """
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
def _percentiles_backwards(ordered, place, n_valid, fractions, step, percentile):
    """Fill percentile (P, K) (modified) by taking samples away from the last to the first.

    ordered (n,): all values sorted, NaN last. place (n,): position of sample i in `ordered`.
    The values still present form a linked list, so a percentile's place moves by a few links per
    block: the whole takes a time proportional to n.
    """
    before = np.arange(-1, n_valid - 1)
    after = np.arange(1, n_valid + 1)
    at = np.zeros(len(fractions), dtype=np.int64)  # position in `ordered`, per percentile
    index = np.zeros(len(fractions), dtype=np.int64)  # its number among the values present
    present = n_valid
    for block in range(percentile.shape[1] - 1, -1, -1):
        if present == 0:
            return
        for p in range(len(fractions)):
            virtual = (present - 1) * fractions[p]
            _walk(p, int(virtual), before, after, at, index)
            a = ordered[at[p]]
            b = ordered[after[at[p]]] if index[p] + 1 < present else a
            percentile[p, block] = _interpolate(a, b, virtual - index[p])
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
