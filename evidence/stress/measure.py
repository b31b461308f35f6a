"""``python -m evidence.stress.measure``: the numbers of docs/steady_state.md (10 min).

With ``--results FILE``, a finished contact study of many samples, only the table of independent
studies, from its samples of the largest deviation.
"""

import argparse
import re
from pathlib import Path

import numpy as np

from evidence.stress import histories, monte_carlo, steady_state
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import percentile_interval

DOCS = Path(__file__).parents[2] / "docs"
SAMPLES = 64  # of every level, contact
POOL = 20_000  # linear amplifications
REPETITIONS = 2000
TARGET = 0.005  # half width asked for
GROUPS = (64, 300)  # samples of the independent studies


def main():
    """Simulate, compare, write; or read a result file."""
    parser = argparse.ArgumentParser(description="what docs/steady_state.md says")
    parser.add_argument("--results", type=Path, help="result file of a contact study to cut up")
    path = parser.parse_args().results
    if path:
        write({"groups": groups_table(path)})
    else:
        measure()


def groups_table(path):
    """Table of independent studies from a result file, failed samples left out."""
    results = ResultFile.open(path)
    values = results.read("samples/amplification")[-1]
    results.close()
    values = values[np.isfinite(values)]
    studies = [monte_carlo.disjoint(values, n) for n in GROUPS]
    low, high = percentile_interval(values, (99,), monte_carlo.Z)
    half = (high[0] - low[0]) / 2.0
    return (
        f"{monte_carlo.table([('contact', values, studies)])}\n\n"
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
    write({"tests": steady_state.table(h), "studies": monte_carlo.table(populations)})
    steady_state.draw(h, DOCS / "figures" / "steady_state.png")


def write(tables):
    """Put tables into their places in the page, {name: Markdown}."""
    page = DOCS / "steady_state.md"
    text = page.read_text(encoding="utf-8")
    for name, table in tables.items():
        block = re.compile(f"(?<=<!-- {name} -->\n).*?(?=<!-- end of {name} -->)", re.DOTALL)
        text = block.sub(lambda _, table=table: table + "\n", text)
    page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
