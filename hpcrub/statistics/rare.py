"""Small probability: when it is known well enough, and how many disks that takes."""

import bisect
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hpcrub.statistics.percentiles import Z_95, probability_interval, side_of

# Normal quantile of an interval that is held against a target again and again as disks are added,
# 99.5 %: the side of a probability that is the target itself is then named wrongly once in forty
# studies.
Z_OF_TESTS = 2.807
MOST_DISKS = 10**12  # largest number of disks


class Goal(NamedTuple):
    """Accuracy at which a probability is known well enough; None: not required."""

    error: float | None  # half of the 95 % interval, relative to the probability
    below: float | None  # probability that the interval of the tests must not contain

    def side(self, n_above: npt.ArrayLike, n: npt.ArrayLike) -> np.ndarray:
        """Whether probabilities are certainly below (-1) or above (1) the target, or neither.

        n_above: number of events among n independent disks, of any shape.
        """
        return side_of(np.nan if self.below is None else self.below, n_above, n, Z_OF_TESTS)

    def is_met(self, n_above: npt.ArrayLike, n: npt.ArrayLike) -> np.ndarray:
        """Whether probabilities are known well enough from n_above events among n disks."""
        met = np.full(np.shape(n_above), True)
        if self.error is not None:
            (low, high), chance = probability_interval(n_above, n, Z_95), np.divide(n_above, n)
            met &= (chance > 0.0) & (high - low <= 2.0 * self.error * chance)
        if self.below is not None:
            met &= self.side(n_above, n) != 0
        return met


@lru_cache  # every copy of an input asks for the number
def n_needed(goal: Goal, chance: float) -> int:
    """Number of disks that a goal needs if so many events occur as are expected.

    chance: probability of an event. The number is at most MOST_DISKS.
    """
    numbers = range(1, MOST_DISKS)
    return 1 + bisect.bisect_left(numbers, True, key=lambda n: bool(goal.is_met(n * chance, n)))


def n_to_be_below(target: float, n_above: int, z: float) -> int:
    """Number of disks, n_above of them beyond a limit, that show a probability below the target.

    z: normal quantile of the interval, as in `probability_interval`. The number is at most
    MOST_DISKS. Without a disk beyond the limit it is -ln(tail)/target, 5.3/target of 99 %.
    """
    below = lambda n: bool(probability_interval(n_above, n, z)[1] < target)  # noqa: E731
    numbers = range(n_above + 1, MOST_DISKS)
    return n_above + 1 + bisect.bisect_left(numbers, True, key=below)
