"""Figures of a modal study: the disk, its SAFE diagram, its shapes."""

import io

import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

from hpcrub.errors import InputError
from hpcrub.plot.style import BLACK, BLUE, GREEN, ORANGE, PINK

SHOWN_HZ = 2000.0  # of the whole SAFE diagram
DEFORMED = 0.14  # largest displacement drawn, in radii
FRAMES = 30  # of one period


def _lines(file, moved=0.0):
    """Poly-lines (kind, (n, 2) [mm]) of all beams, displaced by `moved` (nodes, 2) [m]."""
    nodes = file.read("position_m")
    straight, now = 1e3 * nodes, 1e3 * (nodes + moved)
    for blade in file.read("blades"):
        yield "blades", now[blade]
    for spoke in file.read("spokes"):
        yield "spokes", now[spoke]
    for pair in file.read("ring"):
        angle, radius = _polar(straight[pair])
        part = np.linspace(0, 1, 9)[:, None]
        arc = angle[0] + np.mod(angle[1] - angle[0], 2 * np.pi) * part
        arc = radius[0] * np.hstack([np.cos(arc), np.sin(arc)])
        yield (
            "ring",
            arc + (1 - part) * (now - straight)[pair[0]] + part * (now - straight)[pair[1]],
        )


def _polar(xy):
    return np.arctan2(xy[:, 1], xy[:, 0]), np.hypot(xy[:, 0], xy[:, 1])


def _draw_disk(axes, file, moved=0.0, colour=None, width=2.0):
    colours = {"blades": BLUE, "ring": ORANGE, "spokes": GREEN}
    for kind, xy in _lines(file, moved):
        axes.plot(*xy.T, color=colour or colours[kind], lw=width, solid_capstyle="round")
    axes.set_aspect("equal")
    axes.grid(False)


def disk(files):
    """The beams of the disk inside the casing."""
    (file,) = files
    config = file.config
    figure, axes = plt.subplots(figsize=(7, 7.4))
    _draw_disk(axes, file, width=2.5)
    nodes = 1e3 * file.read("position_m")
    axes.plot(*nodes.T, "o", color=BLACK, ms=3.5, zorder=3)
    tips = nodes[file.read("blades")[:, -1]]
    axes.plot(*tips.T, "o", mfc="w", mec=BLACK, ms=8, zorder=4)
    around = np.linspace(0, 2 * np.pi, 721)
    radius = config.disk.tip_radius_mm + 15  # not to scale: the gap is a quarter of a millimetre
    axes.plot(radius * np.cos(around), radius * np.sin(around), color="0.5", lw=3)
    for name, colour, marker in (
        ("blades", BLUE, ""), ("ring", ORANGE, ""), ("spokes, clamped inside", GREEN, ""),
        ("casing (gap exaggerated)", "0.5", ""),
    ):  # fmt: skip
        axes.plot([], [], color=colour, marker=marker, label=name)
    axes.plot([], [], "o", mfc="w", mec=BLACK, label="contact points")
    axes.legend(ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.08))
    axes.set(xlabel="x [mm]", ylabel="y [mm]")
    return figure


