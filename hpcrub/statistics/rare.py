"""Double sampling of a small probability: a cheap first look at all disks, full results of some.

The first look at a disk alone decides its inclusion probability π, with which the disk is computed
in full. Fully computed disks beyond the limit, each counted 1/π times, give an estimate without
bias, however little the look tells (Horvitz, Thompson, J. Am. Stat. Assoc. 47, 1952; Neyman, J. Am.
Stat. Assoc. 33, 1938). A good look makes the estimate cheap: π is then large where the look is
high, and small elsewhere. Results are *severities*: the largest amplitude or stress as a part of
its limit, so that a disk is beyond a limit when its severity is above 1.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import gammainccinv, gammaincinv, ndtr

TAIL = 0.025  # probability beyond each end of a 95 % interval
# The same for an interval that is held against a target again and again as disks are added: the
# side of a probability that is the target itself is then named wrongly once in forty studies.
TAIL_OF_TESTS = 0.0025
LEAST = 0.5, 0.25, 0.125, 0.0625, 0.03125  # smallest inclusion probabilities that are tried
FACTORS = 0.0625 * 2.0 ** np.arange(13)  # factors of a `Rule` that are tried
MOST = 1e12  # largest number of disks
# Disks beyond a limit whose look tells nothing, because a motion in contact seldom repeats itself:
# one of five is assumed before any disk is computed.
ASTRAY, ASTRAY_OF = 1.0, 5.0


class Counts(NamedTuple):
    """Weighted counts of events among independent disks, all of one shape."""

    total: npt.ArrayLike  # sum of the weights of the events
    squares: npt.ArrayLike  # sum of their squares
    next_one: npt.ArrayLike  # weight that one more event would have
    n: npt.ArrayLike  # number of disks


class Goal(NamedTuple):
    """Accuracy at which a probability is known well enough; None: not required."""

    error: float | None  # half of the 95 % interval, relative to the probability
    below: float | None  # probability that the interval of the tests must not contain

    def side(self, counts: Counts) -> np.ndarray:
        """Whether probabilities are certainly below (-1) or above (1) the target, or neither."""
        low, high = interval(counts, TAIL_OF_TESTS)
        target = np.nan if self.below is None else self.below
        return (low > target).astype(int) - (high < target)

    def is_met(self, counts: Counts) -> np.ndarray:
        """Whether probabilities are known well enough from counts."""
        met = np.full(np.shape(counts.total), True)
        if self.error is not None:
            (low, high), chance = interval(counts), np.divide(counts.total, counts.n)
            met &= (chance > 0.0) & (high - low <= 2.0 * self.error * chance)
        if self.below is not None:
            met &= self.side(counts) != 0
        return met


class Rule(NamedTuple):
    """Inclusion probabilities of disks as a function of their first look.

    The rule assumes that the severity is log-normal about a power of the look, except for some
    disks that may be beyond the limit whatever the look says. A wrong assumption changes how many
    disks are needed, but never what the estimate tends to.
    """

    slope: float = 0.0  # of log(severity) over log(look)
    offset: float = 0.0  # log(severity) at look 1
    scatter: float = 1.0  # standard deviation of log(severity) about the line
    factor: float = 1.0  # of the inclusion probability
    least: float = 1.0  # smallest inclusion probability
    astray: float = 0.0  # probability of being beyond the limit whatever the look says

    def chance(self, look: np.ndarray) -> np.ndarray:
        """Probability that disks with the looks (n,) are beyond the limit; 1 without a look."""
        known = np.isfinite(look) & (look > 0.0)
        line = self.offset + self.slope * np.log(look, where=known, out=np.zeros(len(look)))
        return np.where(known, np.minimum(ndtr(line / self.scatter) + self.astray, 1.0), 1.0)

    def inclusion(self, look: np.ndarray) -> np.ndarray:
        """Inclusion probabilities of disks with the looks (n,)."""
        return np.clip(self.factor * np.sqrt(self.chance(look)), self.least, 1.0)


class Plan(NamedTuple):
    """A rule with its expected cost."""

    rule: Rule
    n_disks: float  # number of disks that the goal needs
    cost: float  # cost of n_disks, in the unit of the costs given
    saving: float  # cost over the cost of plain sampling


def count(above: np.ndarray, inclusion: np.ndarray) -> Counts:
    """Counts of n independent disks.

    - above: whether a disk is known to be beyond the limit (n,), False where not computed.
    - inclusion: inclusion probability of each disk (n,), fixed before the disk is computed.
    """
    weight = 1.0 / inclusion[above]
    return Counts(weight.sum(), (weight * weight).sum(), 1.0 / inclusion.mean(), len(above))


def estimate(counts: Counts) -> tuple[float, float, float]:
    """Probability and both ends of its 95 % interval."""
    low, high = interval(counts)
    return float(np.divide(counts.total, counts.n)), float(low), float(high)


def interval(counts: Counts, tail: float = TAIL) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the interval of a probability; tail: probability beyond each end.

    The counts are treated as Poisson variables, whose variance is a little above the binomial
    variance. If all weights are 1, the ends are those of Garwood. Fay and Feuer give the next event
    the largest weight of all. Callers here take the weight of an event whose look tells nothing:
    one over the mean inclusion probability. It is smaller by half or more, and still too large if a
    higher look makes an event more probable. Source: Fay, Feuer, Stat. Med. 16 (1997).
    """
    total, squares, next_one, n = map(np.asarray, counts)
    some = np.maximum(total, 1e-300)
    scale = np.maximum(squares, 1e-300) / some
    low = np.where(total > 0.0, scale * gammaincinv(some / scale, tail), 0.0)
    one_more = total + next_one
    scale = (squares + next_one * next_one) / one_more
    high = scale * gammainccinv(one_more / scale, tail)
    return np.minimum(low / n, 1.0), np.minimum(high / n, 1.0)


