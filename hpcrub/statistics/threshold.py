"""Where a probability crosses a target along the values of a key: which disks to compute next.

At every value the same disks are drawn. A value is *certain* once the interval of its probability
lies on one side of the target; samples go where that is not so yet, value by value, and bisection
leaves out the rest. What comes next depends on what is known alone, so that a run that goes on
after an interruption takes the same way.
"""

from typing import NamedTuple

import numpy as np

from hpcrub.statistics.percentiles import probability_interval

Z = 2.5758  # of every look at a value: 99 %, because there are several looks
FIRST = 20  # disks of a value at first
GROWTH = 1.5  # of their number from one look to the next
COARSE = 5  # values that are looked at in any case: does the probability rise and fall again?
BELOW, UNKNOWN, ABOVE = -1, 0, 1


class Search(NamedTuple):
    """Values of a key, what is known of them, and what is asked for."""

    n_done: np.ndarray  # disks computed at every value (V,) int
    n_above: np.ndarray  # those beyond the limit (V,) int
    target: float  # probability [-]
    most: int  # disks of a value

    def sides(self) -> np.ndarray:
        """Whether each probability is certainly BELOW or ABOVE the target, else UNKNOWN (V,)."""
        ends = [probability_interval(int(k), int(n), Z) if n else (0.0, 1.0)
                for k, n in zip(self.n_above, self.n_done, strict=True)]  # fmt: skip
        low, high = np.array(ends).T
        return np.where(high < self.target, BELOW, np.where(low > self.target, ABOVE, UNKNOWN))

    def is_final(self) -> np.ndarray:
        """Whether no more disks are needed at a value (V,)."""
        return (self.sides() != UNKNOWN) | (self.n_done >= self.most)

    def next_look(self) -> tuple[int, int] | None:
        """The next value to look at, and its number of disks then; None: nothing is left to do."""
        n, last = len(self.n_done), len(self.n_done) - 1
        final, sides = self.is_final(), self.sides()
        for value in sorted({round(k * last / (COARSE - 1)) for k in range(COARSE)}):
            if not final[value]:
                return self._more(value)
        for side in (sides[0], sides[last]) if n > 1 else ():
            value = self._boundary(sides, final, side)
            if value is not None:
                return self._more(value)
        return None

    def crossing(self) -> tuple[int, int] | None:
        """Neighbouring certain values on either side of the crossing; None: there is none."""
        sides = self.sides()
        if UNKNOWN in (sides[0], sides[-1]) or sides[0] == sides[-1]:
            return None
        begin = np.flatnonzero(sides == sides[0])
        end = int(np.flatnonzero(sides == sides[-1]).min())
        return int(begin[begin < end].max()), end

    def is_monotone(self) -> bool:
        """Whether the certain values change sides once at most."""
        certain = self.sides()
        certain = certain[certain != UNKNOWN]
        return int(np.count_nonzero(np.diff(certain))) <= 1

    def _boundary(self, sides, final, side):
        """Value to look at between the last one certain on a side and the first final other one.

        None where these are neighbours, or where both ends are on one side.
        """
        if sides[0] == sides[-1] or side == UNKNOWN:
            return None
        order = np.arange(len(sides)) if side == sides[0] else np.arange(len(sides))[::-1]
        other = next(i for i, v in enumerate(order) if final[v] and sides[v] != side)
        mine = max(i for i in range(other) if sides[order[i]] == side)
        if other - mine <= 1:
            return None
        between = order[mine + 1 : other]
        begun = [v for v in between if self.n_done[v] > 0]
        return int(begun[0] if begun else between[(len(between) - 1) // 2])

    def _more(self, value):
        more = max(FIRST, int(np.ceil(GROWTH * self.n_done[value])))
        return value, min(more, self.most)
