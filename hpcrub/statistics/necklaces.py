"""Patterns of blade types around a disk, and which of them are better than others.

Patterns that differ by a rotation alone are one, a *necklace*.
"""

from collections.abc import Iterator
from math import gcd

import numpy as np
from scipy.special import bdtr

UNKNOWN = -2  # type of the blades of a pattern that a search is still to tell
SEARCHED = 0.25  # of the patterns tried, where there are more than these: by a search
ERROR = 0.005  # probability that a round calls any pattern worse that is not; ten rounds: 5 %


def necklaces(n_blades: int, n_types: int) -> Iterator[tuple[int, ...]]:
    """All patterns of n_blades of types 0 ... n_types − 1, as the first of their rotations, sorted.

    Source: Fredricksen and Maiorana, Discrete Mathematics 23 (1978); steps after Duval (1983).
    """
    word = [-1]
    while word:
        word[-1] += 1
        length = len(word)
        if n_blades % length == 0:
            yield tuple(word * (n_blades // length))
        while len(word) < n_blades:
            word.append(word[-length])
        while word and word[-1] == n_types - 1:
            word.pop()


def count(n_blades: int, n_types: int) -> int:
    """Number of these patterns (Burnside)."""
    return sum(n_types ** gcd(turn, n_blades) for turn in range(n_blades)) // n_blades


def first_rotation(word: tuple[int, ...]) -> tuple[int, ...]:
    """The pattern of which a word is a rotation."""
    return min(word[turn:] + word[:turn] for turn in range(len(word)))


def candidates(n_blades: int, n_types: int, most: int, seed: int) -> list[tuple[int, ...]]:
    """Patterns to try, those of one type left out: all, or so many if there are more.

    Of more, those that repeat themselves around the disk come first, the shortest periods first;
    random ones follow, and the last ones are UNKNOWN: see `neighbours`.
    """
    if count(n_blades, n_types) - n_types <= most:
        return [word for word in necklaces(n_blades, n_types) if len(set(word)) > 1]
    searched = int(SEARCHED * most)
    most, found = most - searched, dict[tuple[int, ...], None]()
    for period in (p for p in range(2, n_blades) if n_blades % p == 0):
        for word in necklaces(period, n_types):
            if len(set(word)) > 1 and len(found) < most:
                found[word * (n_blades // period)] = None
    _fill(found, n_blades, n_types, most, seed)
    return [*found, *[(UNKNOWN,) * n_blades] * searched]


def neighbours(
    ranked: list[tuple[int, ...]], n_types: int, n: int, seed: int
) -> list[tuple[int, ...]]:
    """New patterns, each with one blade of another type than one that is known.

    - ranked: known patterns, the best first; the neighbours of the best come first.
    - n: how many new ones, random where there are no more neighbours.
    """
    found, most = dict.fromkeys(ranked), len(ranked) + n
    for word in ranked:
        for blade in range(len(word)):
            for kind in range(n_types):
                changed = first_rotation((*word[:blade], kind, *word[blade + 1 :]))
                if len(set(changed)) > 1 and len(found) < most:
                    found[changed] = None
    _fill(found, len(ranked[0]), n_types, most, seed)
    return list(found)[len(ranked) :]


def _fill(found, n_blades, n_types, most, seed):
    """Add random patterns until there are so many (found is modified)."""
    drawn = np.random.Generator(np.random.Philox(seed))
    while len(found) < most:
        word = first_rotation(tuple(drawn.integers(n_types, size=n_blades).tolist()))
        if len(set(word)) > 1:
            found[word] = None


def compare(values: np.ndarray, percentile: float) -> tuple[np.ndarray, np.ndarray]:
    """Percentiles of patterns, and how much worse than the best of them each is for certain.

    On the same disks a sign test counts those that exceed the percentile of the best with one
    pattern alone. How far a pattern can be lowered until the test no longer tells is the low end.
    The error is shared among all ordered pairs, because the values also say which is the best.
    The test compares how often this amplitude is exceeded: of few disks it is below or above the
    true percentile of the best.

    values: of the same disks with every pattern (P, n); infinite where a disk has no result.
    Returns percentiles (P,); low ends of their difference to the lowest (P,): above zero for a
    pattern that is worse, −inf where so few disks say nothing.
    """
    n_patterns, n = values.shape
    rank = int(np.ceil(percentile / 100.0 * (n - 1)))
    known = np.partition(values, rank, axis=1)[:, rank]
    best, low = int(np.argmin(known)), np.full(n_patterns, -np.inf)
    above = values[best] > known[best]
    taken = np.arange(1, n + 1)
    for p in range(n_patterns):
        order = np.argsort(-values[p], kind="stable")
        both = np.cumsum(above[order])  # of the disks that exceed most with p
        alone, best_alone = taken - both, above.sum() - both
        told = bdtr(best_alone, alone + best_alone, 0.5) * n_patterns**2 <= ERROR
        if told.any() and np.isfinite(known[best]):
            low[p] = values[p, order[np.argmax(told)]] - known[best]
    low[best] = 0.0
    return known, low
