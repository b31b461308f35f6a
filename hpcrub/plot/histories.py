"""The figure of a time_response study: histories of one tip, and the envelope of all."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from hpcrub.contact import status
from hpcrub.contact.status import AVERAGED, DIVERGED
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.style import BLUE, GREEN, ORANGE, say
from hpcrub.results.storage import ResultFile
from hpcrub.studies.time_response import first_known

CLOSE_REVOLUTIONS = 3  # number of last revolutions shown beside the whole history
BINS = 500  # parts of the envelope of a whole history
DISKS = ("tuned disk", "mistuned disk")
ENVELOPE = "0.87"
ROWS = (
    ("tangential_m", 1e3, "tangential\ndisplacement [mm]"),
    ("radial_m", 1e3, "radial\ndisplacement [mm]"),
    ("gap_m", 1e3, "gap [mm]"),
    ("force_n", 1e-3, "radial contact\nforce [kN]"),
)


@figure("time_response", paper="5", what="displacements, gaps, forces", main=True)
def time_response(canvas: Canvas, file: ResultFile) -> None:
    """Motion, gap and contact force of one tip, the envelope of all; worn depth of a coating.

    The tip is that with the largest tangential displacement in the last revolutions. Left the whole
    history with the windows of the steady-state test, right the last three revolutions. Their title
    has max |u_t|, which holds the offset of the motion, and half of peak to peak, which does not.
    """
    disk = len(file.read("deviation")) - 1
    t, config = file.read("time_s"), file.config
    n = len(ROWS) + config.contact.wears
    axes = canvas.panels(n, 2, (13, 2.75 * n), sharex="col", sharey="row", width_ratios=(1.6, 1))
    close = t > t[-1] - CLOSE_REVOLUTIONS / config.speeds.from_hz
    motion = 1e3 * file.read("tangential_m", disk)[close]
    tip = int(np.nan_to_num(np.abs(motion)).max(axis=0).argmax())
    for (name, scale, label), (left, right) in zip(ROWS, axes, strict=False):
        values = scale * file.read(name, disk)
        tips = {"color": ENVELOPE, "lw": 0, "label": "tips, the smallest to the largest"}
        left.fill_between(*envelope(t, values), **tips)
        last = values[close]
        right.fill_between(t[close], last.min(axis=1), last.max(axis=1), color=ENVELOPE, lw=0)
        left.plot(t, values[:, tip], color=BLUE, lw=0.5, rasterized=True)
        right.plot(t[close], last[:, tip], color=BLUE, lw=1.4, label=_name(file, tip))
        left.set_ylabel(label)
    if file.read("point_status", disk) == DIVERGED:
        for panel in axes[:, 0]:
            say(panel, status.words(file.read("point_reason", disk)))
    else:
        _draw_windows(axes[0, 0], file, disk)
    axes[0, 1].set_title(
        f"last {CLOSE_REVOLUTIONS} revolutions: max $|u_t|$ {np.abs(motion[:, tip]).max():.3g} mm,"
        f"\nhalf of peak to peak {np.ptp(motion[:, tip]) / 2:.3g} mm", fontsize=11,
    )  # fmt: skip
    if config.contact.wears:
        axes[-1, 0].set_ylabel("largest worn\ndepth [mm]")
    for panel, part in zip(axes[-1], (t, t[close]), strict=True):
        if config.contact.wears:
            panel.plot(file.read("block_s"), 1e3 * file.read("worn_depth_m", disk), color=ORANGE)
        panel.set(xlabel="time [s]", xlim=(part[0], part[-1]))
    canvas.figure.suptitle(f"{DISKS[disk]}, {config.casing.words}, {config.speeds.from_hz:g} Hz")


def _name(file: ResultFile, point: int) -> str:
    """Return the name of a contact point: its blade, and its number on a blade with several."""
    if file.config.disk.n_points == file.config.disk.n_blades:
        return f"blade {point + 1}"
    blades = file.read("contact_blade")
    mine = np.flatnonzero(blades == blades[point])
    place = int(np.searchsorted(mine, point)) + 1
    return f"blade {blades[point] + 1}, contact node {place} of {len(mine)}"


def envelope(time: Any, values: Any) -> tuple[Any, Any, Any]:
    """Return middles of `BINS` parts of a history [s], and the smallest and largest value in each.

    time: (T,) [s]; values: (T, N), in any unit.
    """
    first = np.unique(np.linspace(0, len(time), BINS, endpoint=False).astype(int))
    low = np.minimum.reduceat(values.min(axis=1), first)
    high = np.maximum.reduceat(values.max(axis=1), first)
    last = np.append(first[1:], len(time)) - 1
    return (time[first] + time[last]) / 2, low, high


def _draw_windows(axes: Axes, file: ResultFile, disk: int) -> None:
    """Draw the two windows of the first check that was passed, else of the last check."""
    checks, window = file.read("check_s"), float(file.read("window_s"))
    if not len(checks):
        axes.set_title("ends before the first check of the steady state", fontsize=11)
        return
    passed = first_known(file, disk)
    check = len(checks) - 1 if passed is None else passed
    word = "averaged" if file.read("point_status", disk) == AVERAGED else "steady"
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
