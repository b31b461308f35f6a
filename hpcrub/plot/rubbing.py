"""The disk turning in its casing, seen along its axis: the last revolutions of a history."""

from typing import Any

import numpy as np
from matplotlib.animation import FuncAnimation
from matplotlib.patches import Polygon

from hpcrub.contact.status import DIVERGED
from hpcrub.errors import InputError
from hpcrub.model.casing import casing_height, ramp
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.style import BLUE, ORANGE, YELLOW
from hpcrub.results.storage import ResultFile

REVOLUTIONS = 2
FRAMES = 72  # of both, two a step of the rotation
BENT, GAP = 0.10, 0.07  # drawn largest bending, largest gap at rest, in tip radii
HUB = 0.42  # drawn radius of the disk, in tip radii
SPAN = np.linspace(0.0, 1.0, 9)  # along a blade, from the hub to the tip
AROUND = np.linspace(0.0, 2.0 * np.pi, 721)
THICKNESS = 0.015  # half, of a blade with one contact point [rad]
TINY = 1e-12  # [m] of a disk that does not move
FACE, CASING = "0.82", "0.75"


@figure("time_response", what="the disk turning in its casing as a GIF", alone=False)
def rubbing(canvas: Canvas) -> FuncAnimation:
    """The disk in the last two revolutions, motions and gap enlarged, blades in contact marked.

    Of a study with a pattern, the mistuned disk. A blade is drawn bent as a beam from its root; all
    radial distances at the tips have one scale, so that a tip touches the casing where it rubs.
    Returned is a matplotlib `FuncAnimation` instead of axes: keep it, or it stops.
    """
    file = canvas.file
    disk = len(file.read("deviation")) - 1
    if file.read("point_status", disk) == DIVERGED:
        raise InputError(f"{file.path}: the motion diverged, there is nothing to show")
    time, angle, blade = file.read("time_s"), *_points(file)
    speed = file.config.speeds.from_hz
    last = np.linspace(time[-1] - REVOLUTIONS / speed, time[-1], FRAMES, endpoint=False)
    at = np.searchsorted(time, last)
    time = time[at]
    tangential, gap, force = (
        file.read(name, disk)[at] for name in ("tangential_m", "gap_m", "force_n")
    )
    bent = BENT / max(np.abs(tangential).max(), TINY)
    outward = GAP / max(np.abs(_room(file, time[-1], AROUND)).max(), TINY)
    axes = _axes(canvas, bent, outward)
    casing = axes.add_patch(Polygon(_circle(1.0), closed=True, fc="none", ec=CASING, lw=5))
    bodies = [axes.add_patch(Polygon(_circle(HUB), lw=0.6)) for _ in range(blade.max() + 1)]
    (sparks,) = axes.plot([], [], "o", color=YELLOW, mec=ORANGE, ms=6)
    axes.add_patch(Polygon(_circle(HUB), fc=FACE, ec=BLUE, lw=0.6))
    (mark,) = axes.plot([], [], color=BLUE, lw=2)

    def draw(frame: int) -> list[Any]:
        turn = 2.0 * np.pi * speed * time[frame]
        casing.set_xy(_xy(1.0 + outward * _room(file, time[frame], AROUND), AROUND))
        turned, rubs = angle + turn, force[frame] > 0.0
        room = _room(file, time[frame], turned)
        tip = 1.0 + outward * (room - np.maximum(gap[frame], 0.0))
        place = turned + bent * tangential[frame]
        for number, body in enumerate(bodies):
            mine = blade == number
            body.set_xy(_outline(turned[mine], place[mine], tip[mine]))
            body.set(fc=ORANGE if rubs[mine].any() else FACE, ec=BLUE)
        sparks.set_data(*_xy(tip, place)[rubs].T)
        mark.set_data(*_xy(np.array([0.0, 0.9 * HUB]), turn).T)
        return [casing, *bodies, sparks, mark]

    return FuncAnimation(axes.get_figure(), draw, FRAMES, interval=40)


def _axes(canvas: Canvas, bent: float, outward: float) -> Any:
    """Axes as large as the casing, with both scales in the title."""
    axes, config = canvas.panels(1, 1, (5, 5.4))[0, 0], canvas.file.config
    reach, radius = 1.03 + GAP, config.disk.tip_radius
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    axes.set_axis_off()
    axes.set_title(
        f"{config.casing.words}, {config.speeds.from_hz:g} Hz\n"
        f"bending × {bent * radius:.2g}, gap × {outward * radius:.2g}", fontsize=11,
    )  # fmt: skip
    return axes


def _points(file: ResultFile) -> tuple[Any, Any]:
    """Angle [rad] and blade of every contact point, at rest and at the time zero."""
    config = file.config
    if config.disk.n_points == config.disk.n_blades:
        blade = np.arange(config.disk.n_blades)
        return 2.0 * np.pi * blade / len(blade), blade
    angle, blade = file.read("contact_angle_rad"), file.read("contact_blade")
    first = angle[[int(np.argmax(blade == number)) for number in blade]]
    return first + np.angle(np.exp(1j * (angle - first))), blade  # no blade across the angle π


def _room(file: ResultFile, time: float, angle: Any) -> Any:
    """Distance of the casing from the circle of the tips at rest [m]."""
    shape = file.config.casing
    return shape.clearance - ramp(time, shape.growth_time) * casing_height(angle, *shape.shape)


def _outline(root: Any, place: Any, tip: Any) -> Any:
    """Edges (n, 2) of a blade whose points at the tip have gone from their angles to others."""
    order = np.argsort(root)
    middle, half = root.mean(), 0.5 * np.ptp(root) if len(root) > 1 else THICKNESS
    edges = []
    for end, side in zip(order[[0, -1]], (-half, half), strict=True):
        bend = SPAN**2 * (3.0 - SPAN) / 2.0 * (place[end] - root[end])  # a beam loaded at its tip
        edges.append(_xy(HUB + (tip[end] - HUB) * SPAN, middle + side + bend))
    return np.vstack([edges[0], _xy(tip, place)[order[1:-1]], edges[1][::-1]])


def _circle(radius: float) -> Any:
    return _xy(radius, AROUND)


def _xy(radius: Any, angle: Any) -> Any:
    return np.stack(np.broadcast_arrays(radius * np.cos(angle), radius * np.sin(angle)), axis=-1)
