"""`python -m benchmarks`: measure everything, write ``benchmarks/report.md`` and its figure."""

import os

os.environ.update({f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "NUMBA")})

import pickle
import platform
import sys
import time
from pathlib import Path

from benchmarks import kernel_speed, report, sample_cost, work_precision

FOLDER = Path(__file__).parent
MEASURED = FOLDER.parent / "build" / "benchmarks.pickle"


def measure():
    """Everything that the report tells, as one dictionary."""
    out = {"began": time.time()}
    print("kernel", flush=True)
    out["kernel"] = kernel_speed.measure()
    print("sample", flush=True)
    out["parts"], out["shortcuts"] = sample_cost.parts(), sample_cost.shortcuts()
    out["whole"] = sample_cost.whole_samples()
    print("size", flush=True)
    out["scaling"] = sample_cost.scaling()
    print("start, ranks", flush=True)
    out["start"], out["ranks"] = sample_cost.start_up(), sample_cost.ranks()
    out["memory"] = sample_cost.memory()
    print("run time against error", flush=True)
    with work_precision.pool_of_two() as pool:
        out["results"] = work_precision.measure(pool)
        out["periodic"] = work_precision.periodic_errors(pool)
    return out | {"minutes": (time.time() - out["began"]) / 60.0}


def main():
    """Measure, or take the last measurement with --report, and write the report."""
    if "--report" not in sys.argv:
        MEASURED.parent.mkdir(exist_ok=True)
        MEASURED.write_bytes(pickle.dumps(measure()))
    m = pickle.loads(MEASURED.read_bytes())
    text = "\n".join((
        "# Benchmark report\n",
        f"Written by `make bench` in {m['minutes']:.0f} minutes on a virtual machine with "
        f"{os.cpu_count()} cores\n({processor()}), Python {platform.python_version()}, one thread "
        "per core.\n",
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
