"""Measure how a study scales here, simulate many ranks; writes docs/scaling.md (5 min).

What is measured is kept in build/scaling.pickle.
"""

import argparse
import pickle
import sys
import tempfile
import time
from pathlib import Path

from evidence import page
from evidence.scaling import costs, program, report

MEASURED = page.ROOT / "build" / "scaling.pickle"
SAMPLES = 6  # measured of each case, whole and in parts
EACH = 10  # samples per level of the whole studies
RANKS = 1, 2, 4, 8  # of the whole studies
SMALL = {  # 9 speeds: two parts
    "casing.n_bumps": 6, "speeds.from_hz": 22.0, "speeds.to_hz": 22.4, "reduction.n_modes": 12,
    "mistuning.half_range_percent": [4.0], "mistuning.tuned_runs": 2,
}  # fmt: skip


def measure(cases, n_samples, n_each, all_ranks):
    """Everything that is measured, as one dictionary.

    cases: configurations; n_samples: of each case; n_each, all_ranks: samples per level and numbers
    of ranks of whole studies.
    """
    began = time.time()
    costs.measure(cases[0], 1)  # compiles
    print("costs of samples", flush=True)
    by_bumps = sorted(cases, key=lambda case: case.casing.n_bumps)
    found = {"costs": {c.casing.n_bumps: costs.measure(c, n_samples) for c in by_bumps}}
    print("messages", flush=True)
    found["receive"], found["send"] = program.messages()
    print("the program on ranks of this machine", flush=True)
    found["studied"] = cases[0].casing.n_bumps
    found["studies"] = program.whole_studies(cases[0], n_each, all_ranks)
    return found | {"minutes": (time.time() - began) / 60.0}


def main(argv=None):
    """Measure, simulate, write; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m evidence.scaling", description=__doc__)
    parser.add_argument("--report", action="store_true", help="take what was measured before")
    parser.add_argument("--fast", action="store_true",
                        help="the whole way with one sample, without the page (20 s)")  # fmt: skip
    options = parser.parse_args(argv)
    if options.fast:
        found = measure([costs.case(SMALL)], 1, 1, (1, 2))
        with tempfile.TemporaryDirectory() as folder:
            print(write(found, Path(folder), (2, 8)))
        return 0
    if options.report and not MEASURED.exists():
        parser.error(f"nothing has been measured yet: there is no {MEASURED}")
    if not options.report:
        MEASURED.parent.mkdir(exist_ok=True)
        MEASURED.write_bytes(pickle.dumps(measure(costs.paper(), SAMPLES, EACH, RANKS)))
    found = pickle.loads(MEASURED.read_bytes())
    print("simulation", flush=True)
    text = write(found, page.DOCS / "figures", report.RANKS)
    told = f"\nMeasured in {found['minutes']:.0f} minutes with {page.machine()}.\n"
    page.replace(page.DOCS / "scaling.md", results=text + told)
    print(page.DOCS / "scaling.md")
    return 0


def write(found, figures, all_ranks):
    """Draw the figures into a folder; returns the text of the page."""
    table = report.simulations(found, all_ranks)
    report.efficiency_figure(found, table, figures / "scaling.png")
    report.cost_figure(found["costs"], figures / "sample_costs.png")
    return report.text(found, table)


if __name__ == "__main__":
    sys.exit(main())
