"""`python -m evidence.same_bits OLD.h5 NEW.h5 ...`: do result files hold the same bits?

Every dataset of the first file is compared with that of the others, bit by bit, but those on the
programs that have computed it. Ends with 1 when any differs. To be run before and after a change
that must not change results.
"""

import argparse
import sys

import numpy as np

import hpcrub


def differences(old, new):
    """Lines about the datasets of a result file that another one lacks, or has otherwise."""
    with hpcrub.open(old) as first, hpcrub.open(new) as second:
        names = [n for n in first if n.rpartition("/")[2] not in ("programs", "program")]
        for name in names:
            if name not in second:
                yield f"{new} lacks {name}"
                continue
            a, b = np.asarray(first[name]), np.asarray(second[name])
            if a.shape != b.shape or a.tobytes() != b.tobytes():
                yield f"{name}: {_how_far(a, b)}"


def _how_far(a, b):
    if a.shape != b.shape:
        return f"{a.shape} and {b.shape}"
    far = f", by up to {np.nanmax(abs(a - b)):.3g}" if a.dtype.kind in "fiu" else ""
    differ = (a != b) & ~((a != a) & (b != b))  # NaN beside NaN is the same
    return f"{np.count_nonzero(differ)} of {a.size} values differ{far}"


def main(argv=None):
    """Compare and report; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m evidence.same_bits", description=__doc__)
    parser.add_argument("old", metavar="OLD.h5")
    parser.add_argument("new", metavar="NEW.h5", nargs="+")
    options = parser.parse_args(argv)
    n_different = 0
    for new in options.new:
        found = list(differences(options.old, new))
        n_different += len(found)
        print(f"{new}: " + ("the same bits" if not found else f"{len(found)} datasets differ"))
        for line in found:
            print(f"  {line}")
    return 1 if n_different else 0


if __name__ == "__main__":
    sys.exit(main())
