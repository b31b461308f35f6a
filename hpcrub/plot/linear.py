"""Figure of a linear study."""

import matplotlib.pyplot as plt
import numpy as np

from hpcrub.plot.style import BLUE, GREEN, MARKERS, ORANGE
from hpcrub.statistics.percentiles import Z_95, percentile_interval

COLOURS = [GREEN, BLUE, ORANGE]


def percentiles(files):
    """Percentiles of the linear amplification against σ, one panel per load; 95 % bands."""
    (file,) = files
    diameters, sigma = file.read("n_diameters"), 100 * file.read("sigma")
    at = file.config.convergence.percentiles
    columns = min(3, len(diameters))
    rows = -(-len(diameters) // columns)
    figure, axes = plt.subplots(
        rows, columns, figsize=(4 * columns, 3.3 * rows + 0.6), sharex=True, sharey=True,
        squeeze=False,
    )  # fmt: skip
    for d, panel in enumerate(axes.flat[: len(diameters)]):
        draw_percentiles(panel, sigma, [_known(file, v, d) for v in range(len(sigma))], at)
        panel.set_title(f"$n_d$ = {diameters[d]}")
    for panel in axes.flat[len(diameters) :]:
        panel.set_axis_off()
    for panel in axes[-1]:
        panel.set_xlabel("mistuning σ [%]")
    for panel in axes[:, 0]:
        panel.set_ylabel("linear amplification [-]")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def draw_percentiles(axes, sigma, values, at, colours=COLOURS, style="-", prefix=""):
    """Percentiles `at` of values (one array per σ), each with its 95 % band, from 1 at σ = 0."""
    known = [v for v in range(len(sigma)) if len(values[v])]
    x = np.array([0.0, *(sigma[v] for v in known)])
    for p, percentile in enumerate(at):
        colour, marker = colours[p % len(colours)], MARKERS[p % len(MARKERS)]
        curve = [1.0, *(np.percentile(values[v], percentile) for v in known)]
        ends = [np.ravel(percentile_interval(values[v], [percentile], Z_95)) for v in known]
        band = np.array([(1.0, 1.0), *ends])
        axes.fill_between(x, *band.T, color=colour, alpha=0.2, lw=0)
        label = f"{prefix}percentile {percentile:g}"
        axes.plot(x, curve, style, marker=marker, color=colour, label=label)


def _known(file, level, d):
    values = file.read("amplification", (level, d))
    return values[np.isfinite(values)]
