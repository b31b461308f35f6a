"""Figures of whole motions: time_response, interaction_map, branches (motions that coexist)."""

from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, LogNorm, Normalize
from matplotlib.patches import Rectangle

from hpcrub.contact import status
from hpcrub.contact.status import AVERAGED, DIVERGED, NOT_STEADY
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.style import BLUE, GREEN, MARKERS, ORANGE, PINK, YELLOW, edges, say, shades
from hpcrub.results.storage import ResultFile
from hpcrub.setup.casing import casing_modes_of
from hpcrub.statistics import coexistence
from hpcrub.statistics.coexistence import coexisting, stretches
from hpcrub.statistics.percentiles import Z_95
from hpcrub.studies.branches import label_file, starts
from hpcrub.studies.time_response import first_known

DECADES = 3.5  # decades of amplitude that are drawn, below the largest one
N_INTERACTIONS = 2  # number of interactions that are marked, on different engine orders
AREA = 0.5  # part of an order's largest amplitude, above which speeds belong to the interaction
ABOVE_AREA = 6.0  # half height of the box of an interaction [Hz]
NAMED = 4  # engine orders up to this one are all named, besides the multiples of the bumps
CLOSER = 0.5  # part of the speeds, above which a closer look would show the whole again
SHADES = LinearSegmentedColormap.from_list("localisation", shades(256))
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
    canvas.figure.suptitle(f"{DISKS[disk]}, {config.casing.words}, {config.speeds.from_hz:g} Hz")


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


class Interaction(NamedTuple):
    """An area of large amplitudes on an engine order."""

    order: int
    speed_hz: float  # speed of the largest amplitude
    first_hz: float  # lowest and highest speed of the area
    last_hz: float
    amplitude: float  # in the unit of the spectra

    @property
    def frequency_hz(self) -> float:
        """Frequency of the motion at the largest amplitude, that is of the nonlinear mode."""
        return self.order * self.speed_hz


@figure("interaction_map", paper="6", what="spectra over the speeds", main=True)
def interaction_map(canvas: Canvas, file: ResultFile) -> None:
    """Spectra over the speeds with engine orders and natural frequencies, a panel for every disk.

    The two strongest interactions are framed. Their frequency lies above the first family, because
    contact stiffens the blades: the arrow below the strongest one is this distance from the top of
    the family (Δ1B of the paper), which the title of the panel has in numbers. The bar along the
    upper edge marks speeds whose motion was not steady.
    """
    speeds, frequencies = file.read("speeds_hz"), file.read("frequencies_hz")
    n_disks = len(file.read("deviation"))
    axes = canvas.panels(1, n_disks, (1.5 + 6.0 * n_disks, 6.4), sharey=True)[0]
    spectra = 1e3 * file.read("spectrum_m")
    # the scale needs a top even where nothing moves
    top = np.max(spectra, where=np.isfinite(spectra), initial=0.0) or 1.0
    reasons = file.read("point_reason")
    for disk, panel in enumerate(axes):
        image = panel.pcolormesh(
            speeds, frequencies, spectra[disk].T, norm=LogNorm(top / 10**DECADES, top),
            cmap="Greys", shading="nearest", rasterized=True,
        )  # fmt: skip
        for speed, reason in zip(speeds, reasons[disk], strict=True):
            if status.are_fatal(reason):
                panel.axvline(speed, color=PINK, lw=2, label=status.words(reason))
        panel.margins(x=0)
        panel.set(ylim=(0, frequencies[-1]), xlabel="speed of rotation [Hz]")
        panel.grid(False)
        _draw_orders(panel, file)
        natural = file.read("natural_frequencies_hz", disk)
        curves = np.broadcast_to(natural, (len(speeds), len(natural)))
        if file.config.disk.model is not None:  # its stiffness depends on the speed
            curves = file.read("natural_frequencies_at_speed_hz", disk)
        for curve in curves[:, natural < frequencies[-1]].T:
            panel.plot(speeds, curve, color=BLUE, lw=0.7, label="natural frequencies")
        _draw_casing(panel, file)
        words, strongest = DISKS[disk], interactions(speeds, frequencies, spectra[disk])
        if strongest:
            highest = curves[:, : file.config.disk.n_blades].max(axis=1)
            family = np.interp(strongest[0].speed_hz, speeds, highest)
            words += _draw_interactions(panel, strongest, family)
        panel.set_title(words, pad=20, fontsize=12)
        ends = edges(speeds)
        for first, end in stretches(file.read("point_status", disk) == NOT_STEADY):
            panel.plot(
                ends[[first, end]], [1, 1], color=PINK, lw=6, clip_on=False, solid_capstyle="butt",
                label="not steady: one draw of many", transform=panel.get_xaxis_transform(),
            )  # fmt: skip
        _say_means(canvas, file, disk)
    axes[0].set_ylabel("frequency [Hz]")
    words = "amplitude of $u_t$ at a frequency,\nlargest of all tips [mm]"
    canvas.figure.colorbar(image, ax=axes, label=words)


