"""Figure of a branches study."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, Normalize

from hpcrub.contact.status import DIVERGED
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.style import MARKERS, say, shades
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.coexistence import coexisting, stretches
from hpcrub.studies.branches import label_file, starts

CLOSER = 0.5  # of the speeds, above which a closer look would show the same again
SHADES = LinearSegmentedColormap.from_list("localisation", shades(256))


@figure("branches", paper="17", what="stable motions, localisation", main=True)
def branches(canvas: Canvas) -> None:
    """Amplitudes over the speeds from several initial states, and the branches they belong to.

    A point is the mean of many windows after the steady-state test, its bar their standard
    deviation, its colour their localisation, its marker the initial state. A line joins the points
    of one branch. Speeds at which branches coexist are grey; where these are few, a second panel
    looks closer at the longest range of them. Points that are not steady are hollow.
    """
    file = canvas.file
    branch_of = label_file(file)
    several, speeds = coexisting(branch_of) > 1, file.read("speeds_hz")
    near = [slice(None), *_closer(several)]
    panels = canvas.panels(len(near), 1, (10, 0.6 + 4.6 * len(near)))[:, 0]
    local = 100 * file.read("window_localisation").mean(axis=-1)
    known = local[branch_of >= 0]
    scale = Normalize(*((known.min(), known.max()) if len(known) else (0.0, 100.0)))
    width = np.diff(speeds).min() if len(speeds) > 1 else 1.0
    for panel, part in zip(panels, near, strict=True):
        for speed in speeds[part][several[part]]:
            panel.axvspan(
                speed - width / 2, speed + width / 2, color="0.88", lw=0, zorder=0,
                label="several motions coexist",
            )  # fmt: skip
        image = _draw(panel, file, branch_of, part, scale)
        panel.set(xlabel="speed of rotation [Hz]", ylabel="blade-tip amplitude [mm]")
        margin = 0.02 * np.ptp(speeds[part]) + width
        panel.set_xlim(speeds[part][0] - margin, speeds[part][-1] + margin)
    if not len(known):
        say(panels[0], "no point is steady")
    panels[-1].set_title("closer" if len(near) > 1 else "")
    n_windows = file.read("window_amplitude_m").shape[-1]
    canvas.note(f"Means and standard deviations of {n_windows} windows.")
    n_lost = np.count_nonzero(file.read("point_status") == DIVERGED)
    if n_lost:
        canvas.note(f"{n_lost} of {branch_of.size} points diverged and are not shown.")
    canvas.colorbar(image, panels, label="localisation factor [%]", aspect=40)


def _closer(several: Any) -> list[slice]:
    """The longest stretch of speeds at which branches coexist, with as much on either side."""
    if not several.any():
        return []
    first, last = max(stretches(several), key=np.ptp)
    near = slice(max(0, first - (last - first)), 2 * last - first)
    return [near] if len(several[near]) < CLOSER * len(several) else []


def _draw(axes: Axes, file: ResultFile, branch_of: Any, part: slice, scale: Normalize) -> Any:
    """Points and branches at a part of the speeds; returns what has the colours."""
    speeds, found = file.read("speeds_hz")[part], branch_of[:, part]
    windows = 1e3 * file.read("window_amplitude_m")[:, part]
    amplitude, scatter = windows.mean(axis=-1), windows.std(axis=-1, ddof=1)
    local = 100 * file.read("window_localisation")[:, part].mean(axis=-1)
    for branch in np.unique(found[found >= 0]):
        line = np.ma.masked_array(amplitude, found != branch).mean(axis=0)
        axes.plot(speeds, line, color="0.6", lw=1, zorder=1)
    for start, name in enumerate(starts(file.config)):
        marker, steady = MARKERS[min(start, len(MARKERS) - 1)], found[start] >= 0
        axes.errorbar(
            speeds[steady], amplitude[start, steady], scatter[start, steady], fmt="none",
            ecolor="0.6", lw=0.7, zorder=1,
        )  # fmt: skip
        image = axes.scatter(
            speeds[steady], amplitude[start, steady], c=local[start, steady], s=26, marker=marker,
            norm=scale, cmap=SHADES, lw=0, zorder=2,
        )  # fmt: skip
        rough = ~steady & (file.read("point_status", start)[part] != DIVERGED)
        single = 1e3 * file.read("amplitude_m", start)[part][rough]
        axes.plot(speeds[rough], single, marker, mfc="none", mec="0.7", ms=3, zorder=1)
        axes.plot([], [], marker, color="0.3", ls="", label=f"from: {name}")
        if rough.any():
            axes.plot([], [], "o", mfc="none", mec="0.6", ls="", label="not steady")
    return image
