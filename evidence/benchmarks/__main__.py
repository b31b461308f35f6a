"""Measure the kernel's speed, its error and what a sample costs; writes report.md (15 min).

Every section stands for itself. What is measured is kept in build/benchmarks.pickle; the report is
written when all sections have been measured, the others as they were.
"""

import argparse
import pickle
import sys
import time
from pathlib import Path

from evidence import page
from evidence.benchmarks import (
    cases,
    kernel_speed,
    law_precision,
    report,
    sample_cost,
    spatial_report,
    spatial_speed,
    work_precision,
)

REPORT = Path(__file__).with_name("report.md")
MEASURED = page.ROOT / "build" / "benchmarks.pickle"
PERIODIC = "inputs/earlier_disk.yaml"  # its first disk has periodic motions at these speeds


def kernel():
    """Simulated steps per second."""
    return kernel_speed.measure()


def spatial():
    """Three dimensions: simulated steps per second, growth."""
    return spatial_speed.measure()


def laws():
    """The blisk, and casings that give or wear: run time against error."""
    return law_precision.measure()


def precision(disk=None):
    """Run time against error; disk: an input file with another disk than the reference."""
    cases.take_disk_of(disk)
    with work_precision.pool_of_two(disk) as pool:
        measured = work_precision.measure(pool)
    periodic = disk or PERIODIC
    with work_precision.pool_of_two(periodic) as pool:
        return measured, (periodic, *work_precision.periodic_errors(pool))


def sample():
    """What a sample costs, by part."""
    return sample_cost.parts(), sample_cost.whole_samples()


def start():
    """Start and memory."""
    return sample_cost.start_up(), sample_cost.memory()


def ranks():
    """One and two ranks."""
    return sample_cost.ranks()


SECTIONS = {  # what measures a section, what writes it
    "kernel": (kernel, report.kernel_section),
    "spatial": (spatial, spatial_report.section),
    "laws": (laws, law_precision.section),
    "precision": (precision, report.precision_section),
    "sample": (sample, report.sample_section),
    "start": (start, report.start_section),
    "ranks": (ranks, report.ranks_section),
}


def main(argv=None):
    """Measure the sections asked for, print them, and write the report; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m evidence.benchmarks", description=__doc__)
    parser.add_argument("section", nargs="*", metavar="SECTION",
                        help=f"only these: {', '.join(SECTIONS)}")  # fmt: skip
    parser.add_argument("--report", action="store_true", help="measure nothing, write the report")
    parser.add_argument("--disk", metavar="INPUT",
                        help="print `precision` of the disk of this input file")  # fmt: skip
    options = parser.parse_args(argv)
    if options.disk:
        print(report.precision_section(precision(options.disk)))
        return 0
    if unknown := set(options.section) - set(SECTIONS):
        parser.error(f"no section {', '.join(sorted(unknown))}; there are {', '.join(SECTIONS)}")
    found = pickle.loads(MEASURED.read_bytes()) if MEASURED.exists() else {}
    chosen = [] if options.report else options.section or list(SECTIONS)
    for name in chosen:
        began = time.time()
        measured = SECTIONS[name][0]()
        found[name] = measured, (time.time() - began) / 60.0
        MEASURED.parent.mkdir(exist_ok=True)
        MEASURED.write_bytes(pickle.dumps(found))
        print(text(name, found), flush=True)
    missing = [name for name in SECTIONS if name not in found]
    if missing:
        print(f"{REPORT} is written when these are measured too: {', '.join(missing)}")
        return 0
    minutes = sum(taken for _, taken in found.values())
    head = f"Written by `make bench`: {minutes:.0f} minutes of measurements with {page.machine()}."
    parts = ["# Benchmark report\n", f"{head}\n", *(text(name, found) for name in SECTIONS)]
    REPORT.write_text("\n".join(parts), encoding="utf-8")
    report.precision_figure(*found["precision"][0], REPORT.with_name("work_precision.png"))
    print(REPORT)
    return 0


def text(name, found):
    """Markdown of one section that has been measured."""
    return SECTIONS[name][1](found[name][0])


if __name__ == "__main__":
    sys.exit(main())
