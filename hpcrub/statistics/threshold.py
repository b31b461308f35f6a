"""Search for the value of a key at which a probability crosses a target.

The same disks are drawn at every value. A value is *certain* once the interval of its probability
lies on one side of the target. The search adds disks to one uncertain value after another, and
leaves values out by bisection. Each step depends only on the disks computed so far, so that a run
resumed after an interruption takes the same steps.
"""

from typing import Any, NamedTuple

import numpy as np

from hpcrub.statistics.percentiles import side_of

Z = 2.5758  # normal quantile of each test of a value: 99 %, because tests are repeated
FIRST_DISKS = 20  # disks of a value in its first test
GROWTH = 1.5  # factor of the number of disks from one test to the next
COARSE = 5  # values that are always tested: the probability may rise and fall again
BELOW, UNKNOWN, ABOVE = -1, 0, 1  # as of `side_of`


def coarse(n: int) -> list[int]:
    """Indices of those of n values that are always tested, spread evenly, both ends included."""
    return sorted({round(k * (n - 1) / (COARSE - 1)) for k in range(COARSE)})


class Search(NamedTuple):
    """State of a search over V values of a key, with its target."""

    n_done: np.ndarray  # disks computed at every value (V,) int
    n_above: np.ndarray  # disks beyond the limit at every value (V,) int
    target: float  # probability [-]
    most: int  # largest number of disks of a value

    @classmethod
    def followed(cls, above: np.ndarray, known: np.ndarray, target: float) -> "Search":
        """The search as far as its disks are known, from its beginning.

        above: whether disks are beyond the limit (V, most) bool; known: whether they are computed.
        """
        n_done, n_above = np.zeros((2, len(above)), dtype=int)
        search = cls(n_done, n_above, target, above.shape[1])
        while (look := search.next_look()) and known[look[0], : look[1]].all():
            value, n = look
            n_done[value], n_above[value] = n, np.count_nonzero(above[value, :n])
        return search

    def sides(self) -> np.ndarray:
        """Side of the target on which each probability lies: BELOW, ABOVE or UNKNOWN (V,)."""
        return side_of(self.target, self.n_above, self.n_done, Z)

    def next_look(self) -> tuple[int, int] | None:
        """Index of the next value to test, and its number of disks then; None at the end."""
        n, last, sides = len(self.n_done), len(self.n_done) - 1, self.sides()
        final = (sides != UNKNOWN) | (self.n_done >= self.most)
        for value in coarse(n):
            if not final[value]:
                return self._more(value)
        for side in (sides[0], sides[last]) if n > 1 else ():
            value = self._boundary(sides, final, side)
            if value is not None:
                return self._more(value)
        return None

    def crossing(self) -> tuple[int, int] | None:
        """Indices of the nearest certain values on both sides of the crossing; None without one."""
        sides = self.sides()
        if UNKNOWN in (sides[0], sides[-1]) or sides[0] == sides[-1]:
            return None
        begin = np.flatnonzero(sides == sides[0])
        end = int(np.flatnonzero(sides == sides[-1]).min())
        return int(begin[begin < end].max()), end

    def is_monotone(self) -> bool:
        """Whether the certain values change sides at most once."""
        certain = self.sides()
        certain = certain[certain != UNKNOWN]
        return int(np.count_nonzero(np.diff(certain))) <= 1

    def _boundary(self, sides: Any, final: Any, side: Any) -> Any:
        """Value to test between the last value on a side and the first final value beyond it.

        None if these two are neighbours, or if both ends are on one side of the target.
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

    def _more(self, value: Any) -> tuple[Any, Any]:
        more = max(FIRST_DISKS, int(np.ceil(GROWTH * self.n_done[value])))
        return value, min(more, self.most)
