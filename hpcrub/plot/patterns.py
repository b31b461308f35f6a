"""Patterns of blade types: their rank, and the best ones in contact."""

import numpy as np
from matplotlib.axes import Axes

from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.style import BLACK, BLUE, ORANGE
from hpcrub.results.storage import ResultFile
from hpcrub.studies.patterns import Rounds, in_letters


@figure("patterns", what="patterns of blade types, ranked", main=True)
def patterns(canvas: Canvas, file: ResultFile) -> None:
    """Percentile of the linear amplification of all patterns, and of those left beside contact.

    Every pattern is drawn with the disks that it had when it was dropped; the dotted line is the
    disk without a pattern.
    """
    rounds = Rounds(file)
    in_contact = np.isfinite(file.read("contact_amplitude_m")).any()
    panels = canvas.panels(1, 3 if in_contact else 2, (17.0 if in_contact else 12.0, 5.2))[0]
    _draw_all(panels[0], file, rounds)
    rows = [*rounds.left, 0]
    for panel in panels[1:]:
        panel.set(yticks=range(len(rows)), ylim=(len(rows) - 0.4, -0.6))
        panel.set_yticklabels([])
        panel.locator_params(axis="x", nbins=6)
        panel.grid(visible=False, axis="y")
    panels[1].set_yticklabels([in_letters(rounds.words[p]) for p in rows], family="monospace")
    _draw_left(panels[1], file, rounds, rows)
    if in_contact:
        _draw_contact(panels[2], file, rows)


def _draw_all(axes: Axes, file: ResultFile, rounds: Rounds) -> None:
    """Draw the percentile of every pattern, sorted; the shade tells the number of its disks."""
    order = 1 + np.argsort(rounds.percentile[1:])
    place = np.arange(1, len(order) + 1)
    for n in sorted(set(rounds.n_disks[1:])):
        these = rounds.n_disks[order] == n
        shade = 0.25 + 0.75 * np.log(max(n, 2)) / np.log(max(rounds.most, 2))
        axes.plot(place[these], rounds.percentile[order][these], ".", ms=5, color=BLUE, alpha=shade)
    axes.axhline(rounds.percentile[0], color=BLACK, lw=1.2, ls=":", label="no pattern")
    axes.plot([], [], ".", ms=7, color=BLUE, label="patterns; the darker, the more disks")
    at = file.config.patterns.percentile
    axes.set(xlabel="rank", ylabel=f"percentile {at:g} of the linear amplification")


def _draw_left(axes: Axes, file: ResultFile, rounds: Rounds, rows: list[int]) -> None:
    """Draw linear amplifications of the last patterns: median, and the percentile that ranks."""
    at = 50.0, file.config.patterns.percentile
    for place, p in enumerate(rows):
        values = file.read("amplification", p)[: rounds.n_disks[p]]
        values = np.where(np.isfinite(values), values, np.inf)  # flutter ranks as the worst
        middle, high = np.percentile(values, at, method="higher")
        axes.plot([middle, high], [place, place], "-", color=BLUE, lw=1.0)
        axes.plot(middle, place, "o", color=BLUE, ms=5)
        axes.plot(high, place, "^", color=BLUE, ms=7)
    axes.plot([], [], "o", color=BLUE, ms=5, label="median")
    axes.plot([], [], "^", color=BLUE, ms=7, label=f"percentile {at[1]:g}")
    axes.set(xlabel="linear amplification", title="patterns left")


def _draw_contact(axes: Axes, file: ResultFile, rows: list[int]) -> None:
    """Draw the largest amplitudes in contact of the disks of the last patterns."""
    for place, p in enumerate(rows):
        size = 1e3 * file.read("contact_amplitude_m", p)
        size = size[np.isfinite(size)]
        axes.plot(size, np.full(len(size), place), ".", color="0.6", ms=4)
        if size.size:
            axes.plot(np.median(size), place, "o", color=ORANGE, ms=6)
    axes.plot([], [], ".", color="0.6", label="a disk")
    axes.plot([], [], "o", color=ORANGE, label="median in contact")
    axes.set(xlabel="largest amplitude in contact [mm]", title="the same in contact")
