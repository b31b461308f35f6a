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
    ours, c, loop, gflops, moved = np.array(kernel["sides"]).T
    over_c = ours / c
    limit = gflops * 1e9 / kernel["flops"]
    below = limit / ours
    read, written = kernel["bytes"]
    sides = [
        (
            f"{a / 1e6:.2f}",
            f"{b / 1e6:.3f}",
            f"{n / 1e6:.4f}",
            f"{r:.1f}",
            f"{g:.0f} GFLOP/s",
            f"{most / 1e6:.1f}",
            f"{f:.1f}",
            f"{m / 1e6:.1f}",
        )
        for a, b, n, r, g, most, f, m in zip(
            ours, c, loop, over_c, gflops, limit, below, moved, strict=True
        )
    ]
    columns = (
        "hpcrub",
        "plain C, dense",
        "plain NumPy",
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
- hpcrub is {np.median(ours / loop):.0f} times as fast as a plain NumPy loop.
- At every step 16 lanes read {read / 1024:.0f} KiB and write {written / 1024:.0f} KiB. The last
  column is what one core makes of that when it adds arrays of this size, which lie in its
  second-level cache: {np.median(moved / ours):.1f} times what hpcrub makes.
"""


def percent(values):
    return " / ".join(f"{100 * v:+.1f}" for v in values)


def precision_section(measured):
    """Run time against error, and what the defaults are worth."""
    results, periodic = measured
    rows = []
    front = pareto(results)
    for setting in (*wp.plain_settings(), *wp.other_settings(), wp.NUDGED):
        error, r = wp.compare(results, setting), results[setting]
        low, high = error["interval"]
        rows.append((
            setting.label + (" (front)" if setting in front else ""), f"{r['seconds']:.3f}",
            f"{r['simulated']:.2f}", f"{100 * r['not_steady']:.0f}",
            f"{100 * wp.score(results, setting):.1f}", percent(error["percentiles"]),
            " / ".join(f"{100 * a:+.1f}…{100 * b:+.1f}" for a, b in zip(low, high, strict=True)),
            f"{100 * error['tuned']:+.1f}", f"{100 * error['sample_median']:.1f}",
        ))  # fmt: skip
    head = ("setting", "s/sample", "simulated s/point", "not steady %", "deciles of A_nl, %",
            "A_nl 1/50/99, %", "95 % bootstrap", "tuned, %", "sample peak, %")  # fmt: skip
    missed = [
        (s.label, *(f"{100 * x:.1f} %" for x in wp.missed_peaks(results, s)))
        for s in wp.other_settings() if s.search == "peak"
    ]  # fmt: skip
    share, floor = f"{100 * wp.share_periodic(results):.0f} %", f"{100 * wp.floor(results):.1f} %"
    same, level = f"{100 * wp.PERIODIC:g} %", f"±{100 * wp.cases.HALF_RANGE:g} %"
    return f"""## Run time against error

{wp.N_SAMPLES} samples at {level} (σ = 1.7 %), {len(wp.SPEEDS)} speeds from 33.5 to 35.5 Hz, four
bumps. Errors of the percentiles of A_nl against all runs with steps of 5·10⁻⁶ s and less together
(a fine run against the others), the tuned disk's error included, with bootstrap intervals over the
samples and the {wp.N_TUNED} runs of the tuned disk; "deciles": mean magnitude of the errors of the
percentiles 10, 20 … 90; "sample peak": median against {wp.REFERENCE.label}.

{table(head, rows)}
- {share} of the points keep their amplitude to {same} when the blades are stiffer by {wp.NUDGE:g}.
  On the others the motion is quasi-periodic or chaotic, or there are several: rounding alone
  changes the amplitude of a point, hence the peak of a sample, and no step lowers that. Percentiles
  converge all the same: over the samples, a step changes where each trajectory ends, but not how
  often each amplitude occurs.
- The floor, {floor} in the deciles, is how far the fine runs are from each other: what lies below
  it differs by chance, on the front too. Percentiles 1 and 99 of {wp.N_SAMPLES} samples are hardly
  more than the extreme samples: see their intervals.

{crossed_table(results)}
What the step does to A_nl, with {wp.MORE_SAMPLES} samples in pairs with the same samples at
{1e6 * wp.PAIRED[-1].step:g} µs and {wp.MORE_TUNED} runs of the tuned disk each, in % with its
standard error; is it within 1 %, by two standard errors?

{bias_table(results)}
Peak search, against the full sweep of the same setting:

{table(("setting", "samples whose peak is missed", "found over true peak, mean"), missed)}
{periodic_section(periodic)}
![Work-precision diagram](work_precision.png)
"""


def crossed_table(results):
    """Errors and cost of both schemes with long steps over the numbers of modes."""
    rows = []
    for scheme in wp.SCHEMES:
        for step in wp.CROSSED:
            cells = (results.get(wp.Setting(scheme, step, n)) for n in wp.N_MODES)
            cells = [
                f"{100 * wp.score(results, wp.Setting(scheme, step, n)):.1f} ({r['seconds']:.3f})"
                if r else "unstable"
                for n, r in zip(wp.N_MODES, cells, strict=True)
            ]  # fmt: skip
            rows.append((scheme, f"{step:g} s", *cells))
    head = "scheme", "step", *(f"η = {n}" for n in wp.N_MODES)
    return f"""Error of the deciles of A_nl in % (seconds a sample) over the number of modes η; the
reference has the paper's 60, so that 84 and 120 show what 60 leaves out:

{table(head, rows)}"""


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
    return f"""The errors of single amplitudes are those of the disk of `{disk}`.
After {wp.SETTLED:g} s no motion near the peak is periodic. Of {n_all} points of
{len(wp.SETTLED_SAMPLES)} samples between {speeds[0]:g} and {speeds[-1]:g} Hz, {n_here} are, with
either scheme: a nudge by {wp.NUDGE:g} leaves their amplitude. There, against exact_modal with
{wp.FINEST:g} s; points that are off by more than {100 * wp.OTHER:g} % are on another of several
periodic motions:

{table(("scheme", "step [s]: median error [%]", "fitted order", "other motion [%]"), rows)}"""


def bias_table(results):
    found = wp.bias(results)
    head = ("step", "mean of deciles 10 to 90", *(f"percentile {p}" for p in wp.PERCENTILES))
    cells = [[f"{100 * e:+.1f} ± {100 * s:.1f}, {within(e, s)}" for e, s in rows]
             for rows in found.values()]  # fmt: skip
    return table(head, [(f"{h:g} s", *row) for h, row in zip(found, cells, strict=True)])


def within(error, deviation, goal=0.01):
    """Whether an error with its standard deviation is within the goal, as a word."""
    if abs(error) + 2 * deviation <= goal:
        return "yes"
    return "no" if abs(error) - 2 * deviation > goal else "open"


def pareto(results):
    """Settings that no other beats in both run time and error."""
    settings = [s for s in results if s != wp.NUDGED]
    points = {s: (results[s]["seconds"], wp.score(results, s)) for s in settings}
    return {
        s for s, (cost, error) in points.items()
        if not any(c < cost and e <= error for c, e in points.values())
    }  # fmt: skip


def series():
    """{name: (settings, marker, label of a setting, its offset [points])} of the diagram."""
    plain, other = wp.plain_settings(), wp.other_settings()

    def micro(setting):
        return f"{1e6 * setting.step:g}"

    out = {
        f"{name}, step in µs": ([s for s in plain if s.scheme == name], style, micro, offset)
        for name, style, offset in zip(wp.SCHEMES, ("o-", "s-"), ((-3, 8), (-3, -15)), strict=True)
    }
    modes = [wp.Setting(n_modes=n) for n in wp.N_MODES if n != 60]
    out["η other than 60, 33 µs"] = modes, "^:", lambda s: f"η = {s.n_modes}", (7, -3)
    out["peak search"] = [s for s in other if s.search == "peak"], "D", micro, (8, -3)
    out["up to 5 s"] = [s for s in other if s.max_time != 2.0], "v", micro, (8, -3)
    return out


def precision_figure(results, periodic, path):
    """Cost against the error of deciles (with the Pareto front) and of single peaks; error against
    step where motions are periodic."""
    figure, (left, middle, right) = plt.subplots(
        1, 3, figsize=(16, 5.5), layout="constrained", width_ratios=(1.3, 1, 1)
    )
    measures = (
        (left, lambda s: wp.score(results, s)),
        (middle, lambda s: wp.compare(results, s)["sample_median"]),
    )
    for axis, error in measures:
        draw_series(axis, results, error)
    front = sorted(pareto(results), key=lambda s: results[s]["seconds"])
    places = [(results[s]["seconds"], 100 * wp.score(results, s)) for s in front]
    left.plot(*np.transpose(places), color="0.8", lw=7, zorder=0, label="Pareto front")
    left.axhspan(1e-3, 100 * wp.floor(results), color="0.93", zorder=-1,
                 label="floor: fine runs among themselves")  # fmt: skip
    left.set(ylim=(0.1, 100), ylabel="mean error of the deciles 10 … 90 of A_nl [%]")
    middle.set(ylim=(1, 100), ylabel="median error of the peak of a sample [%]")
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


def draw_series(axis, results, error):
    """Run time and error of every setting of the `series`."""
    colours = (*COLOURS.values(), *plt.get_cmap("tab10").colors[2:])
    for colour, (name, (settings, style, label, offset)) in zip(
        colours, series().items(), strict=False
    ):
        points = [(results[s]["seconds"], 100 * error(s)) for s in settings]
        points = [(x, y if y > 0.0 else np.nan) for x, y in points]  # the reference itself
        axis.plot(*np.transpose(points), style, color=colour, ms=6, lw=1, label=name)
        for setting, point in zip(settings, points, strict=True):
            if np.isfinite(point[1]):
                axis.annotate(label(setting), point, xytext=offset, fontsize=7,
                              textcoords="offset points", color=colour)  # fmt: skip
    point = results[wp.DEFAULT]["seconds"], 100 * error(wp.DEFAULT)
    axis.plot(*point, "o", ms=14, mfc="none", color="k", label="default")
    axis.set(xscale="log", yscale="log", xlabel="seconds per sample and core")
    axis.grid(alpha=0.3)


def sample_section(measured):
    """Where the time of a sample goes."""
    parts, whole, shortcuts = measured
    total = sum(v for k, v in parts.items() if "once" not in k)
    rows = [(k, f"{1e3 * v:.2f} ms", "" if "once" in k else f"{100 * v / total:.2f} %")
            for k, v in parts.items()]  # fmt: skip
    samples = [(f"{step:g} s", f"{longest:g} s", f"{seconds:.3f} s", verdict(seconds <= 0.2))
               for (step, longest), seconds in whole.items()]  # fmt: skip
    off = [(name, f"{1e3 * without:.2f} ms", f"{1e3 * with_it:.2f} ms", f"{without / with_it:.2f}")
           for name, (without, with_it) in shortcuts.items()]  # fmt: skip
    return f"""## Cost of a sample

{table(("part", "time", "share of a sample"), rows)}
A sample of 41 speeds on one core while the other core rests, mean of eight; the goal is 0.2 s:

{table(("step", "longest simulated time", "time", "goal"), samples)}
Run time of a sweep with one shortcut switched off, and with all on, of at most 1 s a point (none
changes a bit of the result; there is a test for each). The first is measured where the bumps are
lower than the clearance, the others where blades rub:

{table(("shortcut", "without", "with all", "ratio"), off)}"""


def size_section(measured):
    """How the cost of a step grows with the disk."""
    grow = [
        (name, ", ".join(f"{n}: {1e9 * s:.0f}" for n, s in zip(sizes, seconds, strict=True)),
         f"{exponent:.2f}", ", ".join(f"{x:.1f}" for x in local))
        for name, (sizes, seconds, exponent, local) in measured.items()
    ]  # fmt: skip
    return f"""## Growth with the size of the disk

{table(("varied", "ns per step and lane", "fitted exponent", "from size to size"), grow)}
The cost is no power of the number of blades: contacts are solved together and tips times modes
outgrow the caches.
"""


def start_section(measured):
    """What a rank takes before its first step."""
    start, memory = measured
    return f"""## Start and memory

Start of the kernel: {start["cold"]:.1f} s with an empty cache (compiled),
{start["warm"]:.1f} s from the cache. Memory: {memory[0]:.0f} MB on rank 0, which draws the figure,
{memory[1]:.0f} MB on another rank.
"""


def ranks_section(ranks):
    """Speed-up on the cores at hand."""
    ratio = ranks[1] / ranks[2]
    return f"""## Ranks

The same study without its figure on one and two ranks: {ranks[1]:.1f} s and {ranks[2]:.1f} s, a
speed-up of {ratio:.2f}; target 1.9 {verdict(ratio >= 1.9)}.
"""