def n_needed(
    goal: Goal, chance: float, squares: npt.ArrayLike, next_one: npt.ArrayLike
) -> np.ndarray:
    """Number of disks that a goal needs if the sums of the weights have their expected values.

    - chance: probability of an event.
    - squares: mean over all disks of the squared weights of events, of any shape.
    - next_one: see `Counts`; of the shape of squares.

    Returns numbers of that shape, at most MOST. Plain sampling has squares = chance, next_one = 1.
    """
    squares = np.asarray(squares)
    low, high = np.zeros(np.shape(squares)), np.full(np.shape(squares), np.log(MOST))
    for _ in range(40):
        n = np.exp((low + high) / 2.0)
        met = goal.is_met(Counts(n * chance, n * squares, next_one, n))
        low, high = np.where(met, low, np.log(n)), np.where(met, np.log(n), high)
    return np.ceil(np.exp(high) - 1e-6)


def plan(
    look: np.ndarray,
    severity: np.ndarray,
    lost: np.ndarray,
    inclusion: np.ndarray,
    costs: tuple[float, float],
    goal: Goal,
) -> Plan:
    """Rule that is expected to meet a goal at the least cost.

    - look: of all disks so far (n,).
    - severity: of the disks that were computed in full, NaN of the others (n,). The choice of these
      disks must depend on the looks alone.
    - lost: whether a disk computed in full has no result, which counts as beyond the limit (n,).
    - inclusion: inclusion probability of each disk (n,).
    - costs: of a look and of a full result.

    All combinations of FACTORS and LEAST are tried, and plain sampling, which needs no looks.
    """
    known = np.isfinite(severity) & (severity > 0.0) & np.isfinite(look) & (look > 0.0)
    x, y = np.log(look[known]), np.log(severity[known])
    slope = np.cov(x, y)[0, 1] / x.var(ddof=1) if len(x) > 2 and np.ptp(x) > 0.0 else 0.0
    offset = y.mean() - slope * x.mean() if len(x) else 0.0
    scatter = np.std(y - offset - slope * x, ddof=2) if len(x) > 2 else 1.0
    line = Rule(float(slope), float(offset), float(max(scatter, 1e-6)))
    above = severity > 1.0
    astray = _astray(line.chance(look), above, 1.0 / inclusion[above])
    astray += float((1.0 / inclusion[lost]).sum() / len(look))
    line = line._replace(astray=astray)
    chance = line.chance(look)
    rules = [Rule()] + [line._replace(factor=f, least=p) for p in LEAST for f in FACTORS]
    inclusions = [rule.inclusion(look) for rule in rules]
    share = np.array([each.mean() for each in inclusions])
    squares = np.array([(chance / each).mean() for each in inclusions])  # over all disks
    n = n_needed(goal, float(chance.mean()), squares, 1.0 / share)
    cost = n * (costs[1] * share + costs[0] * (np.arange(len(rules)) > 0))
    best = int(cost.argmin())
    return Plan(rules[best], float(n[best]), float(cost[best]), float(cost[best] / cost[0]))


def _astray(chance, above, weight):
    """Probability of being beyond the limit whatever the look says.

    It maximises the likelihood of the looks of the disks beyond the limit, as if ASTRAY of
    ASTRAY_OF disks had been seen before. chance: from the looks alone (n,); weight: of those disks.
    """
    mean, share = max(float(chance.mean()), 1e-300), ASTRAY / ASTRAY_OF
    odds, weight = chance[above] / mean, weight * (len(weight) / max(weight.sum(), 1e-300))
    for _ in range(20):
        belongs = share / (share + (1.0 - share) * odds)
        share = (ASTRAY + float((weight * belongs).sum())) / (ASTRAY_OF + len(odds))
    return share / (1.0 - share) * mean


def extrapolated(
    severity: np.ndarray, weight: np.ndarray, at: np.ndarray, runs: int = 20
) -> dict[str, np.ndarray]:
    """Probabilities of exceeding values (X,), from distributions fitted to severities (n,).

    The severities must not all be equal.

    weight: number of disks that each stands for (n,); runs: of the bootstrap. Returns percentiles
    2.5, 50 and 97.5 of the probabilities, {name: (3, X)}. Sources: Castanier, Pierre, J. Propuls.
    Power 22 (2006), on the Weibull distribution of largest values, which has an upper end;
    Pickands, Ann. Stat. 3 (1975), on what is above the 90th percentile.
    """
    from scipy.stats import genpareto, weibull_max  # half a second, spent for figures only

    rng, share = np.random.default_rng(0), weight / weight.sum()
    n = min(int(1.0 / (share * share).sum()), len(severity))
    unit = severity.mean()  # the fits start from values about 1
    severity, at = severity / unit, at / unit
    weibull, pareto = np.full((2, runs, len(at)), np.nan)
    for run in range(runs):
        drawn = rng.choice(severity, n, p=share)
        weibull[run] = weibull_max.sf(at, *weibull_max.fit(drawn))
        least = np.quantile(drawn, 0.9)
        beyond = drawn[drawn > least] - least
        if len(beyond):  # else the largest severities are equal
            shape = genpareto.fit(beyond, floc=0.0)
            pareto[run] = np.where(at > least, 0.1 * genpareto.sf(at - least, *shape), np.nan)
    ends = [2.5, 50.0, 97.5]
    return {
        "three-parameter Weibull": np.percentile(weibull, ends, axis=0),
        "generalised Pareto": np.percentile(pareto, ends, axis=0),
    }
