"""Draw docs/figures/model.png: disk, casing and bumps of the reference model."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from hpcrub.config.schema import Config
from hpcrub.model.casing import bump_height
from hpcrub.model.disk import build_disk
from hpcrub.plot.style import BLUE, GREEN, ORANGE, STYLE

EXAGGERATED = 40  # radial distances of the casing


def draw(config):
    """The disk, tips at rest, inside the deformed casing; returns the Figure."""
    disk = build_disk(config.disk, config.material).points
    figure, axes = plt.subplots(figsize=(7.6, 5.6), layout="constrained")
    nodes = 1e3 * disk.position
    for blade in disk.blades:
        axes.plot(*nodes[blade].T, color=BLUE, lw=2.5)
    for spoke in disk.spokes:
        axes.plot(*nodes[spoke].T, color=GREEN, lw=2.5)
    around = np.linspace(0, 2 * np.pi, 1441)
    axes.plot(*circle(config.disk.hub_radius_mm, around), color=ORANGE, lw=2.5)
    tips = nodes[disk.blades[:, -1]]
    axes.plot(*tips.T, "o", mfc="w", mec="k", ms=7, zorder=4)
    casing = config.casing
    gap = casing.clearance - bump_height(around, casing.n_bumps, casing.bump_height)
    tip_radius = config.disk.tip_radius_mm
    inner = tip_radius + EXAGGERATED * 1e3 * gap
    outer = np.full_like(around, tip_radius + 70)
    ring = np.hstack([circle(outer, around), circle(inner[::-1], around[::-1])])
    axes.fill(*ring, color="0.85", lw=0)
    axes.plot(*circle(inner, around), color="0.35", lw=1.5)
    parts = nodes[disk.blades[-1]].mean(axis=0), nodes[disk.spokes[-2][-1]]
    label(axes, inner, tips, *parts)
    axes.set_aspect("equal")
    axes.set_axis_off()
    return figure


def label(axes, inner, tips, blade, spoke):
    """Names of the parts, the sense of rotation, and where a tip touches."""
    arrow = {"arrowstyle": "-|>", "color": "k", "lw": 1.2}
    line = {"arrowstyle": "-", "color": "0.4", "lw": 0.9, "relpos": (0, 0.5)}
    bumps = "rigid casing with\n$n_d$ = 4 bumps\n(gap × 40)"
    for text, there, here in (
        (bumps, (400, 370), (640, 430)),
        ("clearance 0.25 mm", tuple(tips[1] + 5), (640, 250)),
        ("a bump reaches 1 mm\ninto the tips' circle", (inner[0], 0), (640, 60)),
        ("blade", tuple(blade), (640, -210)),
        ("ring", (121, -160), (640, -350)),
        ("spoke,\nclamped inside", tuple(spoke), (640, -490)),
    ):
        axes.annotate(text, there, here, arrowprops=line, va="center", fontsize=11)
    turn = {**arrow, "connectionstyle": "arc3,rad=0.13"}
    axes.annotate("", (-467, 392), (-209, 573), arrowprops=turn)
    axes.text(-390, 530, "Ω", ha="center", fontsize=15)
    axes.set_xlim(-590, 1000)


def circle(radius, angle):
    """Points (2, n) around the axis."""
    return np.array([radius * np.cos(angle), radius * np.sin(angle)])


if __name__ == "__main__":
    with plt.rc_context(STYLE):
        draw(Config()).savefig(Path(__file__).with_suffix(".png"), dpi=130)
