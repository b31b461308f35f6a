"""Measure the kernel's speed and what a sample costs; writes report.md (7 min).

Every section stands for itself, and writes its tables into the page when it has been measured.
"""

import argparse
import sys
from pathlib import Path

from evidence import page, progress
from evidence.benchmarks import kernel_speed, sample_cost, shapes, spatial_speed

SECTIONS = {
    "kernel": kernel_speed.section, "shapes": shapes.section, "spatial": spatial_speed.section,
    "sample": sample_cost.sample, "start": sample_cost.start,
}  # fmt: skip


def main(argv=None):
    """Measure the sections asked for, print them and put them into the page."""
    parser = argparse.ArgumentParser(prog="python -m evidence.benchmarks", description=__doc__)
    parser.add_argument("sections", nargs="*", choices=[*SECTIONS, []], help="all by default")
    chosen = parser.parse_args(argv).sections or list(SECTIONS)
    for name in progress.followed(chosen, "sections", names=chosen):
        parts = {f"{name}_{part}": text for part, text in SECTIONS[name]().items()}
        parts[f"{name}_machine"] = f"Measured with {page.machine()}."
        print("\n".join(parts.values()), flush=True)
        page.replace(Path(__file__).with_name("report.md"), **parts)
    return 0


if __name__ == "__main__":
    sys.exit(main())
