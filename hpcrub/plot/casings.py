"""Figure of a casing study."""

import numpy as np
from matplotlib.axes import Axes

from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.style import BLACK, BLUE, ORANGE
from hpcrub.results.storage import ResultFile

EXAGGERATED = 60  # radial deviations in the drawing


@figure("casing", paper="1b, 3", what="casing, clearance and bumps", main=True)
def casing(canvas: Canvas) -> None:
    """The casing to an exaggerated scale, its gap around the circumference, and the bump ramp."""
    file = canvas.file
    round_, gap, growth = canvas.mosaic("AB;AC", (12, 5.6))
    _draw_round(round_, file)
    angle = np.degrees(file.read("angle_rad"))
    gap.plot(angle, 1e3 * file.read("gap_m"), color=BLUE)
    gap.axhline(1e3 * file.config.casing.clearance, color="0.5", lw=1.2, ls="--")
    gap.axhline(0, color=BLACK, lw=1.2)
    gap.fill_between(
        angle, 0, 1e3 * file.read("gap_m"), where=file.read("gap_m") < 0, color=ORANGE, alpha=0.4,
        label="tips at rest would touch",
    )  # fmt: skip
    gap.set(
        xlabel="angle [deg]", ylabel="gap at rest [mm]", xlim=(0, 360), xticks=range(0, 361, 60)
    )
    gap.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), fontsize=10)
    growth.plot(1e3 * file.read("growth_time_s"), file.read("growth"), color=BLUE)
    growth.set(xlabel="time [ms]", ylabel="bump ramp [-]", ylim=(0, 1.05))


def _draw_round(axes: Axes, file: ResultFile) -> None:
    config, angle = file.config, file.read("angle_rad")
    R = config.disk.tip_radius_mm
    inner = R + EXAGGERATED * (config.casing.clearance_mm - 1e3 * file.read("inward_m"))
    tips = 2 * np.pi * np.arange(config.disk.n_blades) / config.disk.n_blades
    c, s = np.cos(angle), np.sin(angle)
    outer = R + EXAGGERATED * config.casing.clearance_mm
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
    axes.set_title(f"{config.casing.words}, radial distances × {EXAGGERATED}")
    axes.legend(loc="center")
