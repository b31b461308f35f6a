"""Checklist of a contact study: change of the amplitudes with every change of a setting."""

import numpy as np

from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.style import BLACK, BLUE, ORANGE
from hpcrub.results.storage import ResultFile
from hpcrub.studies.checklist import CHANGES, LEAST, moved


@figure("checklist", what="changes of the amplitude with one thing changed", main=True)
def checklist(canvas: Canvas, file: ResultFile) -> None:
    """Mean change of the largest amplitudes of a few disks, and every disk as a dot.

    Bars are 95 % intervals of the mean. Blue: of the computation; orange: of an input.
    """
    size = file.read("peak_amplitude_m")
    size[np.isinf(size)] = np.nan  # disks without a result
    rows = [n for n, change in enumerate(moved(size), 1) if np.isfinite(change[0])]
    axes = canvas.panels(1, 1, (9.5, 1.6 + 0.42 * len(rows)))[0, 0]
    axes.axvspan(-100 * LEAST, 100 * LEAST, color="0.92", zorder=0, label="below 1 %")
    axes.axvline(0.0, color=BLACK, lw=1.0)
    for place, n in enumerate(rows):
        mean, error, _ = moved(size)[n - 1]
        colour = BLUE if CHANGES[n].is_error else ORANGE
        single = 100 * (size[n] / size[0] - 1.0)
        axes.plot(single, np.full(len(single), place), ".", color="0.6", ms=5, zorder=1)
        axes.errorbar(100 * mean, place, xerr=100 * error, fmt="o", color=colour, capsize=4, ms=7)
    axes.plot([], [], "o", color=BLUE, label="of the computation")
    axes.plot([], [], "o", color=ORANGE, label="of an input")
    axes.plot([], [], ".", color="0.6", label="a disk")
    axes.set(yticks=range(len(rows)), yticklabels=[CHANGES[n].what for n in rows])
    axes.set(xlabel="change of the largest amplitude [%]", ylim=(len(rows) - 0.4, -0.6))
    axes.grid(visible=False, axis="y")
