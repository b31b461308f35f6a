"""Search for the values of a key at which a probability crosses a target.

The same disks are drawn at every value. One disk at all values shows where the response is largest
and smallest. Some disks at a few of the values, and by bisection between them, give a *guess* on
which side of the target each probability lies. Only the values at a crossing are then made
*certain*: disks are added until the interval of the probability lies on one side of the target, or
until no number of disks that the study may draw can show it, after which the crossing is sought
further on the safe side. Each step depends only on the disks computed so far, so that a run resumed
after an interruption takes the same steps.
"""

from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.special import ndtr

from hpcrub.statistics.percentiles import probability_interval, side_of
from hpcrub.statistics.rare import n_to_be_below

Z = 2.5758  # normal quantile of each test of a value: 99 %, because tests are repeated
FIRST_DISKS = 20  # disks of a value in its first test
GROWTH = 1.5  # largest factor of the number of disks from one test to the next
COARSE = 5  # values that are always tested, spread evenly
PEAKS = 4  # most values that one disk shows to be tested, too, on either side of the limit
WORTHWHILE = 0.5  # part of the target: a probability above takes too many disks to be told from it
TRIED_AGAIN = 1.5  # of the disks that one value needs, about: some are tried that fail
UNSAFE_SHARE = 0.25  # disks at the unsafe end of a crossing, in parts of those at the safe end
FAR = 1.3  # times the target: a probability above takes few enough disks to be told from it
LEAST_SEVERITY = 1e-9  # of a disk that touches nothing
LEAST_SCATTER = 1e-3  # of the logarithm of severities
BELOW, UNKNOWN, ABOVE = -1, 0, 1  # as of `side_of`

needed_below = cache(lambda target, n_above: n_to_be_below(target, n_above, Z))
Look = tuple[int, int]  # index of a value, number of its disks after the test


def coarse(n: int) -> list[int]:
    """Indices of those of n values that are always tested, spread evenly, both ends included."""
    return sorted({round(k * (n - 1) / (COARSE - 1)) for k in range(COARSE)})


