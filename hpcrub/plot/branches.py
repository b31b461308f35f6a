"""Figure of a branches study."""

import matplotlib.pyplot as plt
import numpy as np

from hpcrub.layout import DIVERGED, NOT_STEADY
from hpcrub.plot.style import (
    BLACK,
    BLUE,
    GREEN,
    MARKERS,
    ORANGE,
    PINK,
    SKY,
    YELLOW,
    legend_below,
    say,
)
from hpcrub.studies.branches import N_WINDOWS, coexisting, label_file, starts

MOST = 6  # branches with a colour of their own


def branches(files):
    """Amplitudes from all initial states, coloured by localisation; below, by branch."""
    (file,) = files
    speeds, amplitude = file.read("speeds_hz"), 1e3 * file.read("amplitude_m")
    status, local = file.read("point_status"), 100 * file.read("localisation")
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(10, 9), sharex=True, sharey=True)
    shown = local[np.isfinite(local)] if np.isfinite(local).any() else np.array([0.0, 100.0])
    limits = {"vmin": shown.min(), "vmax": shown.max()}
    names = starts(file.config)
    for start, name in enumerate(names):
        marker = MARKERS[min(start, len(MARKERS) - 1)]
        known = status[start] != DIVERGED
        steady = known & (status[start] != NOT_STEADY)
        image = top.scatter(
            speeds[steady], amplitude[start, steady], c=local[start, steady], s=22, marker=marker,
            cmap="viridis", lw=0, **limits,
        )  # fmt: skip
        rough = known & ~steady
        top.plot(speeds[rough], amplitude[start, rough], marker, mfc="none", mec="0.6", ms=4)
        top.plot([], [], marker, color="0.3", ls="", label=name)
    top.plot([], [], "o", mfc="none", mec="0.6", ls="", label="not steady")
    if n_lost := np.count_nonzero(status == DIVERGED):
        top.set_title(f"{n_lost} of {status.size} points diverged, not shown", fontsize=11)
    figure.colorbar(image, ax=top, label="localisation factor [%]")
    top.legend(ncols=2, fontsize=10)
    _draw_branches(bottom, file)
    for panel in (top, bottom):
        panel.set_ylabel("blade-tip amplitude [mm]")
    margin = 0.04 * np.ptp(speeds) or 1.0
    bottom.set_xlim(speeds[0] - margin, speeds[-1] + margin)  # all speeds, those not shown too
    bottom.set_xlabel("speed of rotation [Hz]")
    return figure


def _draw_branches(axes, file):
    speeds, amplitude = file.read("speeds_hz"), file.read("mean_amplitude_m")
    scatter, local = file.read("amplitude_scatter_m"), file.read("mean_localisation")
    found = label_file(file)
    several = coexisting(found) > 1
    width = np.diff(speeds).min() if len(speeds) > 1 else 1.0
    for speed in speeds[several]:
        axes.axvspan(speed - width / 2, speed + width / 2, color="0.9", lw=0, zorder=0)
    colours = [BLUE, ORANGE, GREEN, PINK, YELLOW, SKY]
    for branch in range(found.max() + 1):
        start, at = np.nonzero(found == branch)
        named = branch < MOST
        axes.errorbar(
            speeds[at], 1e3 * amplitude[start, at], 1e3 * scatter[start, at], fmt="o", ms=4, lw=0.7,
            color=colours[branch] if named else BLACK,
            label=f"branch {branch + 1}, mean localisation {100 * local[start, at].mean():.0f} %"
            if named else None,
        )  # fmt: skip
    if found.max() >= MOST:
        axes.plot([], [], "o", ms=4, color=BLACK, label="smaller ones")
    axes.set_title(
        f"means and standard deviations of {N_WINDOWS} windows, by branch; grey where branches "
        "coexist", fontsize=11,
    )  # fmt: skip
    if found.max() < 0:
        say(axes, "no point is steady")
        return
    legend_below(axes)
