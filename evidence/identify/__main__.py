"""`python -m evidence.identify`: search for the paper's disk, test its conclusions, write the page.

Every evaluation is kept in FOLDER/evaluations.jsonl. The same command goes on with what is missing.
"""

import os

os.environ.update({f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "NUMBA")})

import argparse
import sys
from pathlib import Path

from evidence.identify import disks, report, search
from evidence.identify.book import Book, BudgetSpentError
from evidence.page import DOCS

N_DISKS = 20  # of the set that the conclusions are tested on


def main(argv=None):
    """Search, test, report; returns the exit code."""
    options = parse(argv)
    path = options.folder / "evaluations.jsonl"
    try:
        book = Book(path, options.cores, 60 * options.minutes)
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    if not options.report_only:
        try:
            run(book, options)
        except BudgetSpentError:
            print("the time given is over; the same command goes on from here")
    if search.finished(book):
        print(report.write(book, DOCS))
    return 0


def parse(argv):
    """Options of the command line."""
    parser = argparse.ArgumentParser(
        prog="python -m evidence.identify",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    more = parser.add_argument
    more("--folder", type=Path, default=Path(__file__).parent, help="of the evaluations")
    more("--cores", type=int, default=1, help="evaluations side by side, each on one core")
    more("--minutes", type=float, default=float("inf"), help="time given")
    more("--points", type=int, default=256, help="of the whole range, a power of two")
    more("--generations", type=int, nargs=2, default=(12, 16), metavar=("PLAIN", "VARIED"),
         help="of disks: of the reference model, then with variations")  # fmt: skip
    more("--report-only", action="store_true", help="compute nothing, write the page")
    return parser.parse_args(argv)


def run(book, options):
    """All evaluations, in an order that never changes."""
    plain, varied = options.generations
    best = search.whole_range(book, options.points)[0]
    best = min([best, *search.around(book, best.disk, disks.BOUNDS, plain)], key=lambda t: t.order)
    search.around(book, best.disk, disks.BOUNDS | disks.VARIATIONS, varied)
    trials = search.finished(book)
    leaders = search.leaders(trials)
    for leader in leaders:
        search.repeat(book, leader.disk)
    losses = search.losses(book, trials[0].disk)
    print(f"the best disk in other draws: loss {losses.mean():.1f} ± {losses.std(ddof=1):.1f}")
    tested = search.to_test(trials, losses, N_DISKS)
    book.measure([("conclusions", trial.disk, 0) for trial in tested])
    book.measure([("predictions", leader.disk, 0) for leader in leaders])


if __name__ == "__main__":
    sys.exit(main())
