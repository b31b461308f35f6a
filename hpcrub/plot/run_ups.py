"""The figure of a run_up study: envelopes, percentiles over the rate, and spectra."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm

from hpcrub.plot.amplifications import Look, draw_curves, explain
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.style import BLUE, DOTTED, ORANGE, edges, shades
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import finite
from hpcrub.studies.run_up.summary import leg_names, of_disks

WAYS = {True: ("-", BLUE), False: ("--", ORANGE)}  # of legs in which the speed rises, or falls
DECADES = 3.0  # of amplitudes in a spectrum


@figure("run_up", what="envelopes of a run-up, percentiles over the rate, spectra", main=True)
def run_up(canvas: Canvas, file: ResultFile) -> None:
    """Envelopes of the tuned disk, percentiles of all disks over the rate, and spectra.

    Lines of the envelopes are medians of the repetitions, bands reach from the least to the
    largest. The dotted line is the steady answer, where the study has sources. The spectra are
    those of the tip that moves furthest, in the first repetition of the tuned disk at the first
    rate, in the first leg and the last.
    """
    panels = canvas.panels(2, 2, (14.0, 10.0))
    _draw_envelopes(panels[0, 0], file)
    _draw_percentiles(panels[0, 1], file)
    n_legs, image = len(file.read("rises")), None
    spectra = 1e3 * file.read("tuned/spectrum_m", 0)
    top = np.nanmax(spectra, initial=1e-6)
    for panel, leg in zip(panels[1], (0, n_legs - 1), strict=True):
        image = _draw_spectrum(panel, file, spectra[leg], leg, top)
    canvas.figure.colorbar(image, ax=panels[1], label="amplitude [mm]")


def _draw_envelopes(axes: Axes, file: ResultFile) -> None:
    """Envelopes of the tuned disk in the first and the last leg, a colour for each rate."""
    speeds, legs, rises = file.read("interval_hz"), leg_names(file), file.read("rises")
    rates = file.read("hz_per_s")
    for rate, colour in enumerate(shades(len(rates))):
        envelope = 1e3 * file.read("tuned/envelope_m", rate)  # (R, D, I)
        for leg in sorted({0, len(legs) - 1}):
            style, mine = WAYS[bool(rises[leg])][0], envelope[:, leg]
            known = np.isfinite(mine).all(axis=0)
            axes.fill_between(
                speeds[known], mine[:, known].min(axis=0), mine[:, known].max(axis=0),
                color=colour, alpha=0.2, lw=0,
            )  # fmt: skip
            label = f"{rates[rate]:g} Hz/s, {legs[leg]}"
            middle = np.median(mine[:, known], axis=0)
            axes.plot(speeds[known], middle, style, color=colour, lw=1.5, label=label)
    if "steady_speed_hz" in file:
        steady = file.read("steady_speed_hz"), 1e3 * file.read("tuned/steady_amplitude_m")
        axes.plot(*steady, label="steady", **DOTTED)
    axes.set(xlabel="speed of rotation [Hz]", ylabel="largest displacement of a tip [mm]")
    axes.set(title="tuned disk", ylim=(0.0, None))


def _draw_percentiles(axes: Axes, file: ResultFile) -> None:
    """Percentiles of the peaks of all disks at the widest level over the rate, by leg."""
    at, sizes = file.config.convergence.percentiles, 1e3 * of_disks(file)[-1]
    rates, names, rises = file.read("hz_per_s"), leg_names(file), file.read("rises")
    looks = []
    for leg in sorted({0, len(names) - 1}):
        style, colour = WAYS[bool(rises[leg])]
        looks.append(Look(names[leg], colour, style))
        disks = [finite(sizes[:, rate, leg]) for rate in range(len(rates))]
        draw_curves(axes, np.log10(rates), disks, at, looks[-1], from_one=False)
    explain(axes, looks, at)
    if "samples/steady_peak_m" in file:
        steady = 1e3 * np.percentile(finite(file.read("samples/steady_peak_m")[-1]), at)
        for k, value in enumerate(steady):
            axes.axhline(value, label="steady, the same percentiles" if k == 0 else None, **DOTTED)
    axes.set_xticks(np.log10(rates), [f"{rate:g}" for rate in rates])
    level = f"±{100 * file.read('half_range')[-1]:.3g} %"
    axes.set(xlabel="gain of speed [Hz/s]", ylabel="peak of a run [mm]")
    axes.set_title(f"{len(sizes)} disks of {level}, median of the repetitions")


def _draw_spectrum(axes: Axes, file: ResultFile, spectra: Any, leg: int, top: float) -> Any:
    """Map of spectra (I, F) over speed and frequency, and orders of the rotation."""
    speeds, frequencies = file.read("interval_hz"), file.read("frequency_hz")
    norm = LogNorm(top * 10.0**-DECADES, top, clip=True)
    image = axes.pcolormesh(
        edges(speeds), edges(frequencies), np.ma.masked_invalid(spectra.T), norm=norm,
        cmap="viridis", rasterized=True,
    )  # fmt: skip
    order = file.config.casing.main_order
    for k in (1, 2, 3):
        if k * order * speeds[0] < frequencies[-1]:
            axes.plot(speeds, k * order * speeds, ":", color="white", lw=1)
    axes.set(xlabel="speed of rotation [Hz]", ylabel="frequency [Hz]")
    axes.set(ylim=(0.0, frequencies[-1]), xlim=edges(speeds)[[0, -1]])
    axes.grid(visible=False)
    rate = file.read("hz_per_s")[0]
    axes.set_title(f"{leg_names(file)[leg]} at {rate:g} Hz/s; dotted: orders of {order} bumps")
    return image
