"""Measurements and simulations → tables and figures of docs/scaling.md."""

import matplotlib.pyplot as plt
import numpy as np

from evidence import page
from evidence.scaling import growth, program, simulate
from evidence.scaling.costs import CASES
from hpcrub.plot.style import BLUE, COLOURS, MARKERS, ORANGE, STYLE, legend_below

RANKS = (10, 100, 300, 1000, 3000, 10_000)
TABLE = (10, 100, 1000, 10_000)
SAMPLES = 20_000  # of each case: 4 levels of 5000
ENOUGH = 400  # samples per rank are simulated, and count for all
LINES = ("-", "--", "-.", ":")
VARIANTS = {
    "as it is": {},
    "samples never cut": {"cut": False},
    "samples after the tuned disk": {"overlap": False},
    "neither": {"cut": False, "overlap": False},
}


def simulations(found):
    """{(variant, ranks): Result} of the paper's four cases one after another."""
    table = {}
    for n_ranks in RANKS:
        for name, options in VARIANTS.items():
            table[name, n_ranks] = _cases(found, n_ranks, SAMPLES, **options)
    table["ten times the samples", 10_000] = _cases(found, 10_000, 10 * SAMPLES)
    return table


def _cases(found, n_ranks, n_samples, **options):
    """Sums over the four cases; finishing a sample is useful work too."""
    results = []
    total, n_samples = n_samples, min(n_samples, ENOUGH * n_ranks)
    for costs in found["costs"].values():
        told = simulate.study(costs, found["machine"], n_ranks, n_samples, **options)
        finishing = n_samples * found["machine"].finish
        results.append(told._replace(useful=told.useful + finishing))
    sums = (sum(values) * total / n_samples for values in zip(*results, strict=True))
    return simulate.Result(*sums)


def text(found, table):
    """The generated part of the page."""
    return "\n".join(
        [
            _cost_section(found),
            _agreement_section(found),
            _rank_section(found, table),
            _io_section(found),
            _growth_section(found),
        ]
    )


def _cost_section(found):
    rows = []
    for n_bumps, c in found["costs"].items():
        most = max(c.parts[0])
        sums = [sum(parts[most]) for parts in c.parts]
        longest = max(max(parts[most]) for parts in c.parts)
        rows.append(
            (
                n_bumps,
                f"{c.whole.mean():.3f}",
                f"{c.whole.min():.3f} to {c.whole.max():.3f}",
                f"{c.speeds.max():.3f}",
                most,
                f"{longest:.3f}",
                f"{np.sum(sums) / c.whole.sum():.2f}",
            )
        )
    heads = ("n_d", "sample, mean [s]", "from, to [s]", "longest single speed [s]")
    heads += ("parts, at most", "longest part [s]", "all parts / whole")
    machine = found["machine"]
    return f"""### What things cost

{page.table(heads, rows)}
Rank 0 needs {1e6 * machine.receive:.0f} µs for a message with a result
({1e6 * found["noting"]:.0f} µs of them to take note) and {1e6 * machine.send:.0f} µs to send the
next task; the messages have {found["sizes"][1]} and {found["sizes"][0]} bytes. Eigenproblem, linear
peak and writing take {1e3 * machine.finish:.1f} ms of a sample.

![Costs of samples and parts](figures/sample_costs.png)
"""


