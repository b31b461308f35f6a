"""`python -m evidence.same_bits OLD.h5 NEW.h5`: do two result files hold the same bits?

Every dataset of the first file is compared with that of the other, bit by bit, but those on the
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
            a, b = (np.asarray(file[name]) if name in file else None for file in (first, second))
            if b is None or a.shape != b.shape:
                yield f"{name}: {a.shape} and {'missing' if b is None else b.shape}"
            elif a.tobytes() != b.tobytes():
                far = f", by up to {np.nanmax(abs(a - b)):.3g}" if a.dtype.kind in "fiu" else ""
                differ = (a != b) & ~((a != a) & (b != b))  # NaN beside NaN is the same
                yield f"{name}: {np.count_nonzero(differ)} of {a.size} values differ{far}"


def main(argv=None):
    """Compare and report; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m evidence.same_bits", description=__doc__)
    parser.add_argument("old", metavar="OLD.h5")
    parser.add_argument("new", metavar="NEW.h5")
    options = parser.parse_args(argv)
    found = list(differences(options.old, options.new))
    print("\n".join(found) if found else "the same bits")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
