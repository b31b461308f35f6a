"""Figures of contact studies."""

import matplotlib.pyplot as plt
import numpy as np

from hpcrub.contact.status import NOT_STEADY
from hpcrub.plot.style import BLACK, BLUE, MARKERS, ORANGE, legend_below
from hpcrub.results.layout import DONE
from hpcrub.statistics.percentiles import percentile_interval

BAR_DISTANCE = 0.012  # of neighbouring error bars, of the axis
MOST = 20_000  # samples of a level behind the band of a frequency response


def summary(files):
    """Frequency responses, and the amplifications or localisations, of one study."""
    (file,) = files
    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 5.2))
    if file.config.pattern_deviation is None:
        _draw_band(left, file)
        _draw_amplifications(right, file)
    else:
        _draw_pattern(left, file, "amplitude_m", 1e3)
        left.set_ylabel("blade-tip amplitude [mm]")
        _draw_pattern(right, file, "localisation", 100)
        right.set_ylabel("localisation factor [%]")
    left.set_title(f"Contact response, {file.config.casing.n_bumps} bumps")
    return figure


def _draw_response(axes, file, group, where, name, scale):
    """One disk over the speeds, points that were not steady hollow."""
    label, colour = ("tuned", BLACK) if group == "tuned" else ("mistuned", BLUE)
    speeds, values = file.read("speeds_hz"), scale * file.read(f"{group}/{name}", where)
    axes.plot(speeds, values, color=colour, marker=".", label=label, zorder=3)
    unsteady = file.read(f"{group}/point_status", where) == NOT_STEADY
    if unsteady.any():
        hollow = {"mfc": "w", "mec": colour, "ms": 5, "zorder": 4}
        axes.plot(speeds[unsteady], values[unsteady], "o", label=f"{label}, not steady", **hollow)
    axes.set_xlabel("speed of rotation [Hz]")
    axes.set_ylim(bottom=0)


def _draw_pattern(axes, file, name, scale):
    """Tuned disk and one explicit pattern over the speeds."""
    _draw_response(axes, file, "samples", (0, 0), name, scale)
    _draw_response(axes, file, "tuned", (), name, scale)
    legend_below(axes)


def _draw_band(axes, file):
    """Tuned disk, and percentiles of the widest level's samples at every speed."""
    done = file.status()[-1, :MOST] == DONE
    amplitude = 1e3 * file.read("samples/amplitude_m", (-1, slice(MOST)))[done]
    speeds, percentiles = file.read("speeds_hz"), file.config.convergence.percentiles
    low, high = percentiles[0], percentiles[-1]
    known = np.isfinite(amplitude).any(axis=0)
    if known.any():
        band = np.nanpercentile(amplitude[:, known], [low, 50, high], axis=0)
        label = f"±{100 * file.read('half_range')[-1]:.3g} %, percentiles"
        axes.fill_between(
            speeds[known], band[0], band[2], color=BLUE, alpha=0.25, lw=0,
            label=f"{label} {low:g} to {high:g}",
        )  # fmt: skip
        axes.plot(speeds[known], band[1], color=BLUE, label=f"{label[:-1]} 50")
    _draw_response(axes, file, "tuned", (), "amplitude_m", 1e3)
    axes.set_ylabel("blade-tip amplitude [mm]")
    legend_below(axes)


def _draw_amplifications(axes, file):
    """Percentiles of both amplifications against the mistuning level, with their intervals."""
    half_range, status = 100 * file.read("half_range"), file.status()
    axes.axhline(1.0, color="0.6", lw=1)
    percentiles = file.config.convergence.percentiles
    for name, label, colour, line, side in (
        ("amplification", "contact", BLUE, "-", -1),
        ("linear_amplification", "linear", ORANGE, "--", 1),
    ):
        values = [file.read(f"samples/{name}", v)[status[v] == DONE] for v in range(len(status))]
        known = [v for v in range(len(status)) if len(values[v])]
        if not known:
            continue
        curves = np.array([np.percentile(values[v], percentiles) for v in known]).T
        z = file.config.convergence.z
        ends = np.array([percentile_interval(values[v], percentiles, z) for v in known]).T
        for p, curve in enumerate(curves):
            axes.plot(
                half_range[known], curve, line, color=colour, marker=MARKERS[p % len(MARKERS)],
                label=f"{label}, percentile {percentiles[p]:g}",
            )  # fmt: skip
            # an end that too few samples leave open gets no bar
            below, above = np.nan_to_num(curve - ends[p, 0]), np.nan_to_num(ends[p, 1] - curve)
            beside = half_range[known] + side * (p + 1) * BAR_DISTANCE * np.ptp(half_range)
            bars = {"fmt": "none", "ecolor": colour, "elinewidth": 1.2, "alpha": 0.6, "capsize": 3}
            axes.errorbar(beside, curve, [below, above], **bars)
    axes.set_xlabel("mistuning: half range of blade stiffness [± %]")
    axes.set_ylabel("amplification [-]")
    counts = (status == DONE).sum(axis=1)
    each = f"{counts.min()}" if counts.min() == counts.max() else f"{counts.min()}–{counts.max()}"
    axes.set_title(f"Amplification, {each} samples per level")
    axes.set_xticks(half_range, [f"{level:.3g}" for level in half_range])
    legend_below(axes)
