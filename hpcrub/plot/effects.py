"""Figures of what effects do: worn coatings, casings that vibrate, blades in air."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from hpcrub.config.text import counted
from hpcrub.effects.casing_motion import PERMANENT, SHOWN
from hpcrub.effects.coating import REACHED, depth_of_all
from hpcrub.errors import InputError
from hpcrub.model.crossings import MEETINGS
from hpcrub.plot import intervals
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.responses import SPEED, draw_all, size
from hpcrub.plot.style import BLACK, BLUE, DOTTED, ORANGE, PINK, edges, marker, polar, shades
from hpcrub.results.layout import DONE
from hpcrub.results.samples import of_levels
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import finite, with_interval
from hpcrub.studies.contact import findings

SIGMA = "standard deviation of the blades' stiffness [%]"
DEPTH = "worn depth [mm]"
INNER, GROOVE = 0.55, 0.4  # radius of the new coating and largest depth in the round drawing


@figure("contact", what="worn depth around the casing and from disk to disk", needs="wear")
def wear(canvas: Canvas, file: ResultFile) -> None:
    """The worn coating: around the casing, over speed and angle, over the speeds, of all disks.

    Around the casing and over the angle it is that of the tuned disk. Of random samples: the range
    of the widest level at every speed, and which share of the disks cuts at most so deep, with
    percentiles and their intervals. Of an explicit pattern: its depths and largest amplitudes.
    """
    around, over, depths, disks = canvas.panels(2, 2, (13.5, 10.6)).flat
    worn, speeds = 1e3 * file.read("tuned/worn_m").max(axis=1), file.read("speeds_hz")
    if not np.isfinite(worn).any():
        raise InputError(f"{file.path} has no worn depth of the tuned disk at any speed")
    _draw_around(around, file, worn)
    thickness = file.config.contact.coating.thickness_mm
    angle = np.append(file.read("angle_deg"), 360.0)
    image = over.pcolormesh(
        angle, edges(speeds), worn, cmap="viridis", vmin=0.0, vmax=np.nanmax(worn) or thickness,
        rasterized=True,
    )  # fmt: skip
    over.set(xlabel="angle of the casing [deg]", ylabel=SPEED, title="tuned disk, all speeds")
    over.set_xticks(range(0, 361, 60))
    over.grid(False)
    canvas.figure.colorbar(image, ax=[over], label=DEPTH)
    draw_all(depths, file, "worn_depth_m")
    if file.config.pattern_deviation is None:
        _draw_disks(disks, file)
    else:
        draw_all(disks, file)
        disks.set(ylabel=size(file), title="largest amplitude at every speed")
    depths.set(ylabel=DEPTH, title="largest depth at every speed")
    bound = 1e3 * depth_of_all(file.config)
    if depths.dataLim.y1 >= REACHED * bound:
        rest = f"worn through: {bound:.3g} mm, the rest of {thickness:g} mm is compacted"
        depths.axhline(bound, color=PINK, lw=1.6, ls=":", label=rest)
    canvas.note(*findings.verdict(file).lines[:2])  # and the weightiest finding


def _draw_around(axes: Axes, file: ResultFile, worn: Any) -> None:
    """Draw the deepest groove around the casing, to a scale of its own, with rings of even depths.

    worn: depths at every speed (S, A) [mm]; among equal depths the largest amplitude decides.
    """
    speeds, motion = file.read("speeds_hz"), np.nan_to_num(file.read("tuned/largest_amplitude_m"))
    shown = int(np.lexsort((motion, np.nan_to_num(worn).max(axis=1)))[-1])
    worn, what = worn[shown], "" if np.nanmax(worn) > 0.0 else ": nothing is worn"
    axes.set_title(f"tuned disk, {speeds[shown]:g} Hz{what}")
    phi = np.radians(np.append(file.read("angle_deg"), 360.0))
    depth, top = np.append(worn, worn[0]), float(np.nanmax(worn)) or 1.0
    groove = polar(INNER + GROOVE * depth / top, phi), polar(INNER, phi[::-1])
    axes.fill(*np.hstack(groove), color=ORANGE, alpha=0.85, lw=0)
    axes.plot(*polar(INNER, phi), color=BLACK, lw=1.2)
    for ring in MaxNLocator(3, min_n_ticks=2).tick_values(0.0, top)[1:]:
        if ring <= 1.05 * top:
            at = INNER + GROOVE * ring / top
            axes.plot(*polar(at, phi), color="0.3", lw=0.8, ls=":", zorder=4)
            axes.annotate(
                f"{ring:g} mm", polar(at, 0.7), fontsize=9, color="0.25", ha="center", va="center",
                bbox={"fc": "w", "ec": "none", "alpha": 0.8, "pad": 0.5}, zorder=5,
            )  # fmt: skip
    for turn in range(4):
        x, y = polar(INNER - 0.12, 0.5 * np.pi * turn)
        axes.text(x, y, f"{90 * turn}°", ha="center", va="center", fontsize=10)
    axes.text(0, 0, "worn\ndepth", ha="center", va="center", fontsize=11)
    axes.set_aspect("equal")
    axes.set_axis_off()


def _draw_disks(axes: Axes, file: ResultFile) -> None:
    """Draw the share of disks over the largest depth they cut, and percentiles, for every level."""
    at, half_range = file.config.convergence.percentiles, 100 * file.read("half_range")
    colours = [BLUE] if len(half_range) == 1 else shades(len(half_range))
    deepest, bound = of_levels(file, "deepest_m"), REACHED * depth_of_all(file.config)
    for values, level, colour in zip(deepest, half_range, colours, strict=True):
        depth = 1e3 * np.sort(values)
        if not len(depth):
            continue
        share = 100 * np.arange(1, len(depth) + 1) / len(depth)
        axes.step(depth, share, where="post", color=colour, label=f"±{level:.3g} %, disks")
        interval = with_interval(depth, at)
        intervals.draw(axes, at, interval, colour, sideways=True)
        for p, value in enumerate(interval[0]):
            axes.plot(value, at[p], marker(p), color=colour, ms=7)
    through = sum(int(np.count_nonzero(values >= bound)) for values in deepest) or "none"
    disks = counted(len(deepest[-1]), "disk") + " per level" * (len(deepest) > 1)
    tuned = 1e3 * float(np.nanmedian(file.read("tuned/run_deepest_m")))
    axes.axvline(tuned, color=BLACK, lw=1.6, ls="--", label="tuned disk, median of its runs")
    axes.set(
        xlabel=f"largest {DEPTH}", ylabel="disks that cut at most so deep [%]", ylim=(0, 102),
        xlim=(0, 1.05 * axes.dataLim.x1 or None),
        title=f"{disks}, worn through by {through} of all {sum(map(len, deepest))}",
    )  # fmt: skip


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
        panel.axvline(critical, label="the rotor overtakes a wave", **DOTTED)
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
    speeds, waves = file.read("speeds_hz"), file.read("tuned/casing_waves")
    moved = 1e3 * file.read("tuned/casing_motion_m")
    for i in range(0, len(speeds), max(1, len(speeds) // 12)):
        if np.isfinite(moved[i]):
            motion.annotate(
                f"{waves[i]:.0f}", (speeds[i], moved[i]), xytext=(0, 7), ha="center",
                textcoords="offset points", fontsize=10, zorder=5,
                path_effects=[withStroke(linewidth=3, foreground="w")],
            )  # fmt: skip
    motion.margins(y=0.12)  # room for the numbers below the title
    tips.set(ylabel="largest $|u_t|$ of a tip [mm]", title="tips")
    motion.set(ylabel="largest radial motion [mm]", title="casing (numbers: waves n, tuned disk)")
    draw_all(share, file, "casing_energy_share", 100)
    share.set(ylabel="energy of the casing [%]", title="at the end of a run")
    _draw_runaway(grows, file)
    canvas.note(*findings.verdict(file).lines[:2])  # and the weightiest finding


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


@figure("linear", "modal", what="damping of waves in air, and of mistuned disks", needs="air")
def air(canvas: Canvas, file: ResultFile) -> None:
    """Damping of the tuned waves, root locus of mistuned disks, least stable mode over the level.

    Nodal diameters above zero travel with the rotation. The cross of the root locus is the centre,
    whose decay no mistuning moves. A modal study has the tuned waves only.
    """
    mistuned = [_draw_locus, _draw_least] if file.config.study == "linear" else []
    panels = canvas.panels(1, 1 + len(mistuned), (7.5 + 4.75 * len(mistuned), 5.2))[0]
    for panel, draw in zip(panels, [_draw_waves, *mistuned], strict=True):
        draw(panel, file)


def _draw_waves(axes: Axes, file: ResultFile) -> None:
    """Draw the damping ratio over the signed nodal diameter: given, and of the complex modes."""
    diameters = file.read("aero/diameters")
    order = np.argsort(diameters)
    given, tuned = (100 * file.read(f"aero/{n}_damping_ratio")[order] for n in ("given", "tuned"))
    axes.plot(diameters[order], given, color=ORANGE, label="given")
    axes.plot(diameters[order], tuned, "o", color=BLACK, ms=5, label="of the tuned disk's modes")
    axes.axhline(given.mean(), color="0.4", lw=1.2, ls=":", label="mean of all waves")
    axes.set(ylabel="damping ratio [%]", title="tuned disk")
    axes.set_xlabel("nodal diameters, > 0: with the rotation")
    _zero(axes)


def _draw_locus(axes: Axes, file: ResultFile) -> None:
    """Draw decay over frequency of the tuned waves and of the complex modes of mistuned disks."""
    frequency, decay = file.read("aero/frequency_hz"), file.read("aero/decay_per_s")
    sigma = 100 * file.read("sigma")
    for level, colour in enumerate(shades(len(sigma))):
        axes.plot(
            frequency[level].ravel(), decay[level].ravel(), ".", ms=2.5, color=colour, alpha=0.5,
            rasterized=True, zorder=1,
        )  # fmt: skip
        axes.plot([], [], "o", ms=5, color=colour, label=f"mistuned, σ = {sigma[level]:.2g} %")
    tuned = file.read("aero/tuned_frequency_hz"), file.read("aero/tuned_decay_per_s")
    closed = [np.append(values, values[0]) for values in tuned]
    axes.plot(*closed, "o-", color=BLACK, ms=5, lw=1.0, label="tuned waves")
    centre = [values.mean() for values in tuned]
    axes.plot(*centre, "P", color=ORANGE, mec="w", ms=13, label="centre", zorder=4)
    axes.set(xlabel="frequency [Hz]", ylabel="decay [1/s]", title="root locus")
    _zero(axes)


def _draw_least(axes: Axes, file: ResultFile) -> None:
    """Draw percentiles of the damping ratio of the least stable mode over the mistuning level."""
    levels = [100 * finite(ratios) for ratios in file.read("aero/least_damping_ratio")]
    tuned = 100 * file.read("aero/tuned_damping_ratio")
    known = [level for level, ratios in enumerate(levels) if len(ratios)]
    if not known:
        return
    sigma = np.append(0.0, 100 * file.read("sigma")[known])
    band = np.array([np.percentile(levels[level], [1, 50, 99]) for level in known]).T
    low, middle, high = np.column_stack([np.full(3, tuned.min()), band])
    axes.fill_between(sigma, low, high, color=BLUE, alpha=0.25, lw=0, label="percentiles 1 to 99")
    axes.plot(sigma, middle, "o-", color=BLUE, ms=4, label="median")
    axes.axhline(tuned.mean(), color="0.4", lw=1.2, ls=":", label="mean of all waves")
    axes.set(xlabel=SIGMA, ylabel="damping ratio [%]", title="least stable mode of a disk")
    _zero(axes)


def _zero(axes: Axes) -> None:
    """Let the axis include zero, below which motions grow by themselves (flutter)."""
    low, high = axes.get_ylim()
    if low < 0.0:
        axes.axhspan(low, 0.0, color="0.9", zorder=0, label="flutter")
    axes.set_ylim(low if low < 0.0 else 0.0, high)
