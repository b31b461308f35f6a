"""Compare tests of the steady state and Monte-Carlo errors.

Writes the tables and the figure of docs/steady_state.md in 10 minutes.
"""

import argparse
from pathlib import Path

import numpy as np

from evidence import page
from evidence.stress import histories, monte_carlo, steady_state
from hpcrub.statistics.percentiles import percentile_interval
from hpcrub.studies.files import open_result

PAGE = page.DOCS / "steady_state.md"
SAMPLES = 64  # of every level, contact
POOL = 20_000  # linear amplifications
REPETITIONS = 2000
TARGET = 0.005  # half width asked for
GROUPS = (64, 300)  # samples of the independent studies


def main():
    """Simulate, compare, write; or read a result file."""
    parser = argparse.ArgumentParser(prog="python -m evidence.stress.measure", description=__doc__)
    parser.add_argument(
        "--results",
        type=Path,
        help="finished contact study: only cut its samples of the largest deviation up",
    )
    path = parser.parse_args().results
    if path:
        page.replace(PAGE, groups=groups_table(path))
    else:
        measure()


def groups_table(path):
    """Table of independent studies from a result file, failed samples left out."""
    results = open_result(path)
    values = results.read("samples/amplification")[-1]
    results.close()
    values = values[np.isfinite(values)]
    studies = [monte_carlo.disjoint(values, n) for n in GROUPS]
    low, high = percentile_interval(values, (99,), monte_carlo.Z)
    half = (high[0] - low[0]) / 2.0
    return (
        f"{monte_carlo.table([('contact', values, studies)])}\n"
        f"The interval of percentile 99 with all {len(values)} samples has the half width "
        f"{half:.4f}; {TARGET} takes about {len(values) * (half / TARGET) ** 2:,.0f} samples."
    )


def measure():
    """Simulate, compare, write."""
    h = histories.simulate(SAMPLES, print)
    contact = steady_state.amplifications(h, steady_state.judge(h, steady_state.PAPER))
    populations = [
        (name, pool, [monte_carlo.drawn(pool, n, REPETITIONS) for n in sizes])
        for name, pool, sizes in (
            ("linear", monte_carlo.linear_amplifications(POOL), (100, 500, 2000)),
            ("contact", contact[-1], (40,)),
        )
    ]
    page.replace(PAGE, tests=steady_state.table(h), studies=monte_carlo.table(populations))
    steady_state.draw(h, page.DOCS / "figures" / "steady_state.png")


if __name__ == "__main__":
    main()
