"""Why a point (one speed of one sample) has no result, or one to be taken with care."""

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
