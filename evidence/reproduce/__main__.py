"""Run all studies of the paper, or go on with them, and hold them against its numbers.

Writes docs/reproduction.md. At 1 % of the samples it takes some minutes, at more of them as much
longer; every step tells what is left of it.
"""

import argparse
import subprocess
import sys

from evidence import page, program, progress
from evidence.reproduce import plan, report


def main(argv=None):
    """Run and report; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m evidence.reproduce", description=__doc__)
    parser.add_argument("--scale", type=float, default=0.01, help="of the paper's sample counts")
    parser.add_argument("--ranks", type=int, default=2)
    options = parser.parse_args(argv)
    folder = page.ROOT / "results" / f"reproduction_{options.scale:g}"
    ranks = options.ranks if options.ranks > 1 else 0
    names = [step.name for step in plan.STEPS]
    for step in progress.followed(plan.STEPS, "studies", names=names):
        words = plan.arguments(step, folder, options.scale)
        try:
            program.run(ranks, page.ROOT / "main.py", *words, "--resume")
        except subprocess.CalledProcessError as ended:
            print(f"{step.name}: {ended}; the same command goes on from here")
            return ended.returncode
    report.write(folder, options.scale, page.DOCS / "reproduction.md")
    return 0


if __name__ == "__main__":
    sys.exit(main())
