"""`python -m benchmarks`: measure everything, write ``benchmarks/report.md`` and its figure."""

import os

os.environ.update({f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "NUMBA")})

import platform
import time
from pathlib import Path

from benchmarks import kernel_speed, report, sample_cost, work_precision

FOLDER = Path(__file__).parent


def main():
    began = time.monotonic()
    print("kernel", flush=True)
    kernel = kernel_speed.measure()
    print("sample", flush=True)
    parts, shortcuts = sample_cost.parts(), sample_cost.shortcuts()
    whole, periodic = sample_cost.whole_samples(), work_precision.periodic_errors()
    print("size", flush=True)
    scaling = sample_cost.scaling()
    print("start, ranks", flush=True)
    start, ranks = sample_cost.start_up(), sample_cost.ranks()
    print("run time against error", flush=True)
    with work_precision.pool_of_two() as pool:
        results = work_precision.measure(pool)
    text = [
        "# Benchmark report\n",
        f"Written by `make bench` in {(time.monotonic() - began) / 60:.0f} minutes on a virtual "
        f"machine with {os.cpu_count()} cores ({platform.machine()}, AVX-512), Python "
        f"{platform.python_version()}. One core each, one thread each.\n",
        report.kernel_section(kernel),
        report.precision_section(results, periodic),
        "![Work-precision diagram](work_precision.png)\n",
        report.cost_section(parts, whole, shortcuts, scaling, start, ranks),
    ]
    report.precision_figure(results, FOLDER / "work_precision.png")
    (FOLDER / "report.md").write_text("\n".join(text))
    print(f"{FOLDER}/report.md, {time.monotonic() - began:.0f} s")


if __name__ == "__main__":
    main()
