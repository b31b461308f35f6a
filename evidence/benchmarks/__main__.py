"""Measure the kernel's speed and what a sample costs; writes report.md (8 min).

Every section stands for itself, and writes its tables into the page when it has been measured.
"""

import argparse
import sys
from pathlib import Path

from evidence import page, progress
from evidence.benchmarks import kernel_speed, sample_cost, shapes, shared_basis, spatial_speed

SECTIONS = {  # and how long they take on a machine of 2026 [s]
    "kernel": (kernel_speed.section, 10),
    "shapes": (shapes.section, 130),
    "spatial": (spatial_speed.section, 30),
    "basis": (shared_basis.section, 250),
    "sample": (sample_cost.sample, 20),
    "start": (sample_cost.start, 35),
}


def main(argv=None):
    """Measure the sections asked for, print them and put them into the page."""
    parser = argparse.ArgumentParser(prog="python -m evidence.benchmarks", description=__doc__)
    parser.add_argument("section", nargs="*", metavar="SECTION",
                        help=f"only these: {', '.join(SECTIONS)}")  # fmt: skip
    chosen = parser.parse_args(argv).section or list(SECTIONS)
    if unknown := set(chosen) - set(SECTIONS):
        parser.error(f"no section {', '.join(sorted(unknown))}; there are {', '.join(SECTIONS)}")
    costs = [SECTIONS[name][1] for name in chosen]
    for name in progress.followed(chosen, "sections", names=chosen, costs=costs):
        parts = {f"{name}_{part}": text for part, text in SECTIONS[name][0]().items()}
        parts[f"{name}_machine"] = f"Measured with {page.machine()}."
        print("\n".join(parts.values()), flush=True)
        page.replace(Path(__file__).with_name("report.md"), **parts)
    return 0


if __name__ == "__main__":
    sys.exit(main())
