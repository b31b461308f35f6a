"""Measured numbers → ``benchmarks/report.md`` and figures."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

from benchmarks import work_precision as wp

COLOURS = {"exact_modal": "#0072B2", "central_difference": "#D55E00"}


def table(head, rows):
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines) + "\n"


def verdict(reached):
    return "reached" if reached else "**not reached**"


def kernel_section(kernel):
    """Steps per second, and the two targets of the kernel."""
    rows = [
        (name, modes, width, f"{rate / 1e6:.2f}", f"{recording / 1e6:.2f}")
        for name, modes, width, rate, recording in kernel["rows"]
    ]
    ours, c, gflops = np.array(kernel["sides"]).T
    over_c = ours / c
    limit = gflops * 1e9 / kernel["flops"]
    below = limit / ours
    head = ("scheme", "η", "lanes", "million steps/s", "the same while recording")
    return f"""## Kernel: simulated steps per second and core

{table(head, rows)}
Side by side with 16 lanes and η = 60, five times in turns (the machine's speed drifts, ratios
hold):

{
        table(
            (
                "hpcrub",
                "plain C, dense",
                "ratio",
                "large matrix product",
                "its limit for this algorithm",
                "limit / hpcrub",
            ),
            [
                (
                    f"{a / 1e6:.2f} M/s",
                    f"{b / 1e6:.3f} M/s",
                    f"{r:.1f}",
                    f"{g:.0f} GFLOP/s",
                    f"{most / 1e6:.1f} M/s",
                    f"{f:.1f}",
                )
                for a, b, r, g, most, f in zip(ours, c, over_c, gflops, limit, below, strict=True)
            ],
        )
    }
- At least 16 times the plain C program: median {np.median(over_c):.1f}, {
        verdict(np.median(over_c) >= 16)
    }.
- Within 4 times of the machine's limit: median {np.median(below):.1f}, {
        verdict(np.median(below) <= 4)
    }.
  A step of one speed needs {kernel["flops"]:.0f} floating-point operations ({
        kernel["contacts"]:.1f}
  points in contact at a time on average).
- A plain NumPy loop makes {kernel["numpy"] / 1e6:.3f} million steps/s: hpcrub is
  {np.median(ours) / kernel["numpy"]:.0f} times as fast.
- What 16 lanes touch at every step is {kernel["bytes"] / 1024:.0f} KiB: it streams from the
  second-level cache, not from memory.
"""


def percent(values):
    return " / ".join(f"{100 * v:+.1f}" for v in values)


def precision_section(results, periodic):
    """Run time against error, and what the defaults are worth."""
    rows = []
    front = pareto(results)
    for setting in wp.SETTINGS:
        error, r = wp.compare(results, setting), results[setting]
        low, high = error["interval"]
        rows.append((
            setting.label + (" (front)" if setting in front else ""), f"{r['seconds']:.3f}",
            f"{r['simulated']:.2f}", f"{100 * r['not_steady']:.0f}",
            percent(error["amplitude_percentiles"]),
            " / ".join(f"{100 * a:+.1f}…{100 * b:+.1f}" for a, b in zip(low, high, strict=True)),
            percent(error["amplification_percentiles"]), f"{100 * error['tuned']:+.1f}",
            f"{100 * error['sample_median']:.1f}",
        ))  # fmt: skip
    head = ("setting", "s/sample", "simulated s/point", "not steady %",
            "amplitude percentiles 1/50/99, error %", "95 % bootstrap", "A_nl 1/50/99, error %",
            "tuned, error %", "sample peak, error %")  # fmt: skip
    searches = [s for s in wp.SETTINGS if s.search == "peak"]
    missed = [
        (s.label, *(f"{100 * x:.1f} %" for x in wp.missed_peaks(results, s))) for s in searches
    ]
    steps = [
        (name, ", ".join(f"{h:g}: {100 * e:.2f}" for h, e in zip(h_s, errors, strict=True)),
         f"{order:.2f}")
        for name, (h_s, errors, order) in periodic.items()
    ]  # fmt: skip
    share, floor = f"{100 * wp.periodic(results).mean():.0f} %", f"{100 * wp.floor(results):.1f} %"
    same, level = f"{100 * wp.PERIODIC:g} %", f"±{100 * wp.cases.HALF_RANGE:g} %"
    speeds = ", ".join(f"{speed:g}" for speed in wp.TUNED_SPEEDS)
    return f"""## Run time against error

{wp.N_SAMPLES} samples at {level} (σ = 1.7 %), {len(wp.SPEEDS)} speeds from 33.5 to 35.5 Hz, four
bumps. Errors of percentiles against all runs with steps of 5·10⁻⁶ s and less together (a fine run
against the others); of the peak of each sample against {wp.REFERENCE.label}.

{table(head, rows)}
- {share} of the points keep their amplitude to {same} when the blades are stiffer by {wp.NUDGE:g}.
  On the others the motion is quasi-periodic or chaotic: rounding alone changes the amplitude of a
  point, hence the peak of a sample, and no step lowers that.
- The floor, {floor} in the mean over the deciles 10 to 90 of A_nl, is how far the fine
  runs are from each other. The front counts errors below it as equal. Percentiles 1 and 99 of
  {wp.N_SAMPLES} samples are hardly more than the extreme samples: see their intervals.
- The tuned disk is a single sample, whose scatter moves all A_nl of a study together: A_nl is
  relative to the median of {wp.N_TUNED} runs that differ by rounding, here and in every study.

What the step does to A_nl, with {wp.MORE_SAMPLES} samples in pairs with the same samples at
{1e6 * wp.PAIRED[-1].step:g} µs, in % with its standard error (both disks' peaks lose amplitude at
long steps, and A_nl is their ratio):

