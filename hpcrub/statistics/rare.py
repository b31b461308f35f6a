"""A small probability by double sampling: a cheap first look at all disks, a full result of some.

Every disk gets a first look; it is computed in full with an inclusion probability π that follows
from the look alone. The disks beyond the limit among these, each counted 1/π times, estimate the
probability without bias, whatever the look is worth (Horvitz, Thompson, J. Am. Stat. Assoc. 47,
1952; Neyman, J. Am. Stat. Assoc. 33, 1938). A look that tells much makes it cheap: π is then large
where the look is high, and small elsewhere. Results are *severities*: the largest amplitude or
stress as a part of its limit, so that a disk is beyond a limit when its severity is above 1.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import gammainccinv, gammaincinv, ndtr

TAIL = 0.025  # of each end of a 95 % interval
LEAST = 0.5, 0.25, 0.125, 0.0625, 0.03125  # smallest inclusion probabilities that are tried
FACTORS = 0.0625 * 2.0 ** np.arange(13)  # that are tried
MOST = 1e12  # disks
# of the disks beyond a limit, those whose look tells nothing: a motion in contact seldom repeats
# itself. At first one of five, which the disks found to be beyond the limit correct.
ASTRAY, ASTRAY_OF = 1.0, 5.0


class Goal(NamedTuple):
    """When a probability is known well enough; None: not asked for."""

    error: float | None  # half of the interval, relative to the probability
    below: float | None  # the interval lies on one side of it

    def is_met(self, chance: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Whether probabilities with their intervals' ends, all of one shape, are known."""
        met = np.full(np.shape(chance), True)
        if self.error is not None:
            met &= (chance > 0.0) & (high - low <= 2.0 * self.error * chance)
        if self.below is not None:
            met &= (high < self.below) | (low > self.below)
        return met


class Rule(NamedTuple):
    """Inclusion probabilities of disks by their first look.

    The severity is taken for log-normal about a power of the look, but for some disks, which may be
    beyond the limit whatever the look says. That may be wrong: it changes how many disks are
    needed, and never what the estimate tends to.
    """

    slope: float = 0.0  # of the logarithm of the severity over that of the look
    offset: float = 0.0  # of that straight line
    scatter: float = 1.0  # standard deviation about it
    factor: float = 1.0
    least: float = 1.0
    astray: float = 0.0  # probability to be beyond the limit whatever the look says

    def chance(self, look: np.ndarray) -> np.ndarray:
        """Probability that disks with these looks (n,) are beyond the limit; 1 without a look."""
        known = np.isfinite(look) & (look > 0.0)
        line = self.offset + self.slope * np.log(look, where=known, out=np.zeros(len(look)))
        return np.where(known, np.minimum(ndtr(line / self.scatter) + self.astray, 1.0), 1.0)

    def inclusion(self, look: np.ndarray) -> np.ndarray:
        """Probability with which disks with these looks (n,) are computed in full."""
        return np.clip(self.factor * np.sqrt(self.chance(look)), self.least, 1.0)


class Plan(NamedTuple):
    """A rule, and what is expected of it."""

    rule: Rule
    n_disks: float  # that the goal needs
    cost: float  # of these, in the unit of the costs given
    saving: float  # this cost over that of plain sampling


def estimate(above: np.ndarray, inclusion: np.ndarray) -> tuple[float, float, float]:
    """Probability, and both ends of its 95 % interval, from n disks drawn alike.

    - above: whether a disk is known to be beyond the limit (n,), False where not computed.
    - inclusion: probability with which each was computed (n,), known before it was.
    """
    weight, n = 1.0 / inclusion[above], len(above)
    if not n:
        return np.nan, 0.0, 1.0
    total, squares = weight.sum(), (weight * weight).sum()
    low, high = interval(total, squares, 1.0 / inclusion.mean(), n)
    return float(total / n), float(low), float(high)


