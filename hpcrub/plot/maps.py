"""Figure of an interaction_map study: engine orders, families of modes, and where they interact."""

from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.patches import Rectangle

from hpcrub.contact import status
from hpcrub.contact.status import AVERAGED, NOT_STEADY
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.histories import DISKS
from hpcrub.plot.style import BLUE, GREEN, ORANGE, PINK
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import Z_95

DECADES = 3.5  # of the amplitude, above which it is drawn
N_INTERACTIONS = 2  # marked, on different engine orders
AREA = 0.5  # of the largest amplitude of an order, above which speeds belong to the interaction
ABOVE_AREA = 6.0  # half height of the box of an interaction [Hz]
NAMED = 4  # engine orders that are all named, besides the multiples of the bumps


class Interaction(NamedTuple):
    """One area of large amplitudes on an engine order."""

    order: int
    speed_hz: float  # of the largest amplitude
    first_hz: float  # lowest and highest speed of the area
    last_hz: float
    amplitude: float  # as the spectra

    @property
    def frequency_hz(self) -> float:
        """Frequency of the motion at the largest amplitude: that of the nonlinear mode."""
        return self.order * self.speed_hz


@figure("interaction_map", paper="6", what="spectra over the speeds", main=True)
def interaction_map(canvas: Canvas) -> None:
    """Spectra over the speeds with engine orders and natural frequencies, a panel for every disk.

    The two strongest interactions are framed. Their frequency lies above the first family, as
    contact stiffens the blades: the arrow is this distance from the top of the family (Δ1B of the
    paper). Marks on the upper edge are speeds whose motion was not steady.
    """
    file = canvas.file
    speeds, frequencies = file.read("speeds_hz"), file.read("frequencies_hz")
    n_disks = len(file.read("deviation"))
    axes = canvas.panels(1, n_disks, (1.5 + 6.0 * n_disks, 6.4), sharey=True)[0]
    spectra = 1e3 * file.read("spectrum_m")
    # with a scale that has a top even where nothing moves
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
        panel.set_title(DISKS[disk], pad=20)
        panel.grid(False)
        _draw_orders(panel, file)
        natural = file.read("natural_frequencies_hz", disk)
        curves = np.broadcast_to(natural, (len(speeds), len(natural)))
        if file.config.disk.model is not None:  # whose stiffness depends on the speed
            curves = file.read("natural_frequencies_at_speed_hz", disk)
        for curve in curves[:, natural < frequencies[-1]].T:
            panel.plot(speeds, curve, color=BLUE, lw=0.7, label="natural frequencies")
        strongest = interactions(speeds, frequencies, spectra[disk])
        if strongest:
            highest = curves[:, : file.config.disk.n_blades].max(axis=1)
            family = np.interp(strongest[0].speed_hz, speeds, highest)
            _draw_interactions(panel, strongest, family)
        unsteady = speeds[file.read("point_status", disk) == NOT_STEADY]
        panel.plot(
            unsteady, np.ones(len(unsteady)), "v", ms=5, mfc="w", mec=PINK, clip_on=False,
            label="not steady: one draw of many", transform=panel.get_xaxis_transform(), zorder=5,
        )  # fmt: skip
        _say_means(canvas, disk)
    axes[0].set_ylabel("frequency [Hz]")
    canvas.colorbar(image, axes, label="tangential amplitude of the tips, the largest [mm]")


def _say_means(canvas: Canvas, disk: int) -> None:
    """Note how many amplitudes are means of windows, and how well these are known."""
    file = canvas.file
    means = file.read("point_status", disk) == AVERAGED
    if means.any():
        error = file.read("mean_error_m", disk)[means] / file.read("mean_amplitude_m", disk)[means]
        canvas.note(
            f"{DISKS[disk]}: at {100 * means.mean():.0f} % of the speeds the amplitude is a mean of"
            f" windows, known to ±{100 * Z_95 * np.median(error):.0f} % (95 % interval, median)"
        )


def interactions(speeds: Any, frequencies: Any, spectrum: Any) -> list[Interaction]:
    """The strongest interactions, at most one on an engine order, the strongest first.

    speeds: of rotation (S,) [Hz]; frequencies: of the spectra (F,) [Hz], evenly spaced from 0;
    spectrum: amplitudes (S, F), NaN where the motion was lost.
    """
    regions = []
    step = frequencies[1] - frequencies[0]
    for order in range(1, int(frequencies[-1] / speeds[0]) + 1):
        at = np.rint(order * speeds / step).astype(int)
        on = at < len(frequencies)
        along = np.where(on, spectrum[np.arange(len(speeds)), np.where(on, at, 0)], 0.0)
        along = np.nan_to_num(along)
        best = int(along.argmax())
        large = along >= AREA * along[best]
        first, last = best, best
        while first > 0 and large[first - 1]:
            first -= 1
        while last < len(speeds) - 1 and large[last + 1]:
            last += 1
        at_best, low, high = (float(speeds[i]) for i in (best, first, last))
        regions.append(Interaction(order, at_best, low, high, float(along[best])))
    regions.sort(key=lambda interaction: -interaction.amplitude)
    return [one for one in regions[:N_INTERACTIONS] if one.amplitude > 0]


def _draw_orders(axes: Axes, file: ResultFile) -> None:
    """Engine orders: lines that leave the ridges below them visible, and their numbers outside."""
    speeds, frequencies = file.read("speeds_hz"), file.read("frequencies_hz")
    main = file.config.casing.main_order
    for order in range(1, 3 * main + 1):
        if (order > NAMED and order % main) or order * speeds[0] > frequencies[-1]:
            continue
        axes.plot(
            speeds, order * speeds, color=ORANGE, lw=0.9, ls=(0, (2, 5)), label="engine orders"
        )
        above = order * speeds[-1] > frequencies[-1]
        place = (frequencies[-1] / order, 1.0) if above else (1.0, order * speeds[-1])
        along = axes.get_xaxis_transform() if above else axes.get_yaxis_transform()
        axes.annotate(
            f"{order}", place, (0, 6) if above else (4, 0), along, "offset points", color=ORANGE,
            fontsize=10, ha="center" if above else "left", va="bottom" if above else "center",
        )  # fmt: skip


def _draw_interactions(axes: Axes, strongest: list[Interaction], family: float) -> None:
    """Frames of the areas, and how far above the first family [Hz] the strongest one lies."""
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
        return
    start, end = axes.get_xlim()
    at = start + 0.1 * (end - start)
    arrow = {"arrowstyle": "<->", "color": GREEN, "lw": 1.5, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (at, main), (at, family), arrowprops=arrow)
    axes.annotate(
        f"contact: +{main - family:.0f} Hz", (at, (main + family) / 2), (6, 0),
        textcoords="offset points", va="center", color=GREEN, fontsize=11,
        bbox={"fc": "w", "ec": "none", "alpha": 0.8, "pad": 1},
    )  # fmt: skip
