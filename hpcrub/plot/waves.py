"""Figures of a casing that vibrates: its waves and the blades' families, its motion in contact."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke

from hpcrub.effects.casing_motion import PERMANENT
from hpcrub.effects.casing_waves import SHOWN
from hpcrub.model.crossings import MEETINGS
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.responses import SPEED, draw_all
from hpcrub.plot.style import BLACK, BLUE, ORANGE, edges, shades
from hpcrub.results.layout import DONE
from hpcrub.results.storage import ResultFile
from hpcrub.studies.contact import findings


@figure("modal", what="waves of the casing and blades over the speed", needs="waves")
def casing_waves(canvas: Canvas, file: ResultFile) -> None:
    """Frequencies seen from the rotor over the speed, and growth in permanent contact.

    Waves of the casing split into |f_c ± n f|; families of blades, with the nodal diameters that
    they fold to, are level lines or bands. Filled marks are the sums n f = f_c + f_b, where casing
    and blades can excite each other; hollow ones are the differences. To the right of the dotted
    line the rotor overtakes a wave.
    """
    lines, growth = canvas.panels(1, 2, (14.0, 5.8))[0]
    top = SHOWN * file.config.speeds.to_hz
    _draw_lines(lines, file, top)
    speeds, rates = file.read("casing/speed_hz"), file.read("casing/growth_per_s")
    _draw_growth(growth, speeds, rates, file.config.contact.friction)
    growth.set(xlabel=SPEED, xlim=(0.0, top), ylim=(0.0, None))
    growth.set_title("all tips in permanent contact")
    canvas.note("n: waves of the casing, f: speed, $f_c$, $f_b$: frequencies of casing and blades")
    critical = float(file.read("casing/critical_speed_hz").min())
    for panel in (lines, growth):
        panel.axvline(critical, color=BLACK, lw=1.2, ls=":", label="the rotor overtakes a wave")
        studied = file.config.speeds.from_hz, file.config.speeds.to_hz
        panel.axvspan(*studied, color="0.93", zorder=0, label="speeds of the study")


def _draw_lines(axes: Axes, file: ResultFile, top: float) -> None:
    """Draw waves of the casing and families of blades up to a speed [Hz], and their crossings."""
    speed = np.linspace(0.0, top, 300)
    waves, frequency = file.read("casing/waves"), file.read("casing/frequencies_hz")
    blades, met = file.read("casing/blades_hz"), file.read("casing/interaction_hz")
    highest = max(1.25 * float(np.nanmax(blades[:, 0])), 1.1 * frequency.max())
    for family in range(blades.shape[1]):
        of_family = blades[:, family]
        if np.nanmin(of_family, initial=np.inf) < highest:
            ends = np.nanmin(of_family), 1.003 * np.nanmax(of_family)
            shade, label = f"{0.35 + 0.3 * family}", f"blades, family {family + 1}"
            axes.axhspan(*ends, color=shade, label=label)
    for j, colour in enumerate(shades(len(waves))):
        n, f = waves[j], frequency[j]
        axes.plot(speed, np.abs(f - n * speed), color=colour, lw=1.4, label=f"casing, n = {n}")
        axes.plot(speed, f + n * speed, color=colour, lw=1.4, ls=(0, (5, 2)))
        for k, face in enumerate((colour, "w")):
            axes.plot(met[j, :, k], blades[j], "o", mfc=face, mec=colour, ms=8, zorder=4)
    axes.plot([], [], "o", color="0.3", label=f"{MEETINGS[0]}: $n\\,f = f_c + f_b$")
    axes.plot([], [], "o", mfc="w", mec="0.3", label=f"{MEETINGS[1]}: $n\\,f = |f_c - f_b|$")
    axes.set(xlabel=SPEED, ylabel="frequency seen from the rotor [Hz]", xlim=(0.0, top))
    axes.set(ylim=(0.0, highest))
    axes.set_title(r"waves of the casing: $|f_c - n\,f|$ full, $f_c + n\,f$ dashed")


def _draw_growth(axes: Axes, speeds: np.ndarray, rates: np.ndarray, friction: float) -> None:
    """Draw the growth in permanent contact over the speeds, without friction and with it."""
    labels = "without friction", f"with a friction of {friction:g}"
    for rate, label, style in zip(rates, labels, ("--", "-"), strict=True):
        axes.plot(speeds, np.maximum(rate, 0.0), color=ORANGE, ls=style, label=label)
    axes.set_ylabel("growth [1/s]; 0: decays")


@figure("contact", what="motion of a casing that vibrates over the speeds", needs="waves")
def casing_motion(canvas: Canvas, file: ResultFile) -> None:
    """Largest radial motion of the casing beside that of the tips, and its share of the energy.

    The tuned disk, and the range of the random samples or the disk of an explicit pattern; numbers
    at the points of the tuned disk are the waves n that move most. Symbols at zero are speeds
    without a result. The last panel shows where the linear disk and casing grow in permanent
    contact, beside what the motions in time did: how many of the disks ran away, and how fast the
    tuned one and that of a pattern.
    """
    (tips, motion), (share, grows) = canvas.panels(2, 2, (13.0, 9.6))
    draw_all(tips, file)
    draw_all(motion, file, "casing_motion_m")
    _write_waves(motion, file)
    tips.set(ylabel="largest $|u_t|$ of a tip [mm]", title="tips")
    motion.set(ylabel="largest radial motion [mm]", title="casing (numbers: waves n, tuned disk)")
    draw_all(share, file, "casing_energy_share", 100)
    share.set(ylabel="energy of the casing [%]", title="at the end of a run")
    _draw_runaway(grows, file)
    canvas.note(*findings.short(file))


def _write_waves(axes: Axes, file: ResultFile) -> None:
    """Write the waves n that move most beside points of the tuned disk."""
    speeds, waves = file.read("speeds_hz"), file.read("tuned/casing_waves")
    moved = 1e3 * file.read("tuned/casing_motion_m")
    for i in range(0, len(speeds), max(1, len(speeds) // 12)):
        if np.isfinite(moved[i]):
            axes.annotate(
                f"{waves[i]:.0f}", (speeds[i], moved[i]), xytext=(0, 7), ha="center",
                textcoords="offset points", fontsize=10, zorder=5,
                path_effects=[withStroke(linewidth=3, foreground="w")],
            )  # fmt: skip
    axes.margins(y=0.12)  # room for the numbers below the title


def _draw_runaway(axes: Axes, file: ResultFile) -> None:
    """Draw growth in permanent contact, and that of motions that ran away; share of many disks."""
    speeds, away = file.read("speeds_hz"), "casing_growth_per_s"
    _draw_growth(axes, speeds, file.read(PERMANENT.name), file.config.contact.friction)
    look: dict[str, Any] = {"ls": "", "ms": 8}
    label = "{} disk in time, where it runs away"
    alone = file.config.pattern_deviation is not None
    if alone:
        mistuned = file.read(f"samples/{away}", (0, 0))
        axes.plot(speeds, mistuned, marker="+", color=BLUE, label=label.format("mistuned"), **look)
    tuned = file.read(f"tuned/{away}")
    axes.plot(speeds, tuned, marker="x", color=BLACK, label=label.format("tuned"), **look)
    axes.set(xlabel=SPEED, ylim=(0.0, None), title="lines: all tips in permanent contact, linear")
    done = file.status[-1] == DONE
    if alone or not done.any():
        return
    share = 100.0 * np.isfinite(file.read(f"samples/{away}", -1)[done]).mean(axis=0)
    right = axes.twinx()
    grey: dict[str, Any] = {"color": "0.6", "alpha": 0.4, "lw": 0}
    right.bar(speeds, share, 0.8 * np.diff(edges(speeds))[0], **grey)
    right.set(ylabel="disks that run away [%]", ylim=(0.0, 100.0))
    axes.fill_between([], [], label="share of the mistuned disks that run away", **grey)
