"""Disks in air: damping of the tuned waves, and of the modes of mistuned disks."""

import numpy as np
from matplotlib.axes import Axes

from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.style import BLACK, BLUE, DOTTED, ORANGE, shades
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import finite

SIGMA = "standard deviation of the blades' stiffness [%]"


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


def draw_limit(axes: Axes, file: ResultFile, load: int) -> None:
    """Draw Whitehead's limit of the linear amplification under a load (its index), if it holds."""
    limit = file.read("aero/largest_amplification", load)
    if np.isfinite(limit):
        axes.axhline(limit, label="limit (Whitehead)", **DOTTED)


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
