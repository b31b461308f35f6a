"""`python -m evidence.identify`: search for the paper's disk, test its conclusions, write the page.

Every evaluation is kept in FOLDER/evaluations.jsonl. The same command goes on with what is missing.
"""

import os

os.environ.update({f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "NUMBA")})

import argparse
import sys
from pathlib import Path

from evidence.identify import disks, paper, report, search
from evidence.identify.book import Book, BudgetSpentError
from evidence.page import DOCS

N_DISKS = 8  # of the set that the conclusions are tested on


def main(argv=None):
    """Search, test, report; returns the exit code."""
    options = parse(argv)
    path = options.folder / "evaluations.jsonl"
    try:
        book = Book(path, options.cores)
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    parts = (lambda: run(book, options)), (lambda: close(book))
    for part, minutes in zip(parts, options.minutes, strict=True):
        book.give(60 * minutes)
        try:
            part()
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
    more(
        "--minutes",
        type=float,
        nargs=2,
        default=(float("inf"),) * 2,
        metavar=("SEARCH", "CLOSE"),
        help="given to the search, and to what follows; 0: none",
    )
    more("--points", type=int, default=128, help="of the whole range, a power of two")
    more("--generations", type=int, default=5, help="of 8 disks in a turn")
    more("--turns", type=int, default=30, help="around the best disk; every fourth: variations")
    return parser.parse_args(argv)


def run(book, options):
    """The search, in an order that never changes."""
    trials = search.whole_range(book, options.points)
    everything = disks.BOUNDS | disks.VARIATIONS
    trials = together(trials, search.line(book, options.points))
    for turn in range(options.turns):
        bounds = everything if turn % 4 == 3 else disks.BOUNDS
        start = next(trial.disk for trial in trials if trial.disk.is_plain)
        found = search.around(book, start, bounds, options.generations, seed=search.SEED + turn)
        trials = together(trials, found)


def together(trials, others):
    """All of them, the best first; a disk met twice may have come further the second time."""
    furthest = {t.disk: t for t in sorted([*trials, *others], key=lambda t: t.n_stages)}
    return sorted(furthest.values(), key=lambda t: t.order)


def close(book):
    """The best disks in other draws, and what the paper concludes tested on some."""
    # some came to the stage before the last when that was the last
    book.measure([(paper.STAGES[-1], disk, 0) for disk in book.of(paper.STAGES[-2])])
    trials = search.finished(book)
    contenders = search.contenders(trials)
    search.repeat(book, contenders)
    leaders = search.leaders(book, trials)
    losses = search.losses(book, leaders[0].disk)
    print(f"the best disk in other draws: loss {losses.mean():.1f} ± {losses.std(ddof=1):.1f}")
    # of the best disk and, last of the contenders, the reference before
    book.measure([("predictions", trial.disk, 0) for trial in (leaders[0], contenders[-1])])
    tested = search.to_test(trials, losses, N_DISKS)
    book.measure([("conclusions", trial.disk, 0) for trial in tested])


if __name__ == "__main__":
    sys.exit(main())