class Search(NamedTuple):
    """State of a search over V values of a key, with its target."""

    severity: np.ndarray  # of every disk, beyond the limit above 1; NaN: no result (V, most)
    n_done: np.ndarray  # disks computed at every value, the first ones (V,) int
    target: float  # probability [-]

    @classmethod
    def followed(cls, severity: np.ndarray, known: np.ndarray, target: float) -> "Search":
        """The search as far as its disks are known, from its beginning.

        severity: of disks (V, most); known: whether they are computed (V, most).
        """
        search = cls(severity, np.zeros(len(severity), dtype=int), target)
        n_known = np.where(known.all(axis=1), known.shape[1], known.argmin(axis=1))
        while (looks := search.next_looks()) and all(n <= n_known[value] for value, n in looks):
            for value, n in looks:
                search.n_done[value] = n
        return search

    @property
    def most(self) -> int:
        """Largest number of disks of a value."""
        return self.severity.shape[1]

    @property
    def n_above(self) -> np.ndarray:
        """Disks computed that are beyond the limit, or have no result (V,)."""
        computed = zip(self.severity, self.n_done, strict=True)
        return np.array([np.count_nonzero(~(row[:n] <= 1.0)) for row, n in computed], dtype=int)

    def sides(self) -> np.ndarray:
        """Side of the target on which each probability lies: BELOW, ABOVE or UNKNOWN (V,)."""
        return side_of(self.target, self.n_above, self.n_done, Z)

    def expected(self) -> np.ndarray:
        """Probability at each value as its disks let expect, counted or extrapolated (V,).

        It is one that so many disks beyond the limit, or none, exceed as often as not.
        It decides which disks are computed next, and no result. NaN without a first test.
        """
        found = np.full(len(self.n_done), np.nan)
        medians = probability_interval(self.n_above, self.n_done, 0.0)
        for value in np.flatnonzero(self.n_done >= self._first):
            row = self.severity[value, : self.n_done[value]]
            low, high = medians[:, value]
            found[value] = low
            if not low:
                size = np.log(np.maximum(row, LEAST_SEVERITY))
                found[value] = min(high, ndtr(size.mean() / max(size.std(), LEAST_SCATTER)))
        return found

    def guesses(self) -> np.ndarray:
        """Side on which each probability is supposed to lie; UNKNOWN without a first test (V,).

        A value is supposed to be above the target, too, where it is so close to it that its disks
        can hardly show the contrary, or not at all.
        """
        sides, expected = self.sides(), self.expected()
        guess = np.where(expected < WORTHWHILE * self.target, BELOW, ABOVE)
        for value in np.flatnonzero((guess == BELOW) & (sides != BELOW)):
            if needed_below(self.target, int(self.n_above[value])) > self.most:
                guess[value] = ABOVE
        guess = np.where(sides != UNKNOWN, sides, guess)
        return np.where(self.n_done < self._first, UNKNOWN, guess)

    def landmarks(self) -> list[int]:
        """Values that are always tested: some spread evenly, and the extremes of the first disk.

        An extreme is the largest severity of a range of values beyond the limit, or the smallest of
        one within, and both of all values.
        """
        size = np.log(np.clip(self.severity[:, 0], LEAST_SEVERITY, None))
        size[np.isnan(size)] = np.inf
        ends = [0, *(np.flatnonzero(np.diff(size > 0.0)) + 1), len(size)]
        ranges = (np.arange(*bounds) for bounds in pairwise(ends))
        extremes = [int(r[np.abs(size[r]).argmax()]) for r in ranges]
        extremes.sort(key=lambda value: -abs(size[value]))
        found = {int(size.argmax()), int(size.argmin())}
        for beyond in (True, False):
            found |= set([v for v in extremes if (size[v] > 0.0) == beyond][:PEAKS])
        return sorted(found | set(coarse(len(size))))

    def next_looks(self) -> list[Look]:
        """Values to test next, each with its number of disks then; none at the end."""
        if new := self._first_looks():
            return new
        guess = self.guesses()
        crossings = self._supposed(guess)
        if not crossings:  # the value nearest to the target speaks for all
            expected, seen = self.expected(), np.flatnonzero(guess)
            all_below = guess[seen[0]] == BELOW
            of_seen = expected[seen]
            crossings = [(int(seen[of_seen.argmax() if all_below else of_seen.argmin()]),) * 2]
        looks: dict[int, int] = {}
        for pair in crossings:
            looks |= self._to_be_certain(pair, guess)
        return sorted(looks.items()) or self._narrower()

    def _first_looks(self) -> list[Look]:
        """First tests of values, as long as neighbours are not known on either side."""
        if not self.n_done.all():
            # spread over the range, by the digits of a number read backwards, as costs differ
            new = sorted(np.flatnonzero(self.n_done == 0).tolist(), key=lambda v: f"{v:b}"[::-1])
            return [(value, 1) for value in new]
        first = self._first
        if new := [value for value in self.landmarks() if self.n_done[value] < first]:
            return [(value, first) for value in new]
        crossings = self._supposed(self.guesses())
        return [((a + b) // 2, first) for a, b in crossings if b - a > 1]

    def _supposed(self, guess: np.ndarray) -> list[tuple[int, int]]:
        """Neighbours among the values with a guess that are on different sides."""
        seen = [int(value) for value in np.flatnonzero(guess)]
        return [(a, b) for a, b in pairwise(seen) if guess[a] != guess[b]]

    def crossings(self) -> list[tuple[int, int]]:
        """Indices of neighbouring certain values on different sides, in increasing order."""
        sides = self.sides()
        certain = [int(value) for value in np.flatnonzero(sides)]
        return [(a, b) for a, b in pairwise(certain) if sides[a] != sides[b]]

    def doubtful(self) -> np.ndarray:
        """Values supposed on the other side than all certain ones; none at a crossing (any,)."""
        sides = self.sides()
        others = self.guesses() == -sides.sum().clip(BELOW, ABOVE)
        return np.flatnonzero(others & (sides == UNKNOWN) & (not self.crossings()) & sides.any())

    def still_expected(self) -> np.ndarray:
        """Disks that are probably still computed at every value, those of `next_looks` too (V,)."""
        guess, n_values, first = self.guesses(), len(self.n_done), self._first
        more = np.zeros(n_values)
        for value, n in self.next_looks():
            more[value] = n - self.n_done[value]
        if not self._first_looks():
            for pair in self._supposed(guess):
                unsafe, safe = sorted(pair, key=lambda value: -guess[value])
                if self.sides()[safe] == UNKNOWN:
                    needed = self._needed(safe)
                    more[safe] = TRIED_AGAIN * (needed - self.n_done[safe])
                    if self.sides()[unsafe] == UNKNOWN:
                        more[unsafe] = max(UNSAFE_SHARE * needed - self.n_done[unsafe], 0.0)
        else:
            widest = max((b - a for a, b in self._supposed(guess)), default=n_values)
            halvings = min(np.log2(widest), np.count_nonzero(self.n_done < first))
            after = TRIED_AGAIN * min(needed_below(self.target, 0), self.most) + halvings * first
            if self.n_done.all():  # about where the first disk crosses the limit
                size = np.abs(np.log(np.clip(self.severity[:, 0], LEAST_SEVERITY, None)))
                more[np.nan_to_num(size, nan=np.inf).argmin()] += after
            else:
                more[coarse(n_values)] += first - 1
                more += after / n_values
        return np.minimum(more, self.most - self.n_done)

    @property
    def _first(self) -> int:
        return min(FIRST_DISKS, self.most)

    def _needed(self, value: int) -> int:
        """Disks with which a value is certainly below if no more of them exceed the limit."""
        n_above = int(self.n_above[value])
        return min(max(needed_below(self.target, n_above), self.n_done[value]), self.most)

    def _to_be_certain(self, pair: tuple[int, ...], guess: np.ndarray) -> dict[int, int]:
        """Tests of the values at a crossing, the safe one first; empty once they are certain.

        Where the unsafe one is too close to the target, one further away makes up for it.
        """
        unsafe, safe = sorted(pair, key=lambda value: -guess[value])
        sides, most = self.sides(), self.most
        if guess[safe] == BELOW:
            if sides[safe] == UNKNOWN:
                return {safe: min(self._grown(safe), self._needed(safe))}
            most = max(int(UNSAFE_SHARE * self.n_done[safe]), self._first)
        step = np.sign(unsafe - safe) or len(sides)
        while 0 <= unsafe < len(sides) and sides[unsafe] == UNKNOWN and guess[unsafe] != BELOW:
            if not 0 <= unsafe + step < len(sides):  # there is none further away
                most = self.most
            if self.n_done[unsafe] < most:
                return {unsafe: min(self._grown(unsafe), most)}
            unsafe += step
        return {}

    def _narrower(self) -> list[Look]:
        """Further disks of a value within a crossing of more than two steps, if it may be told.

        Every value within gets as many as the safe end has, and more where it is far enough.
        """
        sides, n, over = self.sides(), self.n_done, self.expected() / self.target
        for a, b in self.crossings():
            inside = np.arange(a + 1, b)[:: 1 if sides[a] == BELOW else -1]  # safe ones first
            safe = a if sides[a] == BELOW else b
            may_be = (over[inside] > FAR) & (n[inside] < self.most) | (n[inside] < n[safe])
            if b - a > 2 and may_be.any():
                value = int(inside[may_be.argmax()])
                return [(value, min(self._grown(value), self.most))]
        return []

    def _grown(self, value: int) -> int:
        return max(int(np.ceil(GROWTH * self.n_done[value])), self._first)
