"""`python -m evidence.scaling`: measure, simulate, write the tables and figures of docs/scaling.md.

With --report the last measurement is taken.
"""

import os

os.environ.update({f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "NUMBA")})

import pickle
import platform
import re
import sys
import time
from pathlib import Path

from evidence.scaling import costs, growth, program, report, simulate
from hpcrub.response import sweep

ROOT = Path(__file__).resolve().parents[2]
MEASURED = ROOT / "build" / "scaling.pickle"
PAGE = ROOT / "docs" / "scaling.md"
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


def main():
    """Measure, simulate, write."""
    if "--report" not in sys.argv:
        MEASURED.parent.mkdir(exist_ok=True)
        MEASURED.write_bytes(pickle.dumps(measure()))
    found = pickle.loads(MEASURED.read_bytes())
    print("simulation", flush=True)
    table = report.simulations(found)
    figures = ROOT / "docs" / "figures"
    report.efficiency_figure(found, table, figures / "scaling.png")
    report.cost_figure(found["costs"], figures / "sample_costs.png")
    text = PAGE.read_text(encoding="utf-8")
    results = report.text(found, table) + (
        f"\nMeasured in {found['minutes']:.0f} minutes with {os.cpu_count()} cores, "
        f"{platform.machine()}, Python {platform.python_version()}.\n"
    )
    block = re.compile(r"(?<=<!-- results -->\n).*?(?=<!-- end of results -->)", re.DOTALL)
    PAGE.write_text(block.sub(lambda _: results, text), encoding="utf-8")
    print(PAGE)


if __name__ == "__main__":
    main()