{bias_table(results)}
Peak search, against the full sweep of the same setting:

{table(("setting", "samples whose peak is missed", "found over true peak, mean"), missed)}
The tuned disk at {speeds} Hz, where it is periodic: mean error of the amplitude against
exact_modal at 5·10⁻⁷ s, and fitted order:

{table(("scheme", "step [s]: error [%]", "fitted order"), steps)}"""


def bias_table(results):
    found = wp.bias(results)
    head = ("step", "mean of deciles 10 to 90", *(f"percentile {p}" for p in wp.PERCENTILES))
    cells = [[f"{100 * e:+.1f} ± {100 * s:.1f}" for e, s in rows] for rows in found.values()]
    return table(head, [(f"{h:g} s", *row) for h, row in zip(found, cells, strict=True)])


def pareto(results):
    """Settings that no other beats in both run time and error; below the floor all are equal."""
    floor = wp.floor(results)
    settings = [s for s in wp.SETTINGS if s != wp.NUDGED]
    points = {s: (results[s]["seconds"], max(floor, wp.score(results, s))) for s in settings}
    return {
        s for s, (cost, error) in points.items()
        if not any(c < cost and e <= error for c, e in points.values())
    }  # fmt: skip


def series():
    """{name: (settings, style, label of a setting, its offset [points])} of the diagram."""
    plain = [s for s in wp.SETTINGS if s == wp.Setting(s.scheme, s.step)]
    micro = {s: f"{1e6 * s.step:g} µs" for s in wp.SETTINGS}
    out = {
        name: ([s for s in plain if s.scheme == name], style, micro.get, offset)
        for name, style, offset in zip(wp.SCHEMES, ("o-", "s-"), ((5, 7), (5, -13)), strict=True)
    }
    modes = [s for s in wp.SETTINGS if s.n_modes != 60]
    out["η other than 60"] = modes, "^:", lambda s: f"η = {s.n_modes}", (7, -3)
    peak = [s for s in wp.SETTINGS if s.search == "peak"]
    out["peak search"] = peak, "D", micro.get, (7, -3)
    longer = [s for s in wp.SETTINGS if s.max_time != 2.0]
    out["up to 5 s"] = longer, "v", micro.get, (7, -3)
    return out


def precision_figure(results, path):
    """Work-precision diagram with the Pareto front."""
    front = sorted(pareto(results), key=lambda s: results[s]["seconds"])
    figure, axis = plt.subplots(figsize=(9, 5.5), layout="constrained")

    def place(settings):
        found = [(results[s]["seconds"], 100 * wp.score(results, s)) for s in settings]
        return np.array(found).T

    axis.plot(*place(front), color="0.8", lw=7, zorder=0, label="Pareto front")
    colours = plt.get_cmap("tab10").colors
    for colour, (name, (settings, style, label, offset)) in zip(
        (*COLOURS.values(), *colours[2:]), series().items(), strict=False
    ):
        axis.plot(*place(settings), style, color=colour, ms=6, lw=1, label=name)
        for setting in settings:
            axis.annotate(label(setting), place([setting])[:, 0], xytext=offset, fontsize=8,
                          textcoords="offset points", color=colour)  # fmt: skip
    axis.plot(*place([wp.DEFAULT]), "o", ms=14, mfc="none", color="k", label="default")
    floor = 100 * wp.floor(results)
    axis.axhspan(1e-3, floor, color="0.9", zorder=-1, label="floor: fine runs among themselves")
    axis.set(xscale="log", yscale="log", xlabel="seconds per sample and core",
             ylabel="mean error of the deciles 10 … 90 of A_nl [%]")  # fmt: skip
    axis.set_ylim(0.1, 100)
    axis.legend(frameon=False, fontsize=9)
    axis.grid(alpha=0.3)
    figure.savefig(path, dpi=150)
    plt.close(figure)


def cost_section(parts, whole, shortcuts, scaling, start, ranks):
    """Where the time of a sample goes, and how it grows."""
    total = sum(v for k, v in parts.items() if "once" not in k)
    rows = [(k, f"{1e3 * v:.2f} ms", "" if "once" in k else f"{100 * v / total:.2f} %")
            for k, v in parts.items()]  # fmt: skip
    grow = [
        (name, ", ".join(f"{n}: {1e9 * s:.0f}" for n, s in zip(sizes, seconds, strict=True)),
         f"{exponent:.2f}")
        for name, (sizes, seconds, exponent) in scaling.items()
    ]  # fmt: skip
    samples = [(f"{step:g} s", f"{longest:g} s", f"{seconds:.3f} s", verdict(seconds <= 0.2))
               for (step, longest), seconds in whole.items()]  # fmt: skip
    off = [(name, f"{ratio:.2f}") for name, ratio in shortcuts.items()]
    ratio = ranks[1] / ranks[2]
    return f"""## Cost of a sample

{table(("part", "time", "share of a sample"), rows)}
A sample of 41 speeds on one core while the other core rests; the goal is 0.2 s:

{table(("step", "longest simulated time", "time", "goal"), samples)}
Run time of a sweep with one shortcut switched off, relative to all on (none changes a bit of the
result; there is a test for each):

{table(("shortcut", "relative run time"), off)}
## Growth with the size of the disk

{table(("varied", "ns per step and lane", "fitted exponent"), grow)}
## Start, memory, ranks

- Start of the kernel: {start["cold"]:.1f} s with an empty cache (compiled), {start["warm"]:.1f} s
  from the cache. Memory of a rank: {start["memory_mb"]:.0f} MB after the start.
- The same study on one and two ranks: {ranks[1]:.1f} s and {ranks[2]:.1f} s, a speed-up of
  {ratio:.2f}; target 1.9 {verdict(ratio >= 1.9)}.
"""
