"""Enumeration and comparison of patterns of blade types around a disk.

Patterns that differ only by a rotation count as one, a *necklace*.
"""

from collections.abc import Iterator
from math import gcd

import numpy as np
from scipy.special import bdtr

ERROR = 0.005  # probability that a round wrongly calls any pattern worse; ten rounds: 5 %


def necklaces(n_blades: int, n_types: int) -> Iterator[tuple[int, ...]]:
    """Yield all patterns of types 0 ... n_types − 1, sorted, each as its smallest rotation.

    Source: Fredricksen and Maiorana, Discrete Mathematics 23 (1978); algorithm of Duval (1983).
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
    """Number of patterns that `necklaces` yields (Burnside)."""
    return sum(n_types ** gcd(turn, n_blades) for turn in range(n_blades)) // n_blades


def first_rotation(word: tuple[int, ...]) -> tuple[int, ...]:
    """Smallest rotation of a word, which stands for its pattern."""
    return min(word[turn:] + word[:turn] for turn in range(len(word)))


def candidates(n_blades: int, n_types: int, most: int, seed: int) -> list[tuple[int, ...]]:
    """Patterns of two or more types to try: all of them, or `most` if there are more.

    If there are more, patterns that repeat themselves around the disk come first, the shortest
    periods first; then random patterns.
    """
    if count(n_blades, n_types) - n_types <= most:
        return [word for word in necklaces(n_blades, n_types) if len(set(word)) > 1]
    words = dict[tuple[int, ...], None]()
    for period in (p for p in range(2, n_blades) if n_blades % p == 0):
        for word in necklaces(period, n_types):
            if len(set(word)) > 1 and len(words) < most:
                words[word * (n_blades // period)] = None
    drawn = np.random.Generator(np.random.Philox(seed))
    while len(words) < most:
        word = first_rotation(tuple(drawn.integers(n_types, size=n_blades).tolist()))
        if len(set(word)) > 1:
            words[word] = None
    return list(words)


def compare(values: np.ndarray, percentile: float) -> tuple[np.ndarray, np.ndarray]:
    """Percentiles of patterns, and how much worse than the best pattern each certainly is.

    A sign test counts the disks that exceed the percentile of the best pattern with only one of
    two patterns. The low end is the amount by which a pattern's values can be lowered until the
    test no longer separates it from the best. The error is divided among all ordered pairs, because
    the values also choose the best. With few disks, the percentile that the test uses as its limit
    lies below or above the true percentile of the best.

    values: of the same disks with every pattern (P, n); infinite where a disk has no result.
    Returns percentiles (P,); low ends of their difference to the lowest (P,): above zero for a
    pattern that is worse, −inf where the disks are too few to tell.
    """
    n_patterns, n = values.shape
    rank = int(np.ceil(percentile / 100.0 * (n - 1)))
    known = np.partition(values, rank, axis=1)[:, rank]
    best, low = int(np.argmin(known)), np.full(n_patterns, -np.inf)
    above = values[best] > known[best]
    taken = np.arange(1, n + 1)
    for p in range(n_patterns):
        order = np.argsort(-values[p], kind="stable")
        both = np.cumsum(above[order])  # among the disks with the largest values of p
        alone, best_alone = taken - both, above.sum() - both
        told = bdtr(best_alone, alone + best_alone, 0.5) * n_patterns**2 <= ERROR
        if told.any() and np.isfinite(known[best]):
            low[p] = values[p, order[np.argmax(told)]] - known[best]
    low[best] = 0.0
    return known, low
