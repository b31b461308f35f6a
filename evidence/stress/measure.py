"""Compare tests of the steady state and Monte-Carlo errors.

Writes the tables and the figure of docs/steady_state.md in 10 minutes.
"""

import argparse

from evidence import page
from evidence.stress import histories, monte_carlo, steady_state

PAGE = page.DOCS / "steady_state.md"
SAMPLES = 64  # of every level, contact
POOL = 20_000  # linear amplifications
REPETITIONS = 2000


def main():
    """Simulate, compare, write."""
    argparse.ArgumentParser(
        prog="python -m evidence.stress.measure", description=__doc__
    ).parse_args()
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
