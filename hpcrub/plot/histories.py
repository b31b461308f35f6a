"""Figure of a time_response study."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from hpcrub.contact import status
from hpcrub.contact.status import AVERAGED, DIVERGED
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.style import BLUE, GREEN, ORANGE, say
from hpcrub.results.storage import ResultFile
from hpcrub.studies.time_response import first_known

CLOSE_REVOLUTIONS = 3  # shown at the end, next to the whole history
BINS = 500  # of the envelope of a whole history
DISKS = ("tuned disk", "mistuned disk")
ENVELOPE = "0.87"
ROWS = (
    ("tangential_m", 1e3, "tangential\ndisplacement [mm]"),
    ("radial_m", 1e3, "radial\ndisplacement [mm]"),
    ("gap_m", 1e3, "gap [mm]"),
    ("force_n", 1e-3, "radial contact\nforce [kN]"),
)


@figure("time_response", paper="5", what="displacements, gaps, forces", main=True)
def time_response(canvas: Canvas) -> None:
    """Motion, gap and contact force of one tip, and the envelope of all of them.

    The tip is that with the largest tangential displacement in the last revolutions. Left the whole
    history with the windows of the steady-state test, right the last three revolutions.
    """
    file = canvas.file
    disk = len(file.read("deviation")) - 1
    t, config = file.read("time_s"), file.config
    axes = canvas.panels(len(ROWS), 2, (13, 11), sharex="col", sharey="row", width_ratios=(1.6, 1))
    close = t > t[-1] - CLOSE_REVOLUTIONS / config.speeds.from_hz
    shown = np.nan_to_num(np.abs(file.read("tangential_m", disk)[close]))
    tip = int(shown.max(axis=0).argmax())
    for (name, scale, label), (left, right) in zip(ROWS, axes, strict=True):
        values = scale * file.read(name, disk)
        left.fill_between(
            *envelope(t, values), color=ENVELOPE, lw=0, label="tips, the smallest to the largest"
        )
        right.fill_between(
            t[close], values[close].min(axis=1), values[close].max(axis=1), color=ENVELOPE, lw=0
        )
        left.plot(t, values[:, tip], color=BLUE, lw=0.5, rasterized=True)
        right.plot(t[close], values[close, tip], color=BLUE, lw=1.4, label=_name(file, tip))
        left.set_ylabel(label)
    if file.read("point_status", disk) == DIVERGED:
        for panel in axes[:, 0]:
            say(panel, status.words(file.read("point_reason", disk)))
    else:
        _draw_windows(axes[0, 0], file, disk)
    axes[0, 1].set_title(f"last {CLOSE_REVOLUTIONS} revolutions", fontsize=11)
    for panel, part in zip(axes[-1], (t, t[close]), strict=True):
        panel.set(xlabel="time [s]", xlim=(part[0], part[-1]))
    canvas.title(f"{DISKS[disk]}, {config.casing.words}, {config.speeds.from_hz:g} Hz")


@figure("time_response", what="amplitude and worn depth over time", coated=True)
def cutting(canvas: Canvas) -> None:
    """Tangential displacements of all tips, and the largest worn depth of the coating, over time.

    A column for every disk. The motion grows while it cuts, and dies when enough is cut.
    """
    file = canvas.file
    n_disks, config = len(file.read("deviation")), file.config
    axes = canvas.panels(2, n_disks, (1.5 + 6.0 * n_disks, 7.5), sharex=True, sharey="row")
    for disk, (top, bottom) in enumerate(axes.T):
        motion = 1e3 * np.nan_to_num(file.read("tangential_m", disk))
        top.fill_between(*envelope(file.read("time_s"), motion), color=BLUE, lw=0)
        largest = np.unravel_index(np.abs(motion).argmax(), motion.shape)
        top.plot(
            file.read("time_s")[largest[0]], motion[largest], "o", color=ORANGE,
            label=f"largest: {np.abs(motion[largest]):.1f} mm, blade {largest[1] + 1}",
        )  # fmt: skip
        depth = 1e3 * file.read("worn_depth_m", disk)
        bottom.plot(
            file.read("block_s"), depth, color=ORANGE, label=f"in the end {depth[-1]:.2f} mm"
        )
        top.set(title=DISKS[disk])
        bottom.set(xlabel="time [s]", xlim=(0.0, file.read("time_s")[-1]))
        for panel in (top, bottom):
            panel.legend(loc="upper right" if panel is top else "lower right", frameon=True)
    axes[0, 0].set_ylabel("tangential displacement\nof all tips [mm]")
    axes[1, 0].set_ylabel("largest worn\ndepth [mm]")
    canvas.title(f"{config.casing.words}, {config.speeds.from_hz:g} Hz")


def _name(file: ResultFile, point: int) -> str:
    """Blade of a contact point, and which of its points it is where it has several."""
    if file.config.disk.n_points == file.config.disk.n_blades:
        return f"blade {point + 1}"
    blades = file.read("contact_blade")
    mine = np.flatnonzero(blades == blades[point])
    place = int(np.searchsorted(mine, point)) + 1
    return f"blade {blades[point] + 1}, contact node {place} of {len(mine)}"


def envelope(time: Any, values: Any) -> tuple[Any, Any, Any]:
    """Middles of `BINS` parts of a history [s], smallest and largest of all values in each.

    time: (T,) [s]; values: (T, N), in any unit.
    """
    first = np.unique(np.linspace(0, len(time), BINS, endpoint=False).astype(int))
    low = np.minimum.reduceat(values.min(axis=1), first)
    high = np.maximum.reduceat(values.max(axis=1), first)
    last = np.append(first[1:], len(time)) - 1
    return (time[first] + time[last]) / 2, low, high


def _draw_windows(axes: Axes, file: ResultFile, disk: int) -> None:
    """The two windows of the first check that was passed, or of the last one."""
    checks, window = file.read("check_s"), float(file.read("window_s"))
    if not len(checks):
        axes.set_title("ends before the first check of the steady state", fontsize=11)
        return
    passed, status_of = first_known(file, disk), file.read("point_status", disk)
    check = len(checks) - 1 if passed is None else passed
    word = "averaged" if status_of == AVERAGED else "steady"
    end, word = checks[check], "not steady" if passed is None else word
    for k, colour, name in ((2, ORANGE, "first window compared"), (1, GREEN, "second window")):
        begin = end - k * window
        axes.axvspan(begin, begin + window, color=colour, alpha=0.35, lw=0, label=name)
    for i, other in enumerate(checks):
        label = None if i else "checks of the steady state"
        axes.axvline(other, color="0.4", lw=1, ls=":", label=label)
    axes.set_title(
        f"{word} at {end:.3f} s: correlation {file.read('correlation', disk)[check]:.3f}, "
        f"amplitude change {100 * file.read('amplitude_change', disk)[check]:.2g} %",
        fontsize=11,
    )
