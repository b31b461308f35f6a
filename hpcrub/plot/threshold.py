"""Figure of a key's value that meets a limit: probability and amplitudes over the values."""

import numpy as np
from matplotlib.axes import Axes

from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.intervals import LEVEL
from hpcrub.plot.style import BLACK, BLUE, ORANGE
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import with_interval
from hpcrub.studies.threshold import answer

LEAST = 1e-4  # probability at the foot of the figure


@figure("threshold", what="probability of exceeding a limit over a key", main=True)
def threshold(canvas: Canvas, file: ResultFile) -> None:
    """Probability of exceeding the limit at the values looked at, and the amplitudes there.

    Bars are 95 % intervals, numbers the disks computed. Between the two values of the band the
    probability crosses the target.
    """
    chance, size = canvas.panels(1, 2, (13.0, 5.2))[0]
    _draw_probability(chance, file)
    _draw_amplitudes(size, file)
    crossing = file.read("crossing")
    for panel in (chance, size):
        if np.isfinite(crossing).all():
            panel.axvspan(*crossing, color=ORANGE, alpha=0.25, lw=0, label="crossing")
        panel.set_xlabel(file.config.threshold.key)
    canvas.note(answer(file))


def _draw_probability(axes: Axes, file: ResultFile) -> None:
    """Draw the share of disks beyond the limit, with its interval, at every value computed."""
    n, above = file.read("n_disks"), file.read("n_above")
    low, high = (file.read(f"probability_{end}") for end in ("low", "high"))
    seen = n > 0
    value, share = file.read("value")[seen], above[seen] / n[seen]
    ends = np.array([share - low[seen], high[seen] - share])
    axes.errorbar(value, share, ends, fmt="o", ms=5, color=BLUE, capsize=3, label="disks")
    for x, y, count in zip(value, high[seen], n[seen], strict=True):
        axes.annotate(
            f"{count}", (x, y), xytext=(0, 6), textcoords="offset points", ha="center",
            rotation=90, fontsize=8,
        )  # fmt: skip
    axes.axhline(file.config.threshold.probability, color=BLACK, lw=1.2, ls=":", label="target")
    foot = max(LEAST, 0.3 * min(file.config.threshold.probability, share[share > 0].min(initial=1)))
    axes.set(yscale="log", ylim=(foot, 2.5), ylabel="probability of exceeding the limit")


def _draw_amplitudes(axes: Axes, file: ResultFile) -> None:
    """Draw percentiles of the largest amplitudes of the disks computed at every value."""
    peaks, n = 1e3 * file.read("peak_amplitude_m"), file.read("n_disks")
    at = file.config.convergence.percentiles
    for value, row, count in zip(file.read("value"), peaks, n, strict=True):
        known = row[:count][np.isfinite(row[:count])]
        if not len(known):
            continue
        percentiles, low, high = with_interval(known, at)
        axes.plot(np.full(len(at), value), percentiles, "-o", ms=4, lw=1.0, color=BLUE)
        axes.vlines(np.full(len(at), value), low, high, color=BLUE, alpha=0.4, lw=5)
    axes.plot([], [], "-o", ms=4, color=BLUE, label="percentiles " + "/".join(f"{p:g}" for p in at))
    words = f"{LEVEL} intervals of these, where both ends are known"
    axes.vlines([], [], [], color=BLUE, alpha=0.4, lw=5, label=words)
    if file.config.limits.amplitude_mm is not None:
        axes.axhline(file.config.limits.amplitude_mm, color=BLACK, lw=1.2, ls=":", label="limit")
    axes.set(ylabel="largest amplitude [mm]", ylim=(0.0, None))