def _agreement_section(found):
    slept, late = _slept(found), _lacking(found)
    rows = [
        (n, f"{real:.2f}", f"{told:.2f}", f"{100 * (told / real - 1):+.1f} %")
        for n, (real, told) in slept.items()
    ]
    studies = []
    one = program.integrating(found["studies"][1][0])
    for n, (summary, told) in found["studies"].items():
        real = program.integrating(summary)
        idle = f"{100 * summary['idle_share']:.1f} %"
        studies.append((n, f"{real:.1f}", f"{told:.1f}", f"{one / real:.2f}", idle))
    heads = ("ranks", "measured [s]", "simulated [s]")
    return f"""### Is the simulation right?

The program's dispatcher on ranks that sleep as long as a sample would take, so that no rank lacks a
core; the simulation takes the same samples in the same order:

{page.table((*heads, "difference"), rows)}
The simulation lacks {min(late):.2f} to {max(late):.2f} s of a study, on few ranks and on many: a
larger share of a shorter study. (Ranks that sleep wake up late, and wait for each other at the
end.)

The program itself, {4 * program.SAMPLES} samples on this machine's cores (with more ranks than
cores, ranks share them; the simulated speed is that of the run on one rank):

{page.table((*heads, "speed-up", "ranks idle"), studies)}"""


def _slept(found):
    """{ranks: (seconds measured, simulated)} of ranks that sleep."""
    costs, machine = found["costs"][4], found["machine"]
    return {n: (real, program.slept(costs, machine, n)) for n, real in found["sleeping"].items()}


def _lacking(found):
    """Seconds that the simulation lacks (R,)."""
    return [real - told for real, told in _slept(found).values()]


def _rank_section(found, table):
    rows = []
    for name in VARIANTS:
        values = [f"{100 * table[name, n].efficiency(n):.1f} %" for n in TABLE]
        rows.append((name, *values))
    best = [table["as it is", n] for n in TABLE]
    rows.append(("time of the whole study", *(f"{r.seconds:.1f} s" for r in best)))
    serving = [f"{100 * r.serving / r.seconds:.1f} %" for r in best]
    rows.append(("rank 0 busy with messages", *serving))
    samples = 4 * SAMPLES
    rows.append(("samples per rank", *(f"{samples / n:,.4g}" for n in TABLE)))
    heads = ("", *(f"{n:,} ranks" for n in TABLE))
    reached = table["as it is", 1000].efficiency(1000)
    late = max(_lacking(found))
    best = table["as it is", 1000]
    least = reached * best.seconds / (best.seconds + len(CASES) * late)
    more = table["ten times the samples", 10_000]
    return f"""### The paper's study on many ranks, simulated

Four cases (n_d = 3 … 6) one after another in one job, 20,000 samples each, efficiency without
start-up and figures:

{page.table(heads, rows)}
- At least 95 % at 1,000 ranks: {"reached" if least >= 0.95 else "**not certain**"}.
  With the {late:.2f} s that the simulation lacks at most (above), in each of the four cases, it is
  {100 * least:.1f} % instead of {100 * reached:.1f} %.
- With ten times the samples, 10,000 ranks are {100 * more.efficiency(10_000):.1f} % efficient, and
  rank 0 is busy with messages {100 * more.serving / more.seconds:.0f} % of the time.

![Efficiency against ranks](figures/scaling.png)
"""


def _io_section(found):
    rows = []
    for n in (2, 4):
        both = [found["writing"][n, how] for how in ("independent", "collective")]
        rows.append((n, *(f"{1e3 * seconds:.2f} ms" for seconds in both)))
    summary = found["studies"][2][0]
    return f"""### Writing

Time per sample on every rank while all ranks write, samples at their own time or all ranks
together:

{page.table(("ranks", "independent", "collective"), rows)}
So writes are independent: collective ones would also make every rank wait for the slowest sample of
all. In the run log of the study of {4 * program.SAMPLES} samples on two ranks, writing them takes
{100 * summary["writing_share"]:.2f} % of the ranks' time (`writing_share`).
"""