def interval(
    total: npt.ArrayLike, squares: npt.ArrayLike, next_one: npt.ArrayLike, n: npt.ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the 95 % interval of a probability from weighted counts, all of one shape.

    - total, squares: sum of the weights and of their squares of all events among n disks.
    - next_one: weight that one more event would have.

    The counts are taken for Poisson variables, whose variance is a little above the binomial one.
    Of weights that are all 1 the ends are those of Garwood. Fay and Feuer give the next event the
    largest weight of all. Here it is that of an event whose look tells nothing, one over the mean
    inclusion probability: less by half or more, and still too much where a higher look makes an
    event more probable. Source: Fay, Feuer, Stat. Med. 16 (1997).
    """
    total, squares, next_one = map(np.asarray, (total, squares, next_one))
    some = np.maximum(total, 1e-300)
    scale = np.maximum(squares, 1e-300) / some
    low = np.where(total > 0.0, scale * gammaincinv(some / scale, TAIL), 0.0)
    one_more = total + next_one
    scale = (squares + next_one * next_one) / one_more
    high = scale * gammainccinv(one_more / scale, TAIL)
    return np.minimum(low / n, 1.0), np.minimum(high / n, 1.0)


def n_needed(
    goal: Goal, chance: float, squares: npt.ArrayLike, next_one: npt.ArrayLike
) -> np.ndarray:
    """Disks that a goal needs, where the sums of the weights are what is expected.

    - chance: probability.
    - squares: mean over all disks of the squared weights of events, of any shape.
    - next_one: as of `interval`, of this shape.

    Returns numbers of this shape, at most MOST. Plain sampling has squares = chance, next_one = 1.
    """
    squares = np.asarray(squares)
    low, high = np.zeros(np.shape(squares)), np.full(np.shape(squares), np.log(MOST))
    for _ in range(40):
        n = np.exp((low + high) / 2.0)
        ends = interval(n * chance, n * squares, next_one, n)
        met = goal.is_met(np.full(np.shape(n), chance), *ends)
        low, high = np.where(met, low, np.log(n)), np.where(met, np.log(n), high)
    return np.ceil(np.exp(high) - 1e-6)


def plan(
    look: np.ndarray,
    severity: np.ndarray,
    inclusion: np.ndarray,
    costs: tuple[float, float],
    goal: Goal,
) -> Plan:
    """The rule that is expected to meet a goal at the least cost, and the least number of disks.

    - look: of all disks so far (n,).
    - severity: of those of them that were computed in full, NaN of others (n,). Which these are has
      to follow from the looks alone.
    - inclusion: probability with which each was computed (n,).
    - costs: of a look and of a full result.

    Of factors and smallest inclusion probabilities all are tried; plain sampling, which has no look
    to pay for, is one of them.
    """
    known = np.isfinite(severity) & (severity > 0.0) & np.isfinite(look) & (look > 0.0)
    x, y = np.log(look[known]), np.log(severity[known])
    slope = np.cov(x, y)[0, 1] / x.var(ddof=1) if len(x) > 2 and np.ptp(x) > 0.0 else 0.0
    offset = y.mean() - slope * x.mean() if len(x) else 0.0
    scatter = np.std(y - offset - slope * x, ddof=2) if len(x) > 2 else 1.0
    line = Rule(float(slope), float(offset), float(max(scatter, 1e-6)))
    above = severity > 1.0
    line = line._replace(astray=_astray(line.chance(look), above, 1.0 / inclusion[above]))
    chance = line.chance(look)
    rules = [Rule()] + [line._replace(factor=f, least=p) for p in LEAST for f in FACTORS]
    share, squares = np.array([_expected(rule.inclusion(look), chance) for rule in rules]).T
    n = n_needed(goal, float(chance.mean()), squares, 1.0 / share)
    cost = n * (costs[1] * share + costs[0] * (np.arange(len(rules)) > 0))
    best = int(cost.argmin())
    return Plan(rules[best], float(n[best]), float(cost[best]), float(cost[best] / cost[0]))


def _expected(inclusion, chance):
    """Mean inclusion probability, and mean squared weight of events."""
    return inclusion.mean(), (chance / inclusion).mean()


def _astray(chance, above, weight):
    """Probability to be beyond the limit whatever the look says.

    By maximum likelihood of the looks of the disks beyond it, as if ASTRAY of ASTRAY_OF had been
    seen before. chance: by the looks alone (n,); weight: of those above.
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
    """Probabilities to exceed values (X,) by distributions that are fitted to severities (n,).

    weight: how many disks each one stands for (n,); runs: of the bootstrap. Returns the percentiles
    2.5, 50 and 97.5 of the probabilities (3, X) by name. Sources: Castanier, Pierre, J. Propuls.
    Power 22 (2006), on the Weibull distribution of largest values, which has an upper end;
    Pickands, Ann. Stat. 3 (1975), on what is above the 90th percentile.
    """
    from scipy.stats import genpareto, weibull_max  # half a second, where it is drawn alone

    rng, share = np.random.default_rng(0), weight / weight.sum()
    n = min(int(1.0 / (share * share).sum()), len(severity))
    unit = np.median(severity)  # the fits start from values about 1
    severity, at = severity / unit, at / unit
    weibull, pareto = np.full((2, runs, len(at)), np.nan)
    for run in range(runs):
        drawn = rng.choice(severity, n, p=share)
        weibull[run] = weibull_max.sf(at, *weibull_max.fit(drawn))
        least = np.quantile(drawn, 0.9)
        beyond = drawn[drawn > least] - least
        if len(beyond):  # else the largest are all alike
            shape = genpareto.fit(beyond, floc=0.0)
            pareto[run] = np.where(at > least, 0.1 * genpareto.sf(at - least, *shape), np.nan)
    ends = [2.5, 50.0, 97.5]
    return {
        "three-parameter Weibull": np.percentile(weibull, ends, axis=0),
        "generalised Pareto": np.percentile(pareto, ends, axis=0),
    }
