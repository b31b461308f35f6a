"""Figures of a time_response study: histories, and an animation of the disk in its casing."""

from typing import Any

import numpy as np
from matplotlib.animation import FuncAnimation
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from hpcrub.config.schema import Config
from hpcrub.contact import status
from hpcrub.contact.status import AVERAGED, DIVERGED
from hpcrub.errors import InputError
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.style import BLUE, GREEN, ORANGE, YELLOW, polar, say
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
REVOLUTIONS = 2  # revolutions in the animation
FRAMES = 72  # pictures in these revolutions, every 10 degrees
BENT, GAP = 0.10, 0.07  # largest bending and largest gap at rest as drawn [tip radii]
HUB = 0.42  # radius of the disk as drawn [tip radii]
SHORTEST = 0.6  # smallest radius at which a tip is drawn [tip radii]
SPAN = np.linspace(0.0, 1.0, 9)  # places along a blade, 0 at the hub, 1 at the tip
TURN = 2.0 * np.pi
AROUND = np.linspace(0.0, TURN, 721)
THICKNESS = 0.015  # half the thickness of a blade with one contact point [rad]
TINY = 1e-12  # [m] size that replaces 0 for a disk that does not move
FACE, CASING = "0.82", "0.75"


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
    canvas.title(f"{DISKS[disk]}, {config.casing.words}, {config.speeds.from_hz:g} Hz")


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


@figure("time_response", what="the disk turning in its casing as a GIF", alone=False)
def rubbing(canvas: Canvas, file: ResultFile) -> FuncAnimation:
    """The disk in the last two revolutions, motions and gap enlarged, blades in contact marked.

    Of a study with a pattern, the mistuned disk. A blade is drawn bent as a beam from its root; all
    radial distances at the tips have one scale, so that a tip touches the casing where it rubs, and
    no blade is drawn shorter than `SHORTEST`.
    Returned is a matplotlib `FuncAnimation` instead of axes: keep it, or it stops.
    """
    disk = len(file.read("deviation")) - 1
    if file.read("point_status", disk) == DIVERGED:
        raise InputError(f"{file.path}: the motion diverged, there is nothing to show")
    time, angle, blade = file.read("time_s"), *_points(file)
    speed = file.config.speeds.from_hz
    last = np.linspace(time[-1] - REVOLUTIONS / speed, time[-1], FRAMES, endpoint=False)
    at = np.searchsorted(time, last)
    time = time[at]
    tangential, gap, force = (file.read(n, disk)[at] for n in ("tangential_m", "gap_m", "force_n"))
    waves = np.zeros((len(at), len(AROUND)))  # radial motion of the casing
    if "casing_radial_m" in file:
        places = np.radians(file.read("casing_angle_deg"))
        moved = file.read("casing_radial_m", disk)
        waves = np.array([np.interp(AROUND, places, w, period=TURN) for w in moved[at]])
    turns = TURN * speed * time
    turned = angle + turns[:, None]
    moved = _walls(file, time, turned, waves) - np.maximum(gap, 0.0)  # outward motion of the tips
    bent = BENT / max(np.abs(tangential).max(), TINY)
    outward = min(
        GAP / max(np.abs(_room(file, time[-1], AROUND) + waves).max(), TINY),
        (1.0 - SHORTEST) / max(-moved.min(), TINY),
    )
    axes = _axes(canvas, file.config, bent, outward)
    casing = axes.add_patch(Polygon(polar(1.0, AROUND).T, closed=True, fc="none", ec=CASING, lw=5))
    hub = polar(HUB, AROUND).T
    bodies = [axes.add_patch(Polygon(hub, lw=0.6)) for _ in range(blade.max() + 1)]
    (sparks,) = axes.plot([], [], "o", color=YELLOW, mec=ORANGE, ms=6)
    axes.add_patch(Polygon(hub, fc=FACE, ec=BLUE, lw=0.6))
    (mark,) = axes.plot([], [], color=BLUE, lw=2)

    def draw(frame: int) -> list[Any]:
        wall = 1.0 + outward * (_room(file, time[frame], AROUND) + waves[frame])
        casing.set_xy(polar(wall, AROUND).T)
        tip, rubs = 1.0 + outward * moved[frame], force[frame] > 0.0
        place = turned[frame] + bent * tangential[frame]
        for number, body in enumerate(bodies):
            mine = blade == number
            body.set_xy(_outline(turned[frame, mine], place[mine], tip[mine]))
            body.set(fc=ORANGE if rubs[mine].any() else FACE, ec=BLUE)
        sparks.set_data(*polar(tip, place)[:, rubs])
        mark.set_data(*polar(np.array([0.0, 0.9 * HUB]), turns[frame]))
        return [casing, *bodies, sparks, mark]

    return FuncAnimation(axes.get_figure(), draw, FRAMES, interval=40)


def _axes(canvas: Canvas, config: Config, bent: float, outward: float) -> Any:
    """Return axes as large as the casing, with the scales of bending and gap in the title."""
    axes = canvas.panels(1, 1, (5, 5.4))[0, 0]
    reach, radius = 1.03 + GAP, config.disk.tip_radius
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    axes.set_axis_off()
    axes.set_title(
        f"{config.casing.words}, {config.speeds.from_hz:g} Hz\n"
        f"bending × {bent * radius:.2g}, gap × {outward * radius:.2g}", fontsize=11,
    )  # fmt: skip
    return axes


def _points(file: ResultFile) -> tuple[Any, Any]:
    """Return angle [rad] and blade of every contact point, at rest and at time 0."""
    config = file.config
    if config.disk.n_points == config.disk.n_blades:
        blade = np.arange(config.disk.n_blades)
        return 2.0 * np.pi * blade / len(blade), blade
    angle, blade = file.read("contact_angle_rad"), file.read("contact_blade")
    first = angle[[int(np.argmax(blade == number)) for number in blade]]
    return first + np.angle(np.exp(1j * (angle - first))), blade  # no blade across the angle π


def _room(file: ResultFile, time: float, angle: Any) -> Any:
    """Return the distance [m] from the tips to the casing at a time, both without vibration."""
    shape = file.config.casing
    clearance = shape.clearances(file.config.speeds.from_hz)
    return shape.shape.gap(clearance, time, shape.growth_time, angle)


def _walls(file: ResultFile, times: Any, angles: Any, waves: Any) -> Any:
    """Return the distances (F, P) [m] of `_room`, with waves (F, AROUND) of the casing itself."""
    at = zip(times, angles, waves, strict=True)
    return np.array([_room(file, t, a) + np.interp(a, AROUND, w, period=TURN) for t, a, w in at])


def _outline(root: Any, place: Any, tip: Any) -> Any:
    """Return the outline (n, 2) of a blade; root, place: angles of its tips at rest and now."""
    order = np.argsort(root)
    middle, half = root.mean(), 0.5 * np.ptp(root) if len(root) > 1 else THICKNESS
    edges = []
    for end, side in zip(order[[0, -1]], (-half, half), strict=True):
        bend = SPAN**2 * (3.0 - SPAN) / 2.0 * (place[end] - root[end])  # a beam loaded at its tip
        edges.append(polar(HUB + (tip[end] - HUB) * SPAN, middle + side + bend))
    return np.hstack([edges[0], polar(tip, place)[:, order[1:-1]], edges[1][:, ::-1]]).T
