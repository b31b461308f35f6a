"""Figures over the speeds: interactions of engine orders and modes, and coexisting motions."""

from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, LogNorm, Normalize
from matplotlib.patches import Rectangle

from hpcrub.contact import status
from hpcrub.contact.status import AVERAGED, DIVERGED, NOT_STEADY
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.histories import DISKS
from hpcrub.plot.style import BLUE, GREEN, MARKERS, ORANGE, PINK, YELLOW, edges, say, shades
from hpcrub.results.storage import ResultFile
from hpcrub.setup.casing import casing_modes_of
from hpcrub.statistics import coexistence
from hpcrub.statistics.coexistence import coexisting, stretches
from hpcrub.statistics.percentiles import Z_95
from hpcrub.studies.branches import label_file, starts

DECADES = 3.5  # decades of amplitude that are drawn, below the largest one
N_INTERACTIONS = 2  # number of interactions that are marked, on different engine orders
AREA = 0.5  # part of an order's largest amplitude, above which speeds belong to the interaction
ABOVE_AREA = 6.0  # half height of the box of an interaction [Hz]
NAMED = 4  # engine orders up to this one are all named, besides the multiples of the bumps
CLOSER = 0.5  # part of the speeds, above which a closer look would show the whole again
SHADES = LinearSegmentedColormap.from_list("localisation", shades(256))


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
