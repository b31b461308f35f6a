"""The section of `evidence/benchmarks/report.md` on disks that rub in three dimensions."""

import numpy as np

from evidence.benchmarks import spatial_speed as speed
from evidence.benchmarks.report import verdict
from evidence.page import table


def section(kernel):
    """Steps per second against C and the limit, where the time goes, growth."""
    ours, recording, c, gflops, moved = np.array(kernel["sides"]).T
    over_c, limit = ours / c, gflops * 1e9 / kernel["flops"]
    below = limit / ours
    read, written = kernel["bytes"]
    sides = [
        (f"{a / 1e6:.3f}", f"{r / 1e6:.3f}", f"{b / 1e6:.4f}", f"{a / b:.1f}", f"{m / 1e6:.2f}",
         f"{m / a:.1f}", f"{w / 1e6:.1f}")
        for a, r, b, m, w in zip(ours, recording, c, limit, moved, strict=True)
    ]  # fmt: skip
    columns = ("hpcrub", "the same while recording", "C, dense", "hpcrub / C",
               "limit of the matrix product", "limit / hpcrub", "limit of bandwidth")  # fmt: skip
    whole = list(kernel["parts"].values())[-1]
    parts = [(name, f"{1e6 * t:.1f} µs", f"{100 * t / whole:.0f} %")
             for name, t in kernel["parts"].items()]  # fmt: skip
    return f"""## Three dimensions

The blisk of `inputs/blisk` rubs in 16 lanes between {speed.SLOWEST:g} and {speed.FASTEST:g} Hz.
Its contact points are interpolated along the tips, and made-up modes of small amplitude continue
its own 180. Side by side with {speed.POINTS} contact points and {speed.MODES} modes, in million
steps/s and core, in turns:

{table(columns, sides)}
- The C program is dense in the coordinates of the reduced model; it too finds its forces by
  an active set that starts from that of the step before, and only among points near the casing.
- At least 16 times the C program: median {np.median(over_c):.1f}, {
        verdict(np.median(over_c) >= 16)
    }.
- Within 4 times of the machine's limit: median {np.median(below):.1f}, {
        verdict(np.median(below) <= 4)
    }.
  A step of one speed needs {kernel["flops"]:.0f} floating-point operations ({
        kernel["contacts"]:.1f}
  points in contact at a time on average).
- At every step 16 lanes read {read / 1024:.0f} KiB and write {written / 1024:.0f} KiB.

Where the time of a step goes, each part by itself on states all over a block:

{table(("part", "16 lanes", "share"), parts)}
Growth, and the memory of 16 lanes; "trials": the most sets of points that were tried in a step:

{growth_table(f"contact points, {speed.FIXED_MODES} modes", *kernel["points"])}
{growth_table(f"modes, {speed.POINTS} contact points", *kernel["modes"])}"""


def growth_table(name, sizes, rows):
    """Cost of a step for every size."""
    cells = [
        (size, f"{1e6 * seconds:.2f}", f"{contacts:.1f}", f"{used / 2**20:.1f}", trials,
         "no" if failed else "yes")
        for size, (seconds, contacts, used, trials, failed) in zip(sizes, rows, strict=True)
    ]  # fmt: skip
    head = name, "µs per step and lane", "points in contact", "MiB", "trials", "all forces found"
    return table(head, cells)
