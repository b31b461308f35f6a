"""Run all studies of the paper, or go on with them, and hold them against its numbers.

Writes docs/reproduction.md. At 1 % of the samples it takes some minutes, at more of them as much
longer; every step tells what is left of it.
"""

import argparse
import subprocess
import sys
import time

from evidence import page, program
from evidence.reproduce import plan, report
from hpcrub.ranks.progress import duration


def main(argv=None):
    """Run and report; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m evidence.reproduce", description=__doc__)
    parser.add_argument("--scale", type=float, default=0.01, help="of the paper's sample counts")
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--report-only", action="store_true", help="run nothing")
    options = parser.parse_args(argv)
    folder = page.ROOT / "results" / f"reproduction_{options.scale:g}"
    if not options.report_only:
        for step in plan.STEPS:
            code = run(step, folder, options)
            if code:
                print(f"{step.name} ended with code {code}; the same command goes on from here")
                return code
    report.write(folder, options.scale, page.DOCS / "reproduction.md")
    return 0


def run(step, folder, options):
    """Run one step, or the rest of it; returns the exit code."""
    began = time.monotonic()
    print(f"--- {step.name}", flush=True)
    ranks = options.ranks if options.ranks > 1 else 0
    words = plan.arguments(step, folder, options.scale)
    try:
        program.run(ranks, page.ROOT / "main.py", *words, "--resume")
    except subprocess.CalledProcessError as ended:
        return ended.returncode
    print(f"--- {step.name}: {duration(time.monotonic() - began)}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
