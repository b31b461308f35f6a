"""Patterns of blade types around a disk, and which of them are better than others.

Patterns that differ by a rotation alone are one, a *necklace*.
"""

from collections.abc import Iterator
from math import gcd

import numpy as np

N_RESAMPLED = 400  # times the disks are resampled for the interval of a difference
LOW_END = 0.5  # percentile of these: 99 % intervals, because there are several looks


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
    random ones fill the list.
    """
    if count(n_blades, n_types) - n_types <= most:
        return [word for word in necklaces(n_blades, n_types) if len(set(word)) > 1]
    found: dict[tuple[int, ...], None] = {}
    for period in (p for p in range(2, n_blades) if n_blades % p == 0):
        for word in necklaces(period, n_types):
            if len(set(word)) > 1 and len(found) < most:
                found[word * (n_blades // period)] = None
    drawn = np.random.Generator(np.random.Philox(seed))
    while len(found) < most:
        word = first_rotation(tuple(drawn.integers(n_types, size=n_blades).tolist()))
        if len(set(word)) > 1:
            found[word] = None
    return list(found)


def compare(values: np.ndarray, percentile: float) -> tuple[np.ndarray, np.ndarray]:
    """Percentiles of patterns, and how much worse than the best of them each is for certain.

    values: of the same disks with every pattern (P, n); infinite where a disk has no result.
    Returns percentiles (P,); low ends of the 99 % intervals of their difference to the lowest (P,):
    above zero for a pattern that is worse. Resampled disks are those of all patterns together.
    """
    n = values.shape[1]
    rank = int(np.ceil(percentile / 100.0 * (n - 1)))
    drawn = np.random.Generator(np.random.Philox(n)).integers(n, size=(N_RESAMPLED, n))
    again = np.array([np.partition(values[:, row], rank, axis=1)[:, rank] for row in drawn])
    known = np.partition(values, rank, axis=1)[:, rank]
    with np.errstate(invalid="ignore"):  # infinite ones differ by infinity
        apart = np.nan_to_num(again - again[:, [int(np.argmin(known))]], nan=np.inf, posinf=np.inf)
    return known, np.percentile(apart, LOW_END, axis=0, method="lower")
