"""The sections of `evidence/benchmarks/report.md` and its figure, from what was measured."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

from evidence.benchmarks import work_precision as wp
from evidence.page import table

COLOURS = {"exact_modal": "#0072B2", "central_difference": "#D55E00"}


def verdict(reached):
    return "reached" if reached else "**not reached**"


def kernel_section(kernel):
    """Steps per second, and the two targets of the kernel."""
    rows = [
        (name, modes, width, f"{rate / 1e6:.2f}", f"{recording / 1e6:.2f}")
        for name, modes, width, rate, recording in kernel["rows"]
    ]
    ours, c, gflops, moved = np.array(kernel["sides"]).T
    over_c = ours / c
    limit = gflops * 1e9 / kernel["flops"]
    below = limit / ours
    read, written = kernel["bytes"]
    sides = [
        (
            f"{a / 1e6:.2f}",
            f"{b / 1e6:.3f}",
            f"{r:.1f}",
            f"{g:.0f} GFLOP/s",
            f"{most / 1e6:.1f}",
            f"{f:.1f}",
            f"{m / 1e6:.1f}",
        )
        for a, b, r, g, most, f, m in zip(ours, c, over_c, gflops, limit, below, moved, strict=True)
    ]
    columns = (
        "hpcrub",
        "plain C, dense",
        "hpcrub / C",
        "large matrix product",
        "its limit",
        "limit / hpcrub",
        "limit of bandwidth",
    )
    head = ("scheme", "η", "lanes", "million steps/s", "the same while recording")
    return f"""## Kernel: simulated steps per second and core

{table(head, rows)}
Side by side with 16 lanes and η = 60, in million steps/s, five times in turns (the machine's speed
drifts, ratios hold):

{table(columns, sides)}
- At least 16 times the plain C program: median {np.median(over_c):.1f}, {
        verdict(np.median(over_c) >= 16)
    }.
- Within 4 times of the machine's limit: median {np.median(below):.1f}, {
        verdict(np.median(below) <= 4)
    }.
  A step of one speed needs {kernel["flops"]:.0f} floating-point operations ({
        kernel["contacts"]:.1f}
  points in contact at a time on average).
- At every step 16 lanes read {read / 1024:.0f} KiB and write {written / 1024:.0f} KiB. The last
  column is what one core makes of that when it adds arrays of this size, which lie in its
  second-level cache: {np.median(moved / ours):.1f} times what hpcrub makes.
"""


def precision_section(measured):
    """Run time against error, and what the default is worth."""
    results, periodic = measured
    rows = [
        (setting.label + (" (default)" if setting == wp.DEFAULT else ""), f"{r['seconds']:.3f}",
         f"{100 * r['not_steady']:.0f}", f"{100 * wp.score(results, setting):.1f}",
         f"{100 * wp.sample_error(results, setting):.1f}")
        for setting, r in results.items()
    ]  # fmt: skip
    head = "setting", "s/sample", "not steady %", "deciles of A_nl, %", "sample peak, %"
    share, floor = f"{100 * wp.share_periodic(results):.0f} %", f"{100 * wp.floor(results):.1f} %"
    same, level = f"{100 * wp.PERIODIC:g} %", f"±{100 * wp.cases.HALF_RANGE:g} %"
    return f"""## Run time against error

{wp.N_SAMPLES} samples at {level} (σ = 1.7 %), {len(wp.SPEEDS)} speeds from 33.5 to 35.5 Hz, four
bumps. "Deciles": mean magnitude of the errors of the percentiles 10, 20 … 90 of A_nl against all
runs with steps of 5·10⁻⁶ s and less together (a fine run against the others), the tuned disk's
error included; "sample peak": median against {wp.REFERENCE.label}.

{table(head, rows)}
- {share} of the points keep their amplitude to {same} when the blades are stiffer by {wp.NUDGE:g}.
  On the others the motion is quasi-periodic or chaotic, or there are several: rounding alone
  changes the amplitude of a point, hence the peak of a sample, and no step lowers that. Percentiles
  converge all the same: over the samples, a step changes where each trajectory ends, but not how
  often each amplitude occurs.
- The floor, {floor} in the deciles, is how far the fine runs are from each other: what lies below
  it differs by chance.

{periodic_section(periodic)}
![Work-precision diagram](work_precision.png)
"""


def periodic_section(periodic):
    """Error of the amplitude where motions are periodic."""
    disk, found, n_here, n_all = periodic
    rows = [
        (scheme,
         ", ".join(f"{h:g}: {100 * e:.2f}" for h, e in zip(steps, median, strict=True)),
         f"{order:.2f}",
         ", ".join(f"{100 * x:.0f}" for x in other))
        for scheme, (steps, median, other, order) in found.items()
    ]  # fmt: skip
    speeds = wp.SETTLED_SPEEDS
    return f"""The errors of single amplitudes are those of the first disk of `{disk}`.