def _say_means(canvas: Canvas, file: ResultFile, disk: int) -> None:
    """Note at how many speeds the amplitude is a mean of windows, and the error of these means."""
    means = file.read("point_status", disk) == AVERAGED
    if means.any():
        error = file.read("mean_error_m", disk)[means] / file.read("mean_amplitude_m", disk)[means]
        canvas.note(
            f"{DISKS[disk]}: at {100 * means.mean():.0f} % of the speeds the amplitude is a mean of"
            f" windows, known to ±{100 * Z_95 * np.median(error):.0f} % (95 % interval, median)"
        )


def interactions(speeds: Any, frequencies: Any, spectrum: Any) -> list[Interaction]:
    """Return the strongest interactions, at most one on an engine order, the strongest first.

    speeds: speeds of rotation (S,) [Hz]; frequencies: axis of the spectra (F,) [Hz], evenly spaced
    from 0; spectrum: amplitude (S, F), NaN where the motion was lost.
    """
    regions = []
    step = frequencies[1] - frequencies[0]
    for order in range(1, int(frequencies[-1] / speeds[0]) + 1):
        at = np.rint(order * speeds / step).astype(int)
        on = at < len(frequencies)
        amplitudes = spectrum[np.arange(len(speeds)), np.where(on, at, 0)]
        along = np.where(on, np.nan_to_num(amplitudes), 0.0)
        best = int(along.argmax())
        large = stretches(along >= AREA * along[best])
        first, end = next(one for one in large if one[0] <= best < one[1])
        at_best, low, high = (float(speeds[i]) for i in (best, first, end - 1))
        regions.append(Interaction(order, at_best, low, high, float(along[best])))
    regions.sort(key=lambda interaction: -interaction.amplitude)
    return [one for one in regions[:N_INTERACTIONS] if one.amplitude > 0]


def _draw_casing(axes: Axes, file: ResultFile) -> None:
    """Draw the frequencies of a casing that vibrates as the rotor sees them, |f_c ± n f|."""
    casing = casing_modes_of(file.config)
    if casing is None:
        return
    speeds, top = file.read("speeds_hz"), file.read("frequencies_hz")[-1]
    for n, f in zip(casing.n_waves, casing.omega / (2.0 * np.pi), strict=True):
        for seen in (np.abs(f - n * speeds), f + n * speeds):
            if seen.min() < top:
                label = "waves of the casing"
                axes.plot(speeds, seen, color=YELLOW, lw=1.4, ls=(0, (1, 1)), label=label)


def _draw_orders(axes: Axes, file: ResultFile) -> None:
    """Draw engine orders: sparse lines, which leave ridges below visible, and numbers outside."""
    speeds, frequencies = file.read("speeds_hz"), file.read("frequencies_hz")
    main = file.config.casing.main_order
    for order in range(1, 3 * main + 1):
        if (order > NAMED and order % main) or order * speeds[0] > frequencies[-1]:
            continue
        look: dict[str, Any] = {"color": ORANGE, "lw": 0.9, "ls": (0, (2, 5))}
        axes.plot(speeds, order * speeds, label="engine orders", **look)
        above = order * speeds[-1] > frequencies[-1]
        place = (frequencies[-1] / order, 1.0) if above else (1.0, order * speeds[-1])
        along = axes.get_xaxis_transform() if above else axes.get_yaxis_transform()
        axes.annotate(
            f"{order}", place, (0, 6) if above else (4, 0), along, "offset points", color=ORANGE,
            fontsize=10, ha="center" if above else "left", va="bottom" if above else "center",
        )  # fmt: skip


def _draw_interactions(axes: Axes, strongest: list[Interaction], family: float) -> str:
    """Frame the interactions; returns words on the strongest one and its distance to the family."""
    for one in strongest:
        low, high = one.order * one.first_hz - ABOVE_AREA, one.order * one.last_hz + ABOVE_AREA
        axes.add_patch(
            Rectangle(
                (one.first_hz - 0.5, low), one.last_hz - one.first_hz + 1.0, high - low, fill=False,
                ec=PINK, lw=1.8, label="strongest interactions", zorder=4,
            )
        )  # fmt: skip
    main = strongest[0].frequency_hz
    axes.axhline(main, color=GREEN, lw=1.2, ls="--", label="frequency of the strongest interaction")
    if main <= family:
        return f"\nstrongest interaction at {main:.0f} Hz"
    at = strongest[0].speed_hz
    arrow = {"arrowstyle": "<->", "color": GREEN, "lw": 1.5, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (at, main), (at, family), arrowprops=arrow)
    return f"\nstrongest interaction at {main:.0f} Hz, {main - family:.0f} Hz above the family"


