"""The casing of an input: its radius around the circumference, and how its bumps grow."""

import numpy as np
from matplotlib.axes import Axes

from hpcrub.config.schema import Config
from hpcrub.model.casing import casing_height, ramp
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.style import BLACK, BLUE, ORANGE
from hpcrub.studies import STUDIES

EXAGGERATED = 60  # radial deviations in the drawing
N_ANGLES, N_TIMES = 2401, 201


@figure(*STUDIES, paper="1b, 3", what="casing, clearance and bumps", alone=False)
def casing(canvas: Canvas) -> None:
    """The casing to an exaggerated scale, its gap around the circumference, and how it grows.

    Where the clearance changes with the speed, it is drawn where it is smallest, dotted where it is
    largest. Of the input alone: instead of a result file it takes a `hpcrub.Config`, too.
    """
    config = canvas.file.config
    shape = config.casing
    round_, gaps, growth = canvas.panels(1, 3, (15, 4.8), width_ratios=(6, 6, 4))[0]
    angle = np.linspace(0, 2 * np.pi, N_ANGLES)
    inward = 1e3 * casing_height(angle, *shape.shape)
    _draw_round(round_, config, angle, inward)
    least, most = 1e3 * config.clearance, 1e3 * shape.clearances(config.speeds.values_hz).max()
    gap = least - inward
    gaps.plot(np.degrees(angle), gap, color=BLUE)
    gaps.axhline(least, color="0.5", lw=1.2, ls="--", label="undeformed casing")
    if most > least:
        gaps.plot(
            np.degrees(angle), most - inward, color=BLUE, lw=1.2, ls=":",
            label="at the speed of the largest clearance",
        )  # fmt: skip
    gaps.axhline(0, color=BLACK, lw=1.2)
    gaps.fill_between(
        np.degrees(angle), 0, gap, where=gap < 0, color=ORANGE, alpha=0.4,
        label="tips at rest would touch",
    )  # fmt: skip
    gaps.set(xlabel="angle of the casing [deg]", ylabel="gap at rest [mm]", xlim=(0, 360))
    gaps.set(xticks=range(0, 361, 60), title=config.casing.words)
    time = np.linspace(0, 1.2 * shape.growth_time, N_TIMES)
    growth.plot(1e3 * time, [ramp(t, shape.growth_time) for t in time], color=BLUE)
    growth.set(
        xlabel="time [ms]",
        ylabel="part of its shape [-]",
        title="growth of the casing",
        ylim=(0, 1.05),
    )


def _draw_round(axes: Axes, config: Config, angle: np.ndarray, inward: np.ndarray) -> None:
    R, clearance = config.disk.tip_radius_mm, 1e3 * config.clearance
    inner, outer = R + EXAGGERATED * (clearance - inward), R + EXAGGERATED * clearance
    tips = 2 * np.pi * np.arange(config.disk.n_blades) / config.disk.n_blades
    c, s = np.cos(angle), np.sin(angle)
    axes.fill(
        np.concatenate([inner * c, 1.15 * R * c[::-1]]),
        np.concatenate([inner * s, 1.15 * R * s[::-1]]), color="0.85", lw=0,
    )  # fmt: skip
    axes.plot(inner * c, inner * s, color=ORANGE, label="deformed casing")
    axes.plot(outer * c, outer * s, color="0.5", lw=1.2, ls="--", label="undeformed casing")
    axes.plot(R * c, R * s, color=BLUE, lw=1.2, label="circle of the tips")
    axes.plot(R * np.cos(tips), R * np.sin(tips), "o", color=BLUE, ms=7, label="tips")
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title(f"radial distances × {EXAGGERATED}")
