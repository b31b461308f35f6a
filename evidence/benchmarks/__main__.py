"""Measure the kernel's speed and what a sample costs; writes report.md (7 min).

Every section stands for itself, and writes its tables into the page when it has been measured.
"""

from pathlib import Path

from evidence import page
from evidence.benchmarks import kernel_speed, sample_cost, shapes, spatial_speed

SECTIONS = {
    "kernel": kernel_speed.section, "shapes": shapes.section, "spatial": spatial_speed.section,
    "sample": sample_cost.sample, "start": sample_cost.start,
}  # fmt: skip

if __name__ == "__main__":
    page.sections("benchmarks", __doc__, Path(__file__).with_name("report.md"), SECTIONS)
