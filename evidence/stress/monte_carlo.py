"""Does a convergence error say how wrong a percentile is? Many small studies of one population.

The population is a large pool of amplifications. A study draws from it with replacement, so that
the true percentiles are those of the pool and a repetition costs nothing.
"""

from typing import NamedTuple

import numpy as np

from evidence import page
from evidence.truth.disk import LOAD, reference_reduced, reference_scene
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.linear import linear_peak
from hpcrub.statistics.percentiles import running_intervals, running_percentiles

SEED = 2021
PERCENTILES = (1, 50, 99)
STEP, Z = 10, 2.81  # of the paper
HALF_RANGE = 0.04


class Spread(NamedTuple):
    """What many studies of one size give, for every percentile (P,)."""

    true: np.ndarray  # percentiles of the population
    deviation: np.ndarray  # standard deviation of the estimates
    stated: np.ndarray  # mean of equation (6), which is Z standard deviations
    covered_6: np.ndarray  # share of studies whose estimate ± (6) holds the true percentile
    covered_interval: np.ndarray  # share whose interval of order statistics does
    half_width: np.ndarray  # mean half width of these intervals; NaN where an end is missing


def linear_amplifications(n):
    """Linear amplifications of n mistuned samples (n,)."""
    reduced, scene = reference_reduced(), reference_scene()
    load = LOAD, scene.n_bumps, scene.interface

    def peak(half_range, sample):
        deviation = stiffness_deviation(SEED, 0, sample, 12, half_range)
        modes = mistuned_modes(reduced, deviation)
        return linear_peak(modes, scene.damping_ratio, *load, 12)[0]

    return np.array([peak(HALF_RANGE, sample) for sample in range(n)]) / peak(0.0, 0)


def drawn(pool, n, repetitions):
    """Studies (repetitions, n) of samples drawn from the pool with replacement."""
    rng = np.random.default_rng([SEED, n])
    return np.array([pool[rng.integers(0, len(pool), n)] for _ in range(repetitions)])


def spread(pool, studies):
    """Spread of studies (repetitions, n) from a pool."""
    true = np.percentile(pool, PERCENTILES)
    rows = [_study(values, true) for values in studies]
    estimate, stated, covered, inside, width = (np.array(x) for x in zip(*rows, strict=True))
    return Spread(
        true,
        estimate.std(axis=0),
        stated.mean(axis=0),
        covered.mean(axis=0),
        inside.mean(axis=0),
        width.mean(axis=0),
    )


def _study(values, true):
    running = running_percentiles(values, PERCENTILES, STEP, Z)
    low, high = (end[:, -1] for end in running_intervals(values, PERCENTILES, STEP, Z))
    estimate, stated = running.percentile[:, -1], running.convergence_error[:, -1]
    inside = ~(true < low) & ~(true > high)  # a missing end excludes nothing
    return estimate, stated, np.abs(estimate - true) <= stated, inside, (high - low) / 2.0


def table(populations):
    """Markdown table; populations: (name, pool, studies), studies a list of (repetitions, n)."""
    heads = [
        "population",
        "studies",
        "samples",
        "percentile",
        "true value",
        "Z times true deviation",
    ]
    heads += ["mean of (6)", "(6) holds the truth", "interval holds it", "half width of interval"]
    rows = []
    for name, pool, groups in populations:
        for studies in groups:
            s = spread(pool, studies)
            for p, percentile in enumerate(PERCENTILES):
                wide = f"{s.half_width[p]:.4f}" if np.isfinite(s.half_width[p]) else "open end"
                rows.append(
                    [name, *map(str, studies.shape), f"{percentile}", f"{s.true[p]:.3f}"]
                    + [f"{x[p]:.4f}" for x in (Z * s.deviation, s.stated)]
                    + [f"{100 * x[p]:.1f} %" for x in (s.covered_6, s.covered_interval)]
                    + [wide]
                )
    return page.table(heads, rows)
