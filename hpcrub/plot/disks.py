"""Figures of a modal study (disk, modes, Campbell diagram), and of the casing of any input."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from hpcrub.config.casing import Casing
from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.model import crossings
from hpcrub.model.casing import ramp
from hpcrub.model.imported import cyclic
from hpcrub.model.reduction import ReducedModel
from hpcrub.plot import solids
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.responses import SPEED
from hpcrub.plot.style import BLACK, BLUE, GREEN, ORANGE, polar
from hpcrub.results.storage import ResultFile
from hpcrub.setup.problem import build_model
from hpcrub.studies import STUDIES

SHOWN = 3  # families
BEYOND = 1.3  # highest speed of the diagram, in parts of the highest speed of the study
N_SPEEDS = 60
MOST_ORDERS = 12  # engine orders whose lines are drawn beside that of the casing
SHOWN_HZ = 2000.0  # [Hz] up to which the SAFE diagram reaches, at least
FAMILIES = 4.0  # and at least to this multiple of the first family's frequency
PARTS = {"blades": BLUE, "ring": ORANGE, "spokes": GREEN}
PINCH = 1e-4  # relative difference below which two frequencies belong to one pair of modes
EXAGGERATED = 60  # factor of the radial deviations in the drawing
N_ANGLES, N_TIMES = 2401, 201


def _lines(file: ResultFile, moved: Any = 0.0) -> Iterator[tuple[str, Any]]:
    """Yield poly-lines (kind, (n, 2) [mm]) of all beams, displaced by `moved` (nodes, 2) [m]."""
    nodes = file.read("position_m")
    straight, now = 1e3 * nodes, 1e3 * (nodes + moved)
    for blade in file.read("blades"):
        yield "blades", now[blade]
    for spoke in file.read("spokes"):
        yield "spokes", now[spoke]
    for pair in file.read("ring"):
        start, end = np.arctan2(straight[pair, 1], straight[pair, 0])
        part = np.linspace(0, 1, 9)[:, None]
        arc = start + np.mod(end - start, 2 * np.pi) * part
        arc = np.hypot(*straight[pair[0]]) * np.hstack([np.cos(arc), np.sin(arc)])
        first, last = (now - straight)[pair]
        yield "ring", arc + (1 - part) * first + part * last


def _draw_disk(
    axes: Axes, file: ResultFile, moved: Any = 0.0, colour: str | None = None, width: float = 2.0
) -> None:
    axes.set_aspect("equal")
    axes.grid(False)
    kinds, lines = zip(*_lines(file, moved), strict=True)
    colours = colour or [PARTS[kind] for kind in kinds]
    axes.add_collection(LineCollection(lines, colors=colours, lw=width, capstyle="round"))


@figure("modal", paper="1", what="the disk and its beams", main=True)
def disk(canvas: Canvas, file: ResultFile) -> None:
    """The beams of the disk inside the casing.

    With the numbers of the blades and the sense of rotation. A model file is shown by its surface
    in three dimensions, with the contact nodes.
    """
    if file.config.disk.model is not None:
        axes = canvas.panels(1, 1, (8, 5.5), subplot_kw=solids.THREE)[0, 0]
        solid = solids.Solid.of_result(file)
        solids.draw(axes, solid)
        canvas.figure.suptitle(solid.words(Path(file.config.disk.model)))
        return
    axes = canvas.panels(1, 1, (7.5, 8.2))[0, 0]
    _draw_disk(axes, file, width=2.5)
    nodes = 1e3 * file.read("position_m")
    axes.plot(*nodes.T, "o", color=BLACK, ms=3.5, zorder=3)
    tips = nodes[file.read("blades")[:, -1]]
    axes.plot(*tips.T, "o", mfc="w", mec=BLACK, ms=8, zorder=4)
    R = file.config.disk.tip_radius_mm
    wall = polar(1.03 * R, np.linspace(0, 2 * np.pi, 721))  # the gap is a quarter of a millimetre
    axes.plot(*wall, color="0.5", lw=3)
    for number, tip in enumerate(1.1 * tips, 1):
        axes.text(*tip, f"{number}", ha="center", va="center", fontsize="large")
    turning = {"arrowstyle": "-|>", "connectionstyle": "arc3,rad=0.15", "color": BLACK}
    start, end = polar(1.17 * R, np.radians([35, 57])).T
    axes.annotate("Ω", end, start, arrowprops=turning, fontsize="large")
    for name, colour in (
        ("blades", BLUE), ("ring", ORANGE), ("spokes, clamped inside", GREEN),
        ("casing (gap exaggerated)", "0.5"),
    ):  # fmt: skip
        axes.plot([], [], color=colour, label=name)
    axes.plot([], [], "o", mfc="w", mec=BLACK, label="contact points, boundary dof")
    room = -1.25 * R, 1.25 * R
    axes.set(xlabel="x [mm]", ylabel="y [mm]", xlim=room, ylim=room)


@figure("modal", paper="2", what="SAFE diagram, full and reduced model")
def safe_diagram(canvas: Canvas, file: ResultFile) -> None:
    """Frequencies against nodal diameters: all families, and the first one closer.

    Black lines are what a casing at rest excites at one speed. The frequency at which it excites
    in contact lies above the first family: rubbing blades are stiffer than free ones, so that
    interactions occur at higher speeds than the crossing of the lines.
    """
    config = file.config
    axes = canvas.panels(1, 2, (12.5, 5.8))[0]
    full = len(file.read("full/frequencies_hz")) > 0  # a reduced model file has no full model
    diameters, frequencies = _modes(file, "full" if full else "reduced")
    n_blades, n_d = config.disk.n_blades, config.casing.main_order
    most = n_blades // 2
    first = frequencies[:n_blades]
    both = np.concatenate([first, _modes(file, "reduced")[1][:n_blades]])
    margin = 0.35 * np.ptp(both) or 0.01 * both.min()  # of one blade, reduced elsewhere
    shown = max(SHOWN_HZ, FAMILIES * first.max())
    limits = [(0, shown), (both.min() - margin, both.max() + margin)]
    for panel, (bottom, top) in zip(axes, limits, strict=True):
        for family in families(diameters, frequencies):
            panel.plot(range(len(family)), family, color=BLUE, lw=1, alpha=0.6)
        if full:
            panel.plot(diameters, frequencies, ".", color=BLUE, ms=9, label="full model")
        panel.plot(
            *_modes(file, "reduced"), "o", mfc="none", mec=ORANGE, ms=11,
            label=f"reduced model, {config.reduction.n_modes} modes",
        )  # fmt: skip
        panel.set(ylim=(bottom, top), xticks=range(most + 1), xlim=(-0.4, most + 0.4))
        panel.set(xlabel="nodal diameters [-]", ylabel="frequency [Hz]")
    critical = 0.5 * (config.speeds.from_hz + config.speeds.to_hz)
    order = np.linspace(0, most, 200)
    black: dict[str, Any] = {"color": BLACK, "lw": 1.5}
    axes[0].plot(order, critical * order, label=f"excitation at {critical:.4g} Hz", **black)
    axes[0].plot(order, critical * (n_blades - order), **black)
    excited = crossings.folded(n_d, n_blades)
    family = first[diameters[:n_blades] == excited].mean()
    above = n_d * critical > first.max()
    why = f",\nabove the family's {family:.4g} Hz:\ncontact stiffens the blades" if above else ""
    what = f"order {n_d}" if config.casing.profile.exists else config.casing.words
    axes[0].annotate(
        f"{what}: {n_d * critical:.4g} Hz{why}", (excited, n_d * critical),
        xytext=(0.6 * most, 0.4 * shown), ha="center", va="center", fontsize=11,
        arrowprops={"arrowstyle": "->"}, bbox={"fc": "w", "ec": "none", "alpha": 0.8},
    )  # fmt: skip
    met = float(file.read("crossing_hz"))
    if np.isfinite(met):
        way = 1 if n_d % n_blades == excited else -1
        label = f"order {n_d} at {met:.4g} Hz, where it meets the family"
        axes[1].plot(order, met * (n_d + way * (order - excited)), "--", label=label, **black)
    axes[0].set_title("SAFE diagram")
    never = "" if np.isfinite(met) else f"; order {n_d} never meets it"
    axes[1].set_title(f"first family, without contact{never}")


def _modes(file: ResultFile, kind: str) -> tuple[Any, Any]:
    diameters = file.read(f"{kind}/nodal_diameters")
    if not np.isin(diameters, range(file.config.disk.n_blades // 2 + 1)).all():
        raise InputError(f"{file.path} is damaged ({kind}/nodal_diameters)")
    return diameters, file.read(f"{kind}/frequencies_hz")


def families(diameters: Any, frequencies: Any) -> list[Any]:
    """Return frequencies of each family over the nodal diameters 0, 1, ..., lowest family first.

    The first family has the lowest frequency of each nodal diameter, the second family the next,
    and so on; the two modes of a pair count once. Incomplete families are left out.
    """
    columns = []
    for d in range(int(diameters.max()) + 1):
        mine = np.sort(frequencies[diameters == d])
        columns.append(mine[np.diff(mine, prepend=-np.inf) > PINCH * mine])
    return [np.array(family) for family in zip(*columns, strict=False)]


@figure("modal", what="deformed shapes of the first family", mode=True)
def mode_shapes(canvas: Canvas, file: ResultFile, mode: int | None = None) -> None:
    """Deformed shapes: one mode of every nodal diameter of the first family, or one chosen."""
    diameters, frequencies = _modes(file, "reduced")
    n_blades = file.config.disk.n_blades
    first = [int(np.argmax(diameters[:n_blades] == d)) for d in range(n_blades // 2 + 1)]
    n_shapes = file.shape("shapes")[0]
    chosen = [k for k in first if k < n_shapes] if mode is None else [mode - 1]
    if mode is not None and not 1 <= mode <= n_shapes:
        raise InputError(f"--mode: {mode} is not a whole number from 1 up to {n_shapes}")
    size = 3.2 if mode is None else 6.5
    is_solid = file.config.disk.model is not None
    how: dict[str, Any] = {"subplot_kw": solids.THREE} if is_solid else {}
    height = 0.8 * size if is_solid else size + 0.3
    axes = canvas.grid(len(chosen), 4, (size, height), **how)
    for panel, k in zip(axes, chosen, strict=True):
        shape = file.read("shapes", k)
        panel.set_axis_off()
        if is_solid:
            solids.draw(panel, solids.Solid.of_result(file), shape)
        else:
            _draw_disk(panel, file, colour="0.8", width=1.0)
            _draw_disk(panel, file, solids.DEFORMED * file.config.disk.tip_radius * shape)
            reach = 1.2e3 * file.config.disk.tip_radius
            panel.set(xlim=(-reach, reach), ylim=(-reach, reach))
        panel.set_title(
            f"{diameters[k]} nodal diameters\nmode {k + 1}: {frequencies[k]:.2f} Hz", fontsize=11
        )
    left_out = [str(d) for d, k in enumerate(first) if k >= n_shapes and mode is None]
    if left_out:
        canvas.note(f"The file holds no shapes of {', '.join(left_out)} nodal diameters.")
    if is_solid:
        size_of = "displacement, relative to the largest [-]"
        canvas.figure.colorbar(axes[0].collections[0], ax=axes, label=size_of, shrink=0.6)
        if not len(file.read("surface")):
            canvas.note(solids.REDUCED)


@figure(*STUDIES, paper="1b, 3", what="casing, clearance and bumps", alone=False,
        computed=False)  # fmt: skip
def casing(canvas: Canvas, file: ResultFile) -> None:
    """The casing to an exaggerated scale, its gap around the circumference, and how it grows.

    Where the clearance changes with the speed, it is drawn where it is smallest, dotted where it is
    largest. Of the input alone: instead of a result file it takes a `hpcrub.Config`, too.
    """
    config, shape = file.config, file.config.casing
    round_, gaps, growth = canvas.panels(1, 3, (15, 4.8), width_ratios=(6, 6, 4))[0]
    angle = np.linspace(0, 2 * np.pi, N_ANGLES)
    inward = 1e3 * shape.shape.height(angle)
    _draw_round(round_, config, angle, inward)
    least, most = 1e3 * config.clearance, 1e3 * shape.clearances(config.speeds.values_hz).max()
    gap, degrees = least - inward, np.degrees(angle)
    gaps.plot(degrees, gap, color=BLUE)
    if shape.profile.measured:
        _draw_measured(gaps, shape, least)
    gaps.axhline(least, color="0.5", lw=1.2, ls="--", label="undeformed casing")
    if most > least:
        words = "at the speed of the largest clearance"
        gaps.plot(degrees, most - inward, color=BLUE, lw=1.2, ls=":", label=words)
    gaps.axhline(0, color=BLACK, lw=1.2)
    look: dict[str, Any] = {"color": ORANGE, "alpha": 0.4, "label": "tips at rest would touch"}
    gaps.fill_between(degrees, 0, gap, where=gap < 0, **look)
    gaps.set(xlabel="angle of the casing [deg]", ylabel="gap at rest [mm]", xlim=(0, 360))
    gaps.set(xticks=range(0, 361, 60), title=config.casing.words)
    time = np.linspace(0, 1.2 * shape.growth_time, N_TIMES)
    growth.plot(1e3 * time, [ramp(t, shape.growth_time) for t in time], color=BLUE)
    growth.set(xlabel="time [ms]", ylabel="part of its shape [-]", ylim=(0, 1.05))
    growth.set_title("growth of the casing")


def _draw_measured(axes: Axes, shape: Casing, clearance: float) -> None:
    profile = shape.profile
    angle = np.array([phi for phi, _ in profile.measured])
    lines = shape.shape._replace(profile=profile._replace(cut_off=0.0))
    gap = clearance - 1e3 * lines.height(angle)
    over = f"smoothed over {1e3 * shape.smoothing:.3g} mm" if profile.cut_off else "no smoothing"
    words = f"measured points, {over}"
    axes.plot(np.degrees(angle), gap, ".", color=ORANGE, ms=4, zorder=1, label=words)


def _draw_round(axes: Axes, config: Config, angle: np.ndarray, inward: np.ndarray) -> None:
    R, clearance = config.disk.tip_radius_mm, 1e3 * config.clearance
    inner, outer = R + EXAGGERATED * (clearance - inward), R + EXAGGERATED * clearance
    tips = 2 * np.pi * np.arange(config.disk.n_blades) / config.disk.n_blades
    wall = polar(inner, angle)
    axes.fill(*np.hstack([wall, polar(1.15 * R, angle[::-1])]), color="0.85", lw=0)
    axes.plot(*wall, color=ORANGE, label="deformed casing")
    wall = polar(outer, angle)
    axes.plot(*wall, color="0.5", lw=1.2, ls="--", label="undeformed casing")
    axes.plot(*polar(R, angle), color=BLUE, lw=1.2, label="circle of the tips")
    axes.plot(*polar(R, tips), "o", color=BLUE, ms=7, label="tips")
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title(f"radial distances × {EXAGGERATED}")


@figure("modal", what="Campbell diagram", alone=False, computed=False)
def campbell(canvas: Canvas, file: ResultFile) -> None:
    """Frequencies of the tuned disk over the speed of rotation, in Hz and in rpm.

    Bands are families of blade modes, from their lowest to their highest nodal diameter; the line
    is the nodal diameter that the casing's order excites, and the mark where they meet. Of the
    input alone: instead of a result file it takes a `hpcrub.Config`, too.
    """
    axes, config = canvas.panels(1, 1, (9.0, 6.2))[0, 0], file.config
    reduced, order = build_model(config).reduced, config.casing.main_order
    speeds = np.linspace(0.0, BEYOND * config.speeds.to_hz, N_SPEEDS)
    diameters = cyclic.tuned_diameters(reduced)
    highest = 1.15 * _draw_families(axes, reduced, diameters, order, speeds)
    _draw_orders(axes, order, speeds[-1], highest)
    if np.isfinite(met := crossings.of_disk(reduced, diameters, order)) and met < speeds[-1]:
        label = f"order {order} meets family 1 at {met:.4g} Hz, {60.0 * met:,.0f} rpm"
        axes.plot(met, order * met, "o", color=ORANGE, ms=8, label=label, zorder=4)
    studied = config.speeds.from_hz, config.speeds.to_hz
    axes.axvspan(*studied, color="0.93", zorder=0, label="speeds of the study")
    axes.set(xlabel=SPEED, ylabel="frequency [Hz]", xlim=(0.0, speeds[-1]), ylim=(0.0, highest))
    rpm = axes.secondary_xaxis("top", functions=(lambda hz: 60.0 * hz, lambda rpm: rpm / 60.0))
    rpm.set_xlabel("speed of rotation [rpm]")


def _draw_families(
    axes: Axes, reduced: ReducedModel, diameters: np.ndarray, order: int, speeds: np.ndarray
) -> float:
    """Draw families of modes with nodal diameters (m,) over speeds [Hz]; returns the highest.

    Families far above what the order reaches are left out.
    """
    mine, highest = crossings.folded(order, reduced.interface.n_blades), 0.0
    for family in range(SHOWN):
        curves = {}
        for diameter in sorted(set(diameters)):
            of_speed = crossings.family_frequency(reduced, diameters, int(diameter), family)
            if of_speed is not None:
                rates = [of_speed(2.0 * np.pi * speed) for speed in speeds]
                curves[diameter] = np.array(rates) / (2.0 * np.pi)
        known = np.array(list(curves.values()))
        if not known.size or (family and known.min() > BEYOND * order * speeds[-1]):
            break
        shade, label = f"{0.6 + 0.12 * family}", f"family {family + 1}, all nodal diameters"
        axes.fill_between(speeds, known.min(axis=0), known.max(axis=0), color=shade, label=label)
        if mine in curves:
            axes.plot(speeds, curves[mine], color=BLUE, lw=1.4, label=f"{mine} nodal diameters")
        highest = max(highest, float(known.max()))
    return highest


def _draw_orders(axes: Axes, main: int, fastest: float, highest: float) -> None:
    """Draw the lines of engine orders up to a speed and a frequency [Hz], with their numbers."""
    for order in {*range(1, MOST_ORDERS + 1), main}:
        is_main = order == main
        axes.plot(
            [0.0, fastest], [0.0, order * fastest], color=ORANGE if is_main else BLACK,
            lw=1.6 if is_main else 0.5, label=f"order {order} of the casing" if is_main else None,
        )  # fmt: skip
        speed = min(fastest, highest / order)
        axes.annotate(
            f"{order}", (speed, order * speed), xytext=(-4, -4), textcoords="offset points",
            ha="right", va="top", fontsize=9, color=ORANGE if is_main else "0.3",
        )  # fmt: skip
