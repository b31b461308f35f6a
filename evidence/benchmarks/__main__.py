"""`python -m evidence.benchmarks [SECTION ...]`: measure, write the report and its figure."""

import os

os.environ.update({f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "NUMBA")})

import pickle
import platform
import sys
import time
from pathlib import Path

from evidence.benchmarks import kernel_speed, report, sample_cost, work_precision

FOLDER = Path(__file__).parent
MEASURED = FOLDER.parent / "build" / "benchmarks.pickle"


def kernel():
    return {"kernel": kernel_speed.measure()}


def sample():
    whole, parts = sample_cost.whole_samples(), sample_cost.parts()
    return {"parts": parts, "whole": whole, "shortcuts": sample_cost.shortcuts()}


def size():
    return {"scaling": sample_cost.scaling()}


def start():
    return {"start": sample_cost.start_up(), "memory": sample_cost.memory()}


def ranks():
    return {"ranks": sample_cost.ranks()}


def precision():
    with work_precision.pool_of_two() as pool:
        results = work_precision.measure(pool)
        return {"results": results, "periodic": work_precision.periodic_errors(pool)}


SECTIONS = kernel, sample, size, start, ranks, precision


def measure(names):
    """Measure the sections of these names, all for none, and take the others as they were."""
    again = [section for section in SECTIONS if section.__name__ in names]
    out = pickle.loads(MEASURED.read_bytes()) if again else {}
    began = time.time()
    for section in again or SECTIONS:
        print(section.__name__, flush=True)
        out |= section()
    if not again:
        out["minutes"] = (time.time() - began) / 60.0
    return out | {"again": [section.__name__ for section in again]}


def main():
    """Measure all, or the sections named, or with --report none, and write the report."""
    if "--report" not in sys.argv:
        MEASURED.parent.mkdir(exist_ok=True)
        MEASURED.write_bytes(pickle.dumps(measure(sys.argv[1:])))
    m = pickle.loads(MEASURED.read_bytes())
    again = f"; measured once more by itself: {', '.join(m['again'])}" if m["again"] else ""
    text = "\n".join((
        "# Benchmark report\n",
        f"Written by `make bench` in {m['minutes']:.0f} minutes on a virtual machine with "
        f"{os.cpu_count()} cores\n({processor()}), Python {platform.python_version()}, one thread "
        f"per core{again}.\n",
        report.kernel_section(m["kernel"]),
        report.precision_section(m["results"], m["periodic"]),
        "![Work-precision diagram](work_precision.png)\n",
        report.cost_section(m),
    ))  # fmt: skip
    report.precision_figure(m["results"], m["periodic"], FOLDER / "work_precision.png")
    (FOLDER / "report.md").write_text(text)
    print(text)
    print(f"{FOLDER}/report.md, {m['minutes']:.0f} minutes")


def processor():
    """Kind of processor and its widest vectors."""
    try:
        flags = Path("/proc/cpuinfo").read_text()
    except OSError:
        flags = ""
    widest = [name for name in ("avx512f", "avx2") if name in flags]
    return ", ".join([platform.machine(), *widest[:1]])


if __name__ == "__main__":
    main()
