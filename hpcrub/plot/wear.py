"""Worn depth of a coating: around the casing, over the speeds, from disk to disk."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from hpcrub.config.text import counted
from hpcrub.effects.coating import REACHED, depth_of_all
from hpcrub.errors import InputError
from hpcrub.plot import intervals
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.responses import SPEED, draw_all, size
from hpcrub.plot.style import BLACK, BLUE, ORANGE, PINK, edges, marker, polar, shades
from hpcrub.results.samples import of_levels
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import with_interval
from hpcrub.studies.contact import findings

DEPTH = "worn depth [mm]"
INNER, GROOVE = 0.55, 0.4  # radius of the new coating and largest depth in the round drawing


@figure("contact", what="worn depth around the casing and from disk to disk", needs="wear")
def wear(canvas: Canvas, file: ResultFile) -> None:
    """The worn coating: around the casing, over speed and angle, over the speeds, of all disks.

    Around the casing and over the angle it is that of the tuned disk. Of random samples: the range
    of the widest level at every speed, and which share of the disks cuts at most so deep, with
    percentiles and their intervals. Of an explicit pattern: its depths and largest amplitudes.
    """
    around, over, depths, disks = canvas.panels(2, 2, (13.5, 10.6)).flat
    worn, speeds = 1e3 * file.read("tuned/worn_m").max(axis=1), file.read("speeds_hz")
    if not np.isfinite(worn).any():
        raise InputError(f"{file.path} has no worn depth of the tuned disk at any speed")
    _draw_around(around, file, worn)
    thickness = file.config.contact.coating.thickness_mm
    angle = np.append(file.read("angle_deg"), 360.0)
    image = over.pcolormesh(
        angle, edges(speeds), worn, cmap="viridis", vmin=0.0, vmax=np.nanmax(worn) or thickness,
        rasterized=True,
    )  # fmt: skip
    over.set(xlabel="angle of the casing [deg]", ylabel=SPEED, title="tuned disk, all speeds")
    over.set_xticks(range(0, 361, 60))
    over.grid(False)
    canvas.figure.colorbar(image, ax=[over], label=DEPTH)
    draw_all(depths, file, "worn_depth_m")
    if file.config.pattern_deviation is None:
        _draw_disks(disks, file)
    else:
        draw_all(disks, file)
        disks.set(ylabel=size(file), title="largest amplitude at every speed")
    depths.set(ylabel=DEPTH, title="largest depth at every speed")
    bound = 1e3 * depth_of_all(file.config)
    if depths.dataLim.y1 >= REACHED * bound:
        rest = f"worn through: {bound:.3g} mm, the rest of {thickness:g} mm is compacted"
        depths.axhline(bound, color=PINK, lw=1.6, ls=":", label=rest)
    canvas.note(*findings.short(file))


def _draw_around(axes: Axes, file: ResultFile, worn: Any) -> None:
    """Draw the deepest groove around the casing, to a scale of its own, with rings of even depths.

    worn: depths at every speed (S, A) [mm]; among equal depths the largest amplitude decides.
    """
    speeds, motion = file.read("speeds_hz"), np.nan_to_num(file.read("tuned/largest_amplitude_m"))
    shown = int(np.lexsort((motion, np.nan_to_num(worn).max(axis=1)))[-1])
    worn, what = worn[shown], "" if np.nanmax(worn) > 0.0 else ": nothing is worn"
    axes.set_title(f"tuned disk, {speeds[shown]:g} Hz{what}")
    phi = np.radians(np.append(file.read("angle_deg"), 360.0))
    depth, top = np.append(worn, worn[0]), float(np.nanmax(worn)) or 1.0
    groove = polar(INNER + GROOVE * depth / top, phi), polar(INNER, phi[::-1])
    axes.fill(*np.hstack(groove), color=ORANGE, alpha=0.85, lw=0)
    axes.plot(*polar(INNER, phi), color=BLACK, lw=1.2)
    for ring in MaxNLocator(3, min_n_ticks=2).tick_values(0.0, top)[1:]:
        if ring <= 1.05 * top:
            at = INNER + GROOVE * ring / top
            axes.plot(*polar(at, phi), color="0.3", lw=0.8, ls=":", zorder=4)
            axes.annotate(
                f"{ring:g} mm", polar(at, 0.7), fontsize=9, color="0.25", ha="center", va="center",
                bbox={"fc": "w", "ec": "none", "alpha": 0.8, "pad": 0.5}, zorder=5,
            )  # fmt: skip
    for turn in range(4):
        x, y = polar(INNER - 0.12, 0.5 * np.pi * turn)
        axes.text(x, y, f"{90 * turn}°", ha="center", va="center", fontsize=10)
    axes.text(0, 0, "worn\ndepth", ha="center", va="center", fontsize=11)
    axes.set_aspect("equal")
    axes.set_axis_off()


def _draw_disks(axes: Axes, file: ResultFile) -> None:
    """Draw the share of disks over the largest depth they cut, and percentiles, for every level."""
    at, half_range = file.config.convergence.percentiles, 100 * file.read("half_range")
    colours = [BLUE] if len(half_range) == 1 else shades(len(half_range))
    deepest, bound = of_levels(file, "deepest_m"), REACHED * depth_of_all(file.config)
    for values, level, colour in zip(deepest, half_range, colours, strict=True):
        depth = 1e3 * np.sort(values)
        if not len(depth):
            continue
        share = 100 * np.arange(1, len(depth) + 1) / len(depth)
        axes.step(depth, share, where="post", color=colour, label=f"±{level:.3g} %, disks")
        interval = with_interval(depth, at)
        intervals.draw(axes, at, interval, colour, sideways=True)
        for p, value in enumerate(interval[0]):
            axes.plot(value, at[p], marker(p), color=colour, ms=7)
    through = sum(int(np.count_nonzero(values >= bound)) for values in deepest) or "none"
    disks = counted(len(deepest[-1]), "disk") + " per level" * (len(deepest) > 1)
    tuned = 1e3 * float(np.nanmedian(file.read("tuned/run_deepest_m")))
    axes.axvline(tuned, color=BLACK, lw=1.6, ls="--", label="tuned disk, median of its runs")
    axes.set(
        xlabel=f"largest {DEPTH}", ylabel="disks that cut at most so deep [%]", ylim=(0, 102),
        xlim=(0, 1.05 * axes.dataLim.x1 or None),
        title=f"{disks}, worn through by {through} of all {sum(map(len, deepest))}",
    )  # fmt: skip