After {wp.SETTLED:g} s no motion near the peak is periodic. Of {n_all} points of
{len(wp.SETTLED_SAMPLES)} samples between {speeds[0]:g} and {speeds[-1]:g} Hz, {n_here} are, with
either scheme: a nudge by {wp.NUDGE:g} leaves their amplitude. There, against exact_modal with
{wp.FINEST:g} s; points that are off by more than {100 * wp.OTHER:g} % are on another of several
periodic motions:

{table(("scheme", "step [s]: median error [%]", "fitted order", "other motion [%]"), rows)}"""


def precision_figure(results, periodic, path):
    """Cost against the error of deciles and of single peaks; error against step where motions are
    periodic."""
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(16, 5.5), layout="constrained")
    for axis, error in ((left, wp.score), (middle, wp.sample_error)):
        for scheme, style in zip(wp.SCHEMES, ("o-", "s-"), strict=True):
            chosen = [s for s in results if s.scheme == scheme and not s.nudge]
            cost = [results[s]["seconds"] for s in chosen]
            errors = [100 * error(results, s) or np.nan for s in chosen]  # none of the reference
            axis.plot(cost, errors, style, color=COLOURS[scheme], label=f"{scheme}, step in µs")
            for s, x, y in zip(chosen, cost, errors, strict=True):
                if np.isfinite(y):
                    axis.annotate(f"{1e6 * s.step:g}", (x, y), xytext=(3, 6), fontsize=8,
                                  textcoords="offset points")  # fmt: skip
        axis.set(xscale="log", yscale="log", xlabel="seconds per sample and core")
        axis.grid(alpha=0.3)
    left.axhspan(0.0, 100 * wp.floor(results), color="0.93", zorder=-1,
                 label="floor: fine runs among themselves")  # fmt: skip
    left.set(ylabel="mean error of the deciles 10 … 90 of A_nl [%]")
    middle.set(ylabel="median error of the peak of a sample [%]")
    left.legend(frameon=False, fontsize=9)
    for scheme, (steps, median, _, order) in periodic[1].items():
        style = "o-" if scheme == "exact_modal" else "s-"
        right.loglog(1e6 * np.array(steps), 100 * median, style, color=COLOURS[scheme],
                     label=f"{scheme}, order {order:.2f}")  # fmt: skip
    right.set(xlabel="step [µs]", ylabel="median error of the amplitude where periodic [%]")
    right.legend(frameon=False, fontsize=9)
    right.grid(alpha=0.3)
    figure.savefig(path, dpi=120)
    plt.close(figure)


def sample_section(measured):
    """Where the time of a sample goes."""
    parts, whole = measured
    total = sum(v for k, v in parts.items() if "once" not in k)
    rows = [(k, f"{1e3 * v:.2f} ms", "" if "once" in k else f"{100 * v / total:.2f} %")
            for k, v in parts.items()]  # fmt: skip
    samples = [(f"{step:g} s", f"{longest:g} s", f"{seconds:.3f} s", verdict(seconds <= 0.2))
               for (step, longest), seconds in whole.items()]  # fmt: skip
    return f"""## Cost of a sample

{table(("part", "time", "share of a sample"), rows)}
A sample of 41 speeds on one core while the other core rests, mean of eight; the goal is 0.2 s:

{table(("step", "longest simulated time", "time", "goal"), samples)}"""


def start_section(measured):
    """What a rank takes before its first step."""
    start, memory = measured
    rows = [[name, *(f"{x:.{digits}f}" for cache in ("cold", "warm")
                     for x, digits in zip(start[name, cache], (1, 0), strict=True))]
            for name in ("quickstart", "blisk/contact")]  # fmt: skip
    return f"""## Start and memory

One sample at short times, on one core, with an empty cache of compiled code and with a filled one:
processor seconds of the whole process, and its largest memory.

{table(("input", "empty [s]", "[MB]", "filled [s]", "[MB]"), rows)}
Memory of a study on two ranks: {memory[0]:.0f} MB on rank 0, which draws the figure,
{memory[1]:.0f} MB on the other one.
"""


def ranks_section(ranks):
    """Speed-up on the cores at hand."""
    ratio = ranks[1] / ranks[2]
    return f"""## Ranks

The same study without its figure on one and two ranks: {ranks[1]:.1f} s and {ranks[2]:.1f} s, a
speed-up of {ratio:.2f}; target 1.9 {verdict(ratio >= 1.9)}.
"""
