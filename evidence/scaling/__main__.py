"""Measure how a study scales here, simulate many ranks; writes docs/scaling.md (10 min).

What is measured is kept in build/scaling.pickle.
"""

import argparse
import pickle
import sys
import time

from evidence import page
from evidence.scaling import costs, growth, program, report, simulate
from hpcrub.response import sweep

MEASURED = page.ROOT / "build" / "scaling.pickle"
SAMPLES = 24  # measured of each case, whole and in parts


def measure():
    """Everything that is measured, as one dictionary."""
    began = time.time()
    sweep.warm_up()
    found = {}
    print("costs of samples", flush=True)
    found["costs"] = {n: costs.measure(n, SAMPLES) for n in costs.CASES}
    print("messages, writing", flush=True)
    found["exchange"], found["noting"] = program.messages(), costs.noting()
    found["sizes"], found["writing"] = costs.sizes(), program.writing()
    machine = found["machine"] = simulate.Machine(
        receive=found["exchange"] * 2 / 3 + found["noting"],
        send=found["exchange"] / 3,
        finish=found["costs"][4].finish + found["writing"][2, "independent"],
    )
    print("the program on ranks of this machine", flush=True)
    found["sleeping"] = program.sleeping(found["costs"][4])
    found["studies"] = program.whole_studies(found["costs"][4], machine)
    print("statistics, memory, files", flush=True)
    found |= growing()
    return found | {"minutes": (time.time() - began) / 60.0}


def growing():
    """The part of it that grows with the samples."""
    return {
        "statistics": (*growth.statistics_alone(), growth.statistics_written()),
        "memory": growth.memory(),
        "laying out": growth.laying_out(),
        "looks": growth.looks(),
        "files": growth.file_sizes(),
    }


def main(argv=None):
    """Measure, simulate, write; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m evidence.scaling", description=__doc__)
    parser.add_argument("--report", action="store_true", help="take what was measured before")
    again = not parser.parse_args(argv).report
    if not (again or MEASURED.exists()):
        parser.error(f"nothing has been measured yet: there is no {MEASURED}")
    if again:
        MEASURED.parent.mkdir(exist_ok=True)
        MEASURED.write_bytes(pickle.dumps(measure()))
    found = pickle.loads(MEASURED.read_bytes())
    print("simulation", flush=True)
    table = report.simulations(found)
    figures = page.DOCS / "figures"
    report.efficiency_figure(found, table, figures / "scaling.png")
    report.cost_figure(found["costs"], figures / "sample_costs.png")
    told = f"\nMeasured in {found['minutes']:.0f} minutes with {page.machine()}.\n"
    page.replace(page.DOCS / "scaling.md", results=report.text(found, table) + told)
    print(page.DOCS / "scaling.md")
    return 0


if __name__ == "__main__":
    sys.exit(main())
