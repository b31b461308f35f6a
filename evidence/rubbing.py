"""`python -m evidence.rubbing FILE.h5`: the disk of a time_response that turns in its casing.

It is written as a GIF beside the result file, FILE_rubbing.gif. A blade is drawn bent as a beam
from its root; all radial distances at the tips have one scale, so that a tip touches the casing
where it rubs, and no blade is drawn shorter than `SHORTEST`. Orange blades are in contact.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
from matplotlib import style
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from hpcrub.contact.status import DIVERGED
from hpcrub.errors import InputError
from hpcrub.model.casing import ramp
from hpcrub.plot.style import BLUE, ORANGE, STYLE, YELLOW, polar
from hpcrub.studies import open_result

REVOLUTIONS = 2  # last revolutions, which are drawn
FRAMES = 72  # pictures in these revolutions, every 10 degrees
FRAMES_PER_SECOND = 25
BENT, GAP = 0.10, 0.07  # largest bending and largest gap at rest as drawn [tip radii]
HUB = 0.42  # radius of the disk as drawn [tip radii]
SHORTEST = 0.6  # smallest radius at which a tip is drawn [tip radii]
SPAN = np.linspace(0.0, 1.0, 9)  # places along a blade, 0 at the hub, 1 at the tip
TURN = 2.0 * np.pi
AROUND = np.linspace(0.0, TURN, 721)
THICKNESS = 0.015  # half the thickness of a blade with one contact point [rad]
TINY = 1e-12  # [m] size that replaces 0 for a disk that does not move
FACE, CASING = "0.82", "0.75"


def draw(path):
    """Draw the GIF of a result file beside it; returns its path. Raises InputError."""
    target = Path(path).with_name(f"{Path(path).stem}_rubbing.gif")
    with open_result(path) as file, style.context(["default", STYLE]):
        if file.config.study != "time_response":
            raise InputError(f"{path}: an animation is for the study time_response")
        film(file).save(target, writer=PillowWriter(FRAMES_PER_SECOND), dpi=80)
    return target


def film(file):
    """FuncAnimation of the last revolutions; of a study with a pattern, the mistuned disk.

    Raises InputError for a motion that diverged.
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
    axes = _axes(file.config, bent, outward)
    casing = axes.add_patch(Polygon(polar(1.0, AROUND).T, closed=True, fc="none", ec=CASING, lw=5))
    hub = polar(HUB, AROUND).T
    bodies = [axes.add_patch(Polygon(hub, lw=0.6)) for _ in range(blade.max() + 1)]
    (sparks,) = axes.plot([], [], "o", color=YELLOW, mec=ORANGE, ms=6)
    axes.add_patch(Polygon(hub, fc=FACE, ec=BLUE, lw=0.6))
    (mark,) = axes.plot([], [], color=BLUE, lw=2)

    def show(frame):
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

    return FuncAnimation(axes.get_figure(), show, FRAMES, interval=40)


def _axes(config, bent, outward):
    """Axes of a new figure as large as the casing, with the scales of bending and gap as title."""
    axes = Figure((5, 5.4), layout="constrained").subplots()
    reach, radius = 1.03 + GAP, config.disk.tip_radius
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    axes.set_axis_off()
    axes.set_title(
        f"{config.casing.words}, {config.speeds.from_hz:g} Hz\n"
        f"bending × {bent * radius:.2g}, gap × {outward * radius:.2g}", fontsize=11,
    )  # fmt: skip
    return axes


def _points(file):
    """Angle [rad] and blade of every contact point, at rest and at time 0."""
    config = file.config
    if config.disk.n_points == config.disk.n_blades:
        blade = np.arange(config.disk.n_blades)
        return 2.0 * np.pi * blade / len(blade), blade
    angle, blade = file.read("contact_angle_rad"), file.read("contact_blade")
    first = angle[[int(np.argmax(blade == number)) for number in blade]]
    return first + np.angle(np.exp(1j * (angle - first))), blade  # no blade across the angle π


def _room(file, time, angle):
    """Distance [m] from the tips to the casing at a time, both without vibration."""
    shape = file.config.casing
    clearance = shape.clearances(file.config.speeds.from_hz)
    return clearance - ramp(time, shape.growth_time) * shape.shape.height(angle)


def _walls(file, times, angles, waves):
    """Distances (F, P) [m] of `_room`, with waves (F, AROUND) of the casing itself."""
    at = zip(times, angles, waves, strict=True)
    return np.array([_room(file, t, a) + np.interp(a, AROUND, w, period=TURN) for t, a, w in at])


def _outline(root, place, tip):
    """Outline (n, 2) of a blade; root, place: angles of its tips at rest and now."""
    order = np.argsort(root)
    middle, half = root.mean(), 0.5 * np.ptp(root) if len(root) > 1 else THICKNESS
    edges = []
    for end, side in zip(order[[0, -1]], (-half, half), strict=True):
        bend = SPAN**2 * (3.0 - SPAN) / 2.0 * (place[end] - root[end])  # a beam loaded at its tip
        edges.append(polar(HUB + (tip[end] - HUB) * SPAN, middle + side + bend))
    return np.hstack([edges[0], polar(tip, place)[:, order[1:-1]], edges[1][:, ::-1]]).T


def main(argv=None):
    """Draw the GIF; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m evidence.rubbing", description=__doc__)
    parser.add_argument("file", metavar="FILE.h5")
    print(draw(parser.parse_args(argv).file))


if __name__ == "__main__":
    sys.exit(main())
