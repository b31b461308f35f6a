"""Figure of a branches study."""

import matplotlib.pyplot as plt
import numpy as np

from hpcrub.contact.status import DIVERGED, NOT_STEADY
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
from hpcrub.statistics.coexistence import coexisting, stretches
from hpcrub.studies.branches import label_file, starts

COLOURS = [BLUE, ORANGE, GREEN, PINK, YELLOW, SKY]  # of branches; black for the others
BAND = "0.8"


def branches(files):
    """Amplitudes coloured by localisation; means by branch; where branches coexist, a closer view.

    The first panel has all initial states, as the steady-state test accepts them.
    """
    (file,) = files
    found = label_file(file)
    several = coexisting(found) > 1
    n_panels = 2 + several.any()
    figure, panels = plt.subplots(n_panels, 1, figsize=(10, 4.6 * n_panels))
    _draw_starts(panels[0], file)
    _draw_branches(panels[1], file, found, several)
    panels[1].sharex(panels[0])
    panels[1].sharey(panels[0])
    if several.any():
        _draw_closer(panels[2], file, found, several)
    for panel in panels:
        panel.set(xlabel="speed of rotation [Hz]", ylabel="blade-tip amplitude [mm]")
    return figure


def _draw_starts(axes, file):
    speeds, amplitude = file.read("speeds_hz"), 1e3 * file.read("amplitude_m")
    status, local = file.read("point_status"), 100 * file.read("localisation")
    limits = _limits(local)
    for start, name in enumerate(starts(file.config)):
        marker = MARKERS[min(start, len(MARKERS) - 1)]
        known = status[start] != DIVERGED
        steady = known & (status[start] != NOT_STEADY)
        image = axes.scatter(
            speeds[steady], amplitude[start, steady], c=local[start, steady], s=22, marker=marker,
            lw=0, **limits,
        )  # fmt: skip
        rough = known & ~steady
        axes.plot(speeds[rough], amplitude[start, rough], marker, mfc="none", mec="0.6", ms=4)
        axes.plot([], [], marker, color="0.3", ls="", label=name)
    axes.plot([], [], "o", mfc="none", mec="0.6", ls="", label="not steady")
    n_lost = np.count_nonzero(status == DIVERGED)
    lost = f"; {n_lost} of {status.size} points diverged, not shown" if n_lost else ""
    axes.set_title("one window of every initial state" + lost, fontsize=11)
    margin = 0.04 * np.ptp(speeds) or 1.0
    axes.set_xlim(speeds[0] - margin, speeds[-1] + margin)  # all speeds, those not shown too
    axes.legend(ncols=2, fontsize=10)
    _draw_scale(axes, image)


def _draw_branches(axes, file, found, several):
    speeds, n_windows = file.read("speeds_hz"), file.read("window_amplitude_m").shape[-1]
    amplitude, scatter, local = _windows(file)
    _draw_bands(axes, speeds, several)
    for branch in range(found.max() + 1):
        start, at = np.nonzero(found == branch)
        label = f"branch {branch + 1}, mean localisation {local[start, at].mean():.0f} %"
        if branch >= len(COLOURS):
            label = "smaller ones" if branch == len(COLOURS) else None
        axes.errorbar(
            speeds[at], amplitude[start, at], scatter[start, at], fmt="o", ms=4, lw=0.7,
            color=COLOURS[branch] if branch < len(COLOURS) else BLACK, label=label,
        )  # fmt: skip
    axes.set_title(
        f"means and standard deviations of {n_windows} windows, by branch; grey where several "
        "coexist", fontsize=11,
    )  # fmt: skip
    if found.max() < 0:
        say(axes, "no point is steady")
        return
    legend_below(axes)


def _draw_closer(axes, file, found, several):
    """The longest stretch of speeds at which branches coexist, with as much on either side."""
    speeds = file.read("speeds_hz")
    amplitude, scatter, local = _windows(file)
    first, last = max(stretches(several), key=np.ptp)
    near = slice(max(0, first - (last - first)), 2 * last - first)
    _draw_bands(axes, speeds, several)
    mine = np.zeros_like(found, dtype=bool)
    mine[:, near] = found[:, near] >= 0
    limits = _limits(local[mine])
    for rank, branch in enumerate(np.unique(found[mine])):
        start, at = np.nonzero(mine & (found == branch))
        x, y = speeds[at], amplitude[start, at]
        marker = MARKERS[rank % len(MARKERS)]
        axes.errorbar(x, y, scatter[start, at], fmt="none", ecolor="0.5", lw=0.7, zorder=1)
        image = axes.scatter(x, y, c=local[start, at], s=45, marker=marker, lw=0, **limits)
        axes.plot([], [], marker, color="0.3", ls="", label=f"branch {branch + 1}")
    width = np.diff(speeds).min()
    axes.set_xlim(speeds[near][0] - width, speeds[near][-1] + width)
    axes.set_title("the same closer, with their mean localisation in colour", fontsize=11)
    axes.legend(fontsize=10)
    _draw_scale(axes, image)


def _limits(local):
    shown = local[np.isfinite(local)] if np.isfinite(local).any() else np.array([0.0, 100.0])
    return {"vmin": shown.min(), "vmax": shown.max(), "cmap": "viridis"}


def _draw_scale(axes, image):
    axes.figure.colorbar(image, ax=axes, label="localisation factor [%]")


def _windows(file):
    """Means and standard deviations of the amplitudes [mm], means of the localisation [%]."""
    amplitude = 1e3 * file.read("window_amplitude_m")
    local = 100 * file.read("window_localisation")
    return amplitude.mean(axis=-1), amplitude.std(axis=-1, ddof=1), local.mean(axis=-1)


def _draw_bands(axes, speeds, several):
    width = np.diff(speeds).min() if len(speeds) > 1 else 1.0
    for speed in speeds[several]:
        axes.axvspan(speed - width / 2, speed + width / 2, color=BAND, lw=0, zorder=0)
