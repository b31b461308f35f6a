"""Why a point (one speed of one sample) has no result, or one to be taken with care."""

import numpy as np

NONE, NOT_FINITE, TOO_LARGE, UNSOLVED, SELF_LOCKING, NOT_UNIQUE, UNPROVEN, UNBALANCED = range(8)
WORDS = (
    "none",
    "diverged: a displacement is not finite",
    "diverged: displacements larger than the disk",
    "diverged: contact forces not found",
    "diverged: self-locking, a contact force would pull its blade further in",
    "diverged: contact forces not unique, friction is too high for this disk and step",
    "contact forces found, but not shown to be unique",
    "diverged: the energy audit does not close",
)
FATAL = (NOT_FINITE, TOO_LARGE, UNSOLVED, SELF_LOCKING, NOT_UNIQUE, UNBALANCED)


def are_fatal(codes):
    """Whether the points of these codes have no result; codes and answer of any shape."""
    return np.isin(codes, FATAL)


def words(code):
    """The words of a code, which a damaged file may make up."""
    return WORDS[code] if code < len(WORDS) else f"unknown reason {code}"


def count(codes):
    """How often every reason occurs among codes of any shape; codes without words are left out."""
    return np.bincount(np.ravel(codes), minlength=len(WORDS))[: len(WORDS)]


def lines(counts, n_points):
    """What went wrong in n_points points, in words; counts: as `count` returns."""
    for code, n in enumerate(counts):
        if code != NONE and n:
            yield f"{n} of {n_points} points: {WORDS[code]}"