def _growth_section(found):
    four, eight, written = found["statistics"]
    memory = [
        (f"{n:,}", f"{most / 1e6:.1f} MB", f"{kept / (4 * n):.0f} bytes")
        for n, (most, kept) in found["memory"].items()
    ]
    laid_out = [
        (f"{n:,}", f"{size / 1e6:,.0f} MB", f"{seconds:.2f} s")
        for n, size, seconds in found["laying out"]
    ]
    looks = [(f"`{name}`", n, f"{seconds:.1f} s") for name, (n, seconds) in found["looks"].items()]
    files = [
        (name, f"{n:,}", f"{total / 1e9:.3g} GB", f"{each:,.0f} bytes")
        for name, n, total, each in found["files"]
    ]
    return f"""### What grows with the samples

Rank 0's book of a study (a status byte and two amplifications of every sample; the other ranks keep
nothing):

{page.table(("samples per level, 4 levels", "at most", "kept per sample"), memory)}
Statistics of 10⁶ samples on four levels: {four:.2f} s of processor time for one amplification,
{eight:.2f} s for both; {written:.2f} s with taking up the samples from the file and writing the
statistics.

With `stop_when_converged` rank 0 computes the percentiles anew whenever the finished samples have
grown by 1 %. In a study of {growth.LOOKED:,} samples on each of four levels that never converges:

{page.table(("criterion", "looks", "processor time in all"), looks)}
Rank 0 alone lays the file out at its full size, before any rank computes:

{page.table(("samples per level, 4 levels", "file", "lay-out"), laid_out)}
Result files of the paper's four cases together:

{page.table(("scale", "samples", "files", "per sample"), files)}"""


def efficiency_figure(found, table, path):
    """Efficiency against ranks, and how busy rank 0 is."""
    with plt.rc_context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(12, 5.4))
        for name, colour, marker, line in zip(VARIANTS, COLOURS, MARKERS, LINES, strict=False):
            efficiency = [100 * table[name, n].efficiency(n) for n in RANKS]
            left.semilogx(RANKS, efficiency, line, color=colour, marker=marker, label=name)
        left.axhline(95.0, color="0.4", lw=1.2, ls=":", label="95 %")
        left.set(xlabel="ranks", ylabel="efficiency [%]", ylim=(0, 102))
        busy = [table["as it is", n] for n in RANKS]
        share = [100 * r.serving / r.seconds for r in busy]
        right.loglog(RANKS, share, "o-", color=BLUE, label="rank 0 busy with messages [%]")
        seconds = [r.seconds for r in busy]
        right.loglog(RANKS, seconds, "s--", color=ORANGE, label="time of the study [s]")
        longest = np.mean([c.speeds.max() for c in found["costs"].values()]) * len(CASES)
        label = "single longest speeds, four cases [s]"
        right.axhline(longest, color="0.4", lw=1.2, ls=":", label=label)
        right.set(xlabel="ranks", ylabel="share [%], time [s]")
        legend_below(left)
        legend_below(right, columns=1)
        figure.savefig(path, dpi=130)
        plt.close(figure)


def cost_figure(all_costs, path):
    """Costs of samples, and of samples in parts, by case."""
    with plt.rc_context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(12, 5.4))
        looks = zip(all_costs.items(), COLOURS, MARKERS, LINES, strict=False)
        for (n_bumps, c), colour, marker, line in looks:
            label, look = f"$n_d$ = {n_bumps}", {"color": colour, "ls": line}
            ordered = np.sort(c.whole)
            share = np.arange(1, len(ordered) + 1) / len(ordered)
            left.step(ordered, share, label=label, **look)
            counts = [1, *c.parts[0]]
            total = [1.0] + [sum(sum(p[n]) for p in c.parts) / c.whole.sum() for n in counts[1:]]
            longest = [c.whole.mean()] + [np.mean([max(p[n]) for p in c.parts]) for n in counts[1:]]
            right.plot(counts, total, marker=marker, label=f"{label}, all parts", **look)
            relative = np.array(longest) / c.whole.mean()
            right.plot(counts, relative, marker=marker, mfc="w", label="longest part", **look)
        left.set(xlabel="seconds per sample", ylabel="share of samples", ylim=(0, 1.02))
        right.set(xlabel="parts", ylabel="relative to the whole sample [-]", ylim=0)
        legend_below(left)
        legend_below(right)
        figure.savefig(path, dpi=130)
        plt.close(figure)
