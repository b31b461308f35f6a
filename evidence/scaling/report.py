"""Measurements and simulations → tables of docs/scaling.md."""

import os

import numpy as np

from evidence import page, progress
from evidence.scaling import program, simulate
from hpcrub.config.text import counted

RANKS = (10, 100, 1000, 10_000)
SAMPLES = 20_000  # of each case: 4 levels of 5000
MORE = 10  # times the samples, on the most ranks
ENOUGH = 400  # samples per rank are simulated, and count for all
VARIANTS = {"as it is": True, "samples never cut": False}  # whether samples are cut


def machine(found):
    """What a rank of this machine needs besides integrating in time, a `simulate.Machine`."""
    finish = np.median([costs.finish for costs in found["costs"].values()])
    alone = found["studies"][1]
    busy = (1.0 - alone["idle_share"]) * alone["core_seconds"]
    finish += alone["writing_share"] * busy / max(alone["done_in_this_run"], 1)
    return simulate.Machine(found["receive"], found["send"], float(finish))


def _cases(found, n_ranks, n_samples, cut):
    """Sums over the cases; finishing a sample is useful work too."""
    results, this = [], machine(found)
    total, n_samples = n_samples, min(n_samples, ENOUGH * n_ranks)
    for costs in found["costs"].values():
        told = simulate.study(costs, this, n_ranks, n_samples, cut)
        results.append(told._replace(useful=told.useful + n_samples * this.finish))
    sums = (sum(values) * total / n_samples for values in zip(*results, strict=True))
    return simulate.Result(*sums)


def write(found, all_ranks):
    """The parts of the page."""
    table = {}  # (variant, ranks): Result of all cases one after another
    names = [counted(n, "rank") for n in all_ranks]
    for n_ranks in progress.followed(all_ranks, "simulation", names=names):
        for name, cut in VARIANTS.items():
            table[name, n_ranks] = _cases(found, n_ranks, SAMPLES, cut)
    table["more samples", all_ranks[-1]] = _cases(found, all_ranks[-1], MORE * SAMPLES, True)
    this = machine(found)
    each = [
        ["rank 0: a message with a result", f"{1e6 * this.receive:.0f} µs"],
        ["rank 0: to send the next task", f"{1e6 * this.send:.0f} µs"],
        ["eigenproblem, linear peak and writing of a sample", f"{1e3 * this.finish:.1f} ms"],
        ["writing samples, of the time of two ranks (`writing_share` of the run log)",
         f"{100 * found['studies'][2]['writing_share']:.2f} %"],
    ]  # fmt: skip
    return {
        "costs": _costs(found["costs"]),
        "messages": page.table(["what", "takes"], each),
        "agreement": _agreement(found),
        "ranks": _ranks(table),
        "short": _short(table, len(found["costs"]), *all_ranks[-2:]),
    }


def _short(table, n_cases, many, _):
    """The sentence of the page on performance."""
    best = table["as it is", many]
    return (
        f"A study of {SAMPLES:,} disks takes about {best.useful / n_cases / 3600:.1f} core hours, "
        f"and {many:,} ranks lose {100 * (1 - best.efficiency(many)):.0f} % of it."
    )


def _costs(costs):
    rows = []
    for n_bumps, c in costs.items():
        most = max(c.parts[0])
        sums = [sum(parts[most]) for parts in c.parts]
        longest = max(max(parts[most]) for parts in c.parts)
        numbers = c.whole.mean(), c.whole.min(), c.whole.max(), c.speeds.max()
        mean, low, high, slowest = (f"{number:.3f}" for number in numbers)
        rows.append([n_bumps, mean, f"{low} to {high}", slowest, most, f"{longest:.3f}",
                     f"{np.sum(sums) / c.whole.sum():.2f}"])  # fmt: skip
    heads = ("n_d", "sample, mean [s]", "from, to [s]", "longest single speed [s]")
    heads += ("parts, at most", "longest part [s]", "all parts / whole")
    return page.table(heads, rows)


def _agreement(found):
    rows, this, n_samples = [], machine(found), found["studies"][1]["done_in_this_run"]
    costs, one = found["costs"][found["studied"]], program.integrating(found["studies"][1])
    speed = one / simulate.study(costs, this, 1, n_samples).seconds
    for n, summary in found["studies"].items():
        slower = this._replace(slowdown=speed * max(1.0, n / os.cpu_count()))
        told = simulate.study(costs, slower, n, n_samples).seconds
        real, idle = program.integrating(summary), f"{100 * summary['idle_share']:.1f} %"
        rows.append([n, f"{real:.1f}", f"{told:.1f}", f"{one / real:.2f}", idle])
    heads = ("ranks", "measured [s]", "simulated [s]", "speed-up", "ranks idle")
    return page.table(heads, rows)


def _ranks(table):
    columns = [n for name, n in table if name == "as it is"]
    rows = [[name, *(f"{100 * table[name, n].efficiency(n):.1f} %" for n in columns)]
            for name in VARIANTS]  # fmt: skip
    best = [table["as it is", n] for n in columns]
    rows.append(["time of the whole study", *(f"{r.seconds:.1f} s" for r in best)])
    busy = [f"{100 * r.serving / r.seconds:.1f} %" for r in best]
    rows.append(["rank 0 busy with messages", *busy])
    most = columns[-1]
    more = table["more samples", most]
    nothing = [""] * (len(columns) - 1)
    rows.append([f"with {MORE} times the samples, as it is", *nothing,
                 f"{100 * more.efficiency(most):.1f} %"])  # fmt: skip
    rows.append(["rank 0 busy with messages then", *nothing,
                 f"{100 * more.serving / more.seconds:.0f} %"])  # fmt: skip
    return page.table(["", *(f"{n:,} ranks" for n in columns)], rows)