@figure("branches", paper="17", what="stable motions, localisation", main=True)
def branches(canvas: Canvas, file: ResultFile) -> None:
    """Amplitudes over the speeds from several initial states, and the branches they belong to.

    A point is the mean of many windows after the steady-state test, its bar their standard
    deviation, its colour their localisation, its marker the initial state. A line joins the points
    of one branch. Speeds at which branches coexist are grey; where these are few, a second panel
    looks closer at the longest range of them. Points that are not steady are hollow.
    """
    branch_of = label_file(file)
    several, speeds = coexisting(branch_of) > 1, file.read("speeds_hz")
    near = [slice(None), *_closer(several)]
    panels = canvas.panels(len(near), 1, (10, 0.6 + 4.6 * len(near)))[:, 0]
    local = 100 * file.read("window_localisation").mean(axis=-1)
    known = local[branch_of >= 0]
    scale = Normalize(*((known.min(), known.max()) if len(known) else (0.0, 100.0)))
    ends, grey = edges(speeds), {"color": "0.88", "lw": 0, "zorder": 0}
    for panel, part in zip(panels, near, strict=True):
        for first, end in stretches(several):
            panel.axvspan(ends[first], ends[end], label="several motions coexist", **grey)
        image = _draw(panel, file, branch_of, part, scale)
        panel.set(xlabel="speed of rotation [Hz]", ylabel="steady amplitude,\nmax $|u_t|$ [mm]")
        margin = 0.02 * np.ptp(speeds[part]) + ends[1] - ends[0]
        panel.set_xlim(speeds[part][0] - margin, speeds[part][-1] + margin)
    if not len(known):
        say(panels[0], "no point is steady")
    panels[-1].set_title("closer" if len(near) > 1 else "")
    n_windows = file.read("window_amplitude_m").shape[-1]
    size, points = 100 * coexistence.ALIKE_AMPLITUDE, 100 * coexistence.ALIKE_LOCALISATION
    canvas.note(
        f"Points and bars: means and standard deviations of {n_windows} windows. At grey speeds "
        f"motions differ by more than {size:g} % or {points:g} points of localisation, and by more "
        "than chance; at white ones they do not, or their windows scatter too much to tell."
    )
    n_lost = np.count_nonzero(file.read("point_status") == DIVERGED)
    if n_lost:
        canvas.note(f"{n_lost} of {branch_of.size} points diverged and are not shown.")
    canvas.figure.colorbar(image, ax=panels, label="localisation factor [%]", aspect=40)


def _closer(several: Any) -> list[slice]:
    """Return the longest stretch of speeds where branches coexist, with as much on either side."""
    if not several.any():
        return []
    first, last = max(stretches(several), key=np.ptp)
    near = slice(max(0, first - (last - first)), 2 * last - first)
    return [near] if len(several[near]) < CLOSER * len(several) else []


def _draw(axes: Axes, file: ResultFile, branch_of: Any, part: slice, scale: Normalize) -> Any:
    """Draw points and branches at a part of the speeds; returns points, for the colour scale."""
    speeds, branch_at = file.read("speeds_hz")[part], branch_of[:, part]
    windows = 1e3 * file.read("window_amplitude_m")[:, part]
    amplitude, scatter = windows.mean(axis=-1), windows.std(axis=-1, ddof=1)
    local = 100 * file.read("window_localisation")[:, part].mean(axis=-1)
    for branch in np.unique(branch_at[branch_at >= 0]):
        line = np.ma.masked_array(amplitude, branch_at != branch).mean(axis=0)
        axes.plot(speeds, line, color="0.6", lw=1, zorder=1)
    for start, name in enumerate(starts(file.config)):
        marker, steady = MARKERS[min(start, len(MARKERS) - 1)], branch_at[start] >= 0
        axes.errorbar(
            speeds[steady], amplitude[start, steady], scatter[start, steady], fmt="none",
            ecolor="0.6", lw=0.7, zorder=1,
        )  # fmt: skip
        image = axes.scatter(
            speeds[steady], amplitude[start, steady], c=local[start, steady], s=26, marker=marker,
            norm=scale, cmap=SHADES, lw=0, zorder=2,
        )  # fmt: skip
        rough = ~steady & (file.read("point_status", start)[part] != DIVERGED)
        single = 1e3 * file.read("amplitude_m", start)[part][rough]
        axes.plot(speeds[rough], single, marker, mfc="none", mec="0.7", ms=3, zorder=1)
        axes.plot([], [], marker, color="0.3", ls="", label=f"from: {name}")
        if rough.any():
            axes.plot([], [], "o", mfc="none", mec="0.6", ls="", label="not steady")
    return image
