"""Status of a point (one speed of one sample), and reasons against its result.

A reason says why a point has no result, or one to be careful with. Result files hold the codes,
which therefore never change their meaning.
"""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

NO_POINT, STEADY, NOT_STEADY, DIVERGED, AVERAGED = range(5)  # status of a point

# reasons; only the stress tests, which audit the energy of every run, give BALANCE
NONE, NOT_FINITE, TOO_LARGE, UNSOLVED, JAMMING, NOT_UNIQUE, UNPROVEN, BALANCE = range(8)
PERMANENT, FLUTTER, REVERSED, RUNAWAY, GROWING, NOT_FED, BENT = 8, 9, 10, 11, 12, 13, 14
WORDS = (
    "none",
    "diverged: a displacement is not finite",
    "diverged: displacements larger than the disk",
    "diverged: contact forces not found",
    "diverged: jamming, a contact force would pull its blade further in",
    "diverged: contact forces not unique, friction is too high for this disk and step",
    "contact forces found, but not shown to be unique",
    "diverged: the energy audit does not close",
    "permanent contact: a blade does not leave the casing, no amplitude",
    "flutter by friction in permanent contact, no amplitude",
    "a tip vibrates faster than it rotates: friction would reverse, and does not",
    "diverged: a wave of the casing grows without bound",
    "still growing: the motion will change into another one",
    "diverged: a wave of the casing grows that is faster than the rotor, by friction or the step",
    "no result: blades bend further than an expansion to second order can tell",
)
# meaning of the codes in result files
POINT_STATUS = (
    "0 none, 1 steady, 2 not steady within the time limit, 3 no result, as point_reason says: "
    "values are NaN; 4 averaged: followed until the mean of its windows was known"
)
POINT_REASON = "; ".join(f"{code} {words}" for code, words in enumerate(WORDS))
OF_CASING = RUNAWAY, NOT_FED  # reasons with a wave of the casing that grows
FATAL = (
    NOT_FINITE, TOO_LARGE, UNSOLVED, JAMMING, NOT_UNIQUE, BALANCE, PERMANENT, FLUTTER, *OF_CASING,
    BENT,
)  # fmt: skip


def are_fatal(codes: npt.ArrayLike) -> np.ndarray:
    """Whether points with these reasons have no result; codes of any shape."""
    return np.isin(codes, FATAL)


def words(code: int) -> str:
    """Text of a reason; a damaged file may hold a code that is unknown."""
    return WORDS[code] if code < len(WORDS) else f"unknown reason {code}"


def count(codes: npt.ArrayLike) -> np.ndarray:
    """Number of points with each reason; codes of any shape, of which unknown ones are left out."""
    return np.bincount(np.ravel(codes), minlength=len(WORDS))[: len(WORDS)]


def lines(counts: npt.ArrayLike, n_points: int) -> Iterator[str]:
    """Yield a line of text for each reason among n_points points; counts: from `count`."""
    for code, n in enumerate(np.asarray(counts)):
        if code != NONE and n:
            yield f"{n} of {n_points} points: {WORDS[code]}"
