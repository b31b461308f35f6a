"""Figure of a small probability by double sampling: first looks, full results, and the tail."""

import numpy as np
from matplotlib.axes import Axes

from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.style import BLACK, BLUE, GREEN, ORANGE
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.rare import count, estimate, extrapolated
from hpcrub.studies.contact.limits import severities
from hpcrub.studies.rare import answer, in_full, last_estimate

MOST = 3000  # largest number of disks that are drawn


@figure("rare", what="a small probability of exceeding a limit", main=True)
def rare(canvas: Canvas, file: ResultFile) -> None:
    """Full results over first looks, and the probability of exceeding parts of the limit.

    Bars are 95 % intervals. Two distributions are fitted to all results and extrapolated, with the
    95 % scatter of their bootstrap: these are no results, and are drawn beside.
    """
    looks, tail = canvas.panels(1, 2, (13.0, 5.2))[0]
    n = last_estimate(file)[0]
    _draw_looks(looks, file, n)
    if np.isfinite(severities(file)[:n]).any():
        _draw_tail(tail, file, n)
    canvas.note(answer(file))


def _draw_looks(axes: Axes, file: ResultFile, n: int) -> None:
    """Draw severity over the first look; colours tell disks that were certain to be computed."""
    every = file.read("look"), severities(file), file.read("inclusion")
    look, size, inclusion = (values[:n][in_full(file)[:n]][:MOST] for values in every)
    for chosen, color, words in (
        (inclusion == 1.0, BLUE, "computed in any case"),
        (inclusion < 1.0, ORANGE, "drawn, each stands for several"),
    ):
        axes.plot(look[chosen], size[chosen], ".", ms=4, color=color, label=words)
    axes.axhline(1.0, color=BLACK, lw=1.2, ls=":", label="limit")
    axes.set(xlabel="first look, part of the limit", ylabel="full result, part of the limit")


def _draw_tail(axes: Axes, file: ResultFile, n: int) -> None:
    """Draw the probability of exceeding parts of the limit, with extrapolations."""
    size, inclusion, computed = severities(file)[:n], file.read("inclusion")[:n], in_full(file)[:n]
    known = computed & np.isfinite(size)
    low, high = np.quantile(size[known], 0.3), max(1.0, size[known].max())
    at = np.linspace(low, high + 0.1 * (high - low), 40)
    chance = np.array([estimate(count(computed & ~(size <= one), inclusion)) for one in at]).T
    some = chance[0] > 0.0
    bars = np.abs(chance[1:] - chance[0])[:, some]
    axes.errorbar(
        at[some], chance[0, some], bars, fmt="o", ms=4, color=BLUE, capsize=2, label="disks"
    )
    varied = np.ptp(size[known]) > 0.0
    curves = extrapolated(size[known], 1.0 / inclusion[known], at) if varied else {}
    for color, (name, (least, middle, most)) in zip((ORANGE, GREEN), curves.items(), strict=False):
        axes.fill_between(at, least, most, color=color, alpha=0.2, lw=0)
        axes.plot(at, middle, "--", lw=1.2, color=color, label=f"extrapolation: {name}")
    axes.axvline(1.0, color=BLACK, lw=1.2, ls=":", label="limit")
    axes.set(yscale="log", ylim=(0.1 / n, 1.3))
    axes.set(xlabel="part of the limit", ylabel="probability of exceeding it")