def safe(files):
    """Frequencies against nodal diameters: all families, and the first one closer."""
    (file,) = files
    config = file.config
    figure, axes = plt.subplots(1, 2, figsize=(12, 5.6))
    data = {
        kind: (file.read(f"{kind}/nodal_diameters"), file.read(f"{kind}/frequencies_hz"))
        for kind in ("full", "reduced")
    }
    first = data["full"][1][: config.disk.n_blades]
    low, high = first.min(), first.max()
    margin = 0.35 * (high - low)
    limits = [(0, SHOWN_HZ), (low - margin, high + margin)]
    critical = 0.5 * (config.speeds.from_hz + config.speeds.to_hz)
    n_blades, n_d = config.disk.n_blades, config.casing.n_bumps
    most = n_blades // 2
    order = np.linspace(0, most, 200)
    for panel, (bottom, top) in zip(axes, limits, strict=True):
        panel.plot(*data["full"], ".", color=BLUE, ms=9, label="full model")
        panel.plot(
            *data["reduced"], "o", mfc="none", mec=ORANGE, ms=11,
            label=f"reduced model, η = {config.reduction.n_modes}",
        )  # fmt: skip
        panel.set(ylim=(bottom, top), xticks=range(most + 1), xlim=(-0.4, most + 0.4))
        panel.set(xlabel="nodal diameters [-]", ylabel="frequency [Hz]")
    black = {"color": BLACK, "lw": 1.5}
    axes[0].plot(order, critical * order, label=f"excitation at {critical:.4g} Hz", **black)
    axes[0].plot(order, critical * (n_blades - order), **black)
    excited = min(n_d % n_blades, -n_d % n_blades)
    axes[0].annotate(
        f"{n_d} bumps: {n_d * critical:.4g} Hz", (excited, n_d * critical),
        xytext=(-35, 100), textcoords="offset points", ha="center", fontsize=11,
        arrowprops={"arrowstyle": "->"},
    )  # fmt: skip
    for n, style in ((3, ":"), (4, "--"), (5, "-.")):
        meets = first[data["full"][0][: len(first)] == n].mean()
        axes[1].plot(
            order, meets / n * order, style, color=PINK, lw=1.5,
            label=f"excitation at {meets / n:.2f} Hz: meets $n_d$ = {n}",
        )  # fmt: skip
    axes[0].set_title("SAFE diagram")
    axes[1].set_title("first bending family")
    for panel in axes:
        panel.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), fontsize=11)
    return figure


def shapes(files, mode=None):
    """Deformed shapes: one mode of every nodal diameter of the first family, or one chosen."""
    (file,) = files
    diameters, frequencies = (
        file.read(f"reduced/{name}") for name in ("nodal_diameters", "frequencies_hz")
    )
    n_blades = file.config.disk.n_blades
    first = [int(np.argmax(diameters[:n_blades] == d)) for d in range(n_blades // 2 + 1)]
    chosen = first if mode is None else [_checked(file, mode)]
    columns = min(len(chosen), 4)
    rows = -(-len(chosen) // columns)
    size = 3.2 if mode is None else 6.5
    figure, axes = plt.subplots(
        rows, columns, figsize=(size * columns, (size + 0.3) * rows), squeeze=False
    )
    for panel in axes.flat[len(chosen) :]:
        panel.set_axis_off()
    for panel, k in zip(axes.flat, chosen, strict=False):
        _draw_shape(panel, file, k, 1.0)
        panel.set_title(f"mode {k + 1}: {frequencies[k]:.2f} Hz,\nnodal diameters: {diameters[k]}")
    return figure


def _checked(file, mode):
    n_shapes = len(file.read("shapes"))
    if not 1 <= mode <= n_shapes:
        raise InputError(f"--mode: {mode} is not a whole number from 1 up to {n_shapes}")
    return mode - 1


def _draw_shape(axes, file, k, phase):
    moved = phase * DEFORMED * file.config.disk.tip_radius * file.read("shapes", k)
    _draw_disk(axes, file, colour="0.8", width=1.0)
    _draw_disk(axes, file, moved)
    reach = 1.2e3 * file.config.disk.tip_radius
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach))
    axes.set_axis_off()


def animation(files, mode=1):
    """One mode through a period, as a list of pictures."""
    (file,) = files
    k = _checked(file, mode)
    pictures = []
    for frame in range(FRAMES):
        figure, axes = plt.subplots(figsize=(5, 5.2))
        _draw_shape(axes, file, k, np.sin(2 * np.pi * frame / FRAMES))
        axes.set_title(f"mode {mode}: {file.read('reduced/frequencies_hz')[k]:.2f} Hz")
        buffer = io.BytesIO()
        figure.savefig(buffer, dpi=80)
        plt.close(figure)
        pictures.append(Image.open(buffer).convert("P", palette=Image.Palette.ADAPTIVE))
    return pictures
