"""Measurements → tables of docs/scaling.md."""

import numpy as np

from evidence import page
from evidence.scaling import program


def write(found):
    """The parts of the page."""
    finish = np.median([costs.finish for costs in found["costs"].values()])
    alone = found["studies"][1]
    busy = (1.0 - alone["idle_share"]) * alone["core_seconds"]
    finish += alone["writing_share"] * busy / max(alone["done_in_this_run"], 1)
    each = [
        ["rank 0: a message with a result", f"{1e6 * found['receive']:.0f} µs"],
        ["rank 0: to send the next task", f"{1e6 * found['send']:.0f} µs"],
        ["eigenproblem, linear peak and writing of a sample", f"{1e3 * finish:.1f} ms"],
        ["writing samples, of the time of two ranks (`writing_share` of the run log)",
         f"{100 * found['studies'][2]['writing_share']:.2f} %"],
    ]  # fmt: skip
    return {
        "costs": _costs(found["costs"]),
        "messages": page.table(["what", "takes"], each),
        "studies": _studies(found["studies"]),
    }


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


def _studies(studies):
    rows, one = [], program.integrating(studies[1])
    for n, summary in studies.items():
        seconds, idle = program.integrating(summary), f"{100 * summary['idle_share']:.1f} %"
        rows.append([n, f"{seconds:.1f}", f"{one / seconds:.2f}", idle])
    return page.table(("ranks", "measured [s]", "speed-up", "ranks idle"), rows)
