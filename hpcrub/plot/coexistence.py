"""Figure of a branches study."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, Normalize

from hpcrub.contact.status import DIVERGED, NOT_STEADY
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.style import MARKERS, say, shades
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.coexistence import coexisting, stretches
from hpcrub.studies.branches import label_file, starts

LARGEST = 6  # branches with a marker of their own; the others share a dot
BAND = "0.88"
SHADES = LinearSegmentedColormap.from_list("localisation", shades(256))


@figure("branches", paper="17", what="stable motions, localisation", main=True)
def branches(canvas: Canvas) -> None:
    """Amplitudes over the speeds from several initial states, and the branches they belong to.

    Colours are the localisation everywhere, on one scale; in the first panel markers tell the
    initial states, in the others the branches. The first panel has one window of every state, as
    the steady-state test accepts it, the second the means of many windows; where branches coexist,
    a third looks closer at the longest such range of speeds.
    """
    file = canvas.file
    branch_of = label_file(file)
    several = coexisting(branch_of) > 1
    n = 2 + int(several.any())
    panels = canvas.panels(n, 1, (10, 5.0 * n))[:, 0]
    scale = _scale(file, branch_of)
    image = _draw_starts(panels[0], file, scale)
    _draw_branches(panels[1], file, branch_of, several, scale)
    panels[1].sharex(panels[0])
    panels[1].sharey(panels[0])
    if several.any():
        _draw_closer(panels[2], file, branch_of, several, scale)
    for panel in panels:
        panel.set(xlabel="speed of rotation [Hz]", ylabel="blade-tip amplitude [mm]")
        if panel.get_legend_handles_labels()[0]:
            canvas.legend_of(panel, columns=3)
    canvas.colorbar(image, panels, label="localisation factor [%]", aspect=40)


def _scale(file: ResultFile, branch_of: Any) -> dict[str, Any]:
    """Colours for all panels: localisation of all points drawn [%]."""
    local, of_windows = 100 * file.read("localisation"), _windows(file)[2]
    shown = np.concatenate([local[np.isfinite(local)], of_windows[branch_of >= 0], []])
    ends = (shown.min(), shown.max()) if len(shown) else (0.0, 100.0)
    return {"norm": Normalize(*ends), "cmap": SHADES, "lw": 0}


def _draw_starts(axes: Axes, file: ResultFile, scale: dict[str, Any]) -> Any:
    speeds, amplitude = file.read("speeds_hz"), 1e3 * file.read("amplitude_m")
    status, local = file.read("point_status"), 100 * file.read("localisation")
    for start, name in enumerate(starts(file.config)):
        marker = MARKERS[min(start, len(MARKERS) - 1)]
        known = status[start] != DIVERGED
        steady = known & (status[start] != NOT_STEADY)
        image = axes.scatter(
            speeds[steady], amplitude[start, steady], c=local[start, steady], s=22, marker=marker,
            **scale,
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
    return image


def _draw_branches(
    axes: Axes, file: ResultFile, branch_of: Any, several: Any, scale: dict[str, Any]
) -> None:
    speeds, n_windows = file.read("speeds_hz"), file.read("window_amplitude_m").shape[-1]
    _draw_bands(axes, speeds, several)
    _draw_points(axes, file, branch_of, range(branch_of.max() + 1), scale, 24)
    axes.set_title(
        f"means and standard deviations of {n_windows} windows;\n"
        "grey where several branches coexist", fontsize=11,
    )  # fmt: skip
    if branch_of.max() < 0:
        say(axes, "no point is steady")


def _draw_points(
    axes: Axes, file: ResultFile, branch_of: Any, shown: Sequence[int], scale: dict[str, Any],
    size: float,
) -> None:  # fmt: skip
    """Points of some branches: bars their scatter, colours their localisation."""
    speeds = file.read("speeds_hz")
    amplitude, scatter, local = _windows(file)
    for branch in shown:
        start, at = np.nonzero(branch_of == branch)
        x, y = speeds[at], amplitude[start, at]
        large = branch < LARGEST
        marker = MARKERS[branch] if large else "."
        axes.errorbar(x, y, scatter[start, at], fmt="none", ecolor="0.6", lw=0.7, zorder=1)
        axes.scatter(x, y, c=local[start, at], s=size, marker=marker, zorder=2, **scale)
        mean = local[branch_of == branch].mean()
        label = f"branch {branch + 1}: {mean:.0f} % localised"
        if large or branch == LARGEST:
            label = label if large else "smaller branches"
            axes.plot([], [], marker, color=SHADES(scale["norm"](mean)), ls="", label=label)


def _draw_closer(
    axes: Axes, file: ResultFile, branch_of: Any, several: Any, scale: dict[str, Any]
) -> None:
    """The longest stretch of speeds at which branches coexist, with as much on either side."""
    speeds = file.read("speeds_hz")
    first, last = max(stretches(several), key=np.ptp)
    near = slice(max(0, first - (last - first)), 2 * last - first)
    _draw_bands(axes, speeds, several)
    part = np.full_like(branch_of, -1)
    part[:, near] = branch_of[:, near]
    _draw_points(axes, file, part, [b for b in np.unique(part) if b >= 0], scale, 45)
    width = np.diff(speeds).min()
    axes.set_xlim(speeds[near][0] - width, speeds[near][-1] + width)
    axes.set_title("the longest range of speeds with several branches, closer", fontsize=11)


def _windows(file: ResultFile) -> tuple[Any, Any, Any]:
    """Means and standard deviations of the amplitudes [mm], means of the localisation [%]."""
    amplitude = 1e3 * file.read("window_amplitude_m")
    local = 100 * file.read("window_localisation")
    return amplitude.mean(axis=-1), amplitude.std(axis=-1, ddof=1), local.mean(axis=-1)


def _draw_bands(axes: Axes, speeds: Any, several: Any) -> None:
    width = np.diff(speeds).min() if len(speeds) > 1 else 1.0
    for speed in speeds[several]:
        axes.axvspan(speed - width / 2, speed + width / 2, color=BAND, lw=0, zorder=0)
