"""Figures that compare contact studies which differ in a few keys."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator

from hpcrub.contact.status import NOT_STEADY
from hpcrub.plot.labels import labels, ordered
from hpcrub.plot.linear import draw_percentiles
from hpcrub.plot.style import BLACK, BLUE, MARKERS, ORANGE
from hpcrub.results.layout import DONE
from hpcrub.statistics.percentiles import Z_95, percentile_interval


def responses(files):
    """Frequency responses of all files: tuned disk, and the pattern where there is one."""
    files = ordered(files)
    patterns = [file.config.pattern_deviation is not None for file in files]
    n_panels = 1 + any(patterns)
    figure, axes = plt.subplots(
        1, n_panels, figsize=(1.5 + 5.5 * n_panels, 5.6), sharey=True, squeeze=False
    )
    colours = plt.get_cmap("viridis")(np.linspace(0, 0.9, len(files)))
    for file, colour, label, pattern in zip(files, colours, labels(files), patterns, strict=True):
        _draw_response(axes[0, 0], file, "tuned", (), colour, label)
        if pattern:
            _draw_response(axes[0, 1], file, "samples", (0, 0), colour, label)
    for panel, title in zip(axes[0], ("tuned disk", "mistuned disk"), strict=False):
        panel.set(xlabel="speed of rotation [Hz]", title=title)
        panel.set_ylim(bottom=0)
    axes[0, 0].set_ylabel("blade-tip amplitude [mm]")
    lines, words = axes[0, 0].get_legend_handles_labels()
    lines.append(Line2D([], [], marker="o", mfc="w", mec=BLACK, ls=""))
    words.append("not steady")
    columns = 3 if max(map(len, words)) < 20 else 2
    figure.legend(lines, words, loc="outside lower center", ncols=columns)
    return figure


def _draw_response(axes, file, group, where, colour, label):
    speeds, amplitude = file.read("speeds_hz"), 1e3 * file.read(f"{group}/amplitude_m", where)
    axes.plot(speeds, amplitude, color=colour, lw=1.5, marker=".", ms=4, label=label)
    unsteady = file.read(f"{group}/point_status", where) == NOT_STEADY
    axes.plot(speeds[unsteady], amplitude[unsteady], "o", mfc="w", mec=colour, ms=4)


def _panels(files, height=4.2):
    """A figure with a panel for every file, in two columns."""
    columns = min(2, len(files))
    rows = -(-len(files) // columns)
    figure, axes = plt.subplots(
        rows, columns, figsize=(6 * columns, height * rows + 0.6), squeeze=False, sharey=True
    )
    for panel, label in zip(axes.flat, labels(files), strict=False):
        panel.set_title(label)
    for panel in axes.flat[len(files) :]:
        panel.set_axis_off()
    return figure, list(axes.flat[: len(files)])


def _colours(files):
    """{σ: colour} of all levels, of which a file may have only some."""
    sigma = np.unique(np.concatenate([file.read("sigma") for file in files]))
    return dict(zip(sigma, plt.get_cmap("viridis")(np.linspace(0, 0.9, len(sigma))), strict=True))


def _done(file, name):
    """Values of the finished samples of every level."""
    status, values = file.status(), file.read(f"samples/{name}")
    return [values[level][status[level] == DONE] for level in range(len(status))]


def percentiles(files):
    """Percentiles of both amplifications against σ, a panel for every file; 95 % bands."""
    files = ordered(files)
    figure, axes = _panels(files)
    for file, panel in zip(files, axes, strict=True):
        sigma, at = 100 * file.read("sigma"), file.config.convergence.percentiles
        for name, colour, style, prefix in (
            ("amplification", BLUE, "-", "contact, "),
            ("linear_amplification", ORANGE, "--", "linear, "),
        ):
            draw_percentiles(panel, sigma, _done(file, name), at, [colour], style, prefix)
        panel.set(xlabel="mistuning σ [%]", ylabel="amplification [-]")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def amplitudes(files):
    """Largest amplitudes of the tuned disk and of the samples against n_d; 95 % intervals."""
    files = ordered(files)
    figure, axes = plt.subplots(figsize=(8, 5.6))
    x = np.arange(len(files))
    tuned = np.array([1e3 * file.read("tuned/reference_amplitude_m") for file in files])
    runs = [1e3 * f.read("tuned/run_peaks_m") for f in files]
    spread = np.abs(np.array([[run.min() for run in runs], [run.max() for run in runs]]) - tuned)
    axes.errorbar(
        x, tuned, yerr=np.nan_to_num(spread), fmt="s-", color=BLACK, capsize=3,
        label="tuned disk, range of its runs",
    )  # fmt: skip
    colours = _colours(files)
    done = [
        dict(zip(file.read("sigma"), _done(file, "peak_amplitude_m"), strict=True))
        for file in files
    ]
    for level, (sigma, colour) in enumerate(colours.items()):
        have = [i for i in x if len(done[i].get(sigma, ()))]
        if not have:
            continue
        values = [1e3 * done[i][sigma] for i in have]
        top = np.array([np.percentile(v, 99) for v in values])
        ends = np.array([np.ravel(percentile_interval(v, [99], Z_95)) for v in values]).T
        spread = np.nan_to_num(np.abs(ends - top))  # an end that is not known is not drawn
        axes.errorbar(
            np.add(have, 0.04 * (level + 1)), top, yerr=spread, color=colour, capsize=3,
            marker=MARKERS[level % len(MARKERS)], label=f"percentile 99, σ = {100 * sigma:.1f} %",
        )  # fmt: skip
    names = labels(files) if len(files) > 1 else [f"$n_d$ = {files[0].config.casing.n_bumps}"]
    long = max(map(len, names)) > 10
    turned = {"rotation": 30, "ha": "right", "rotation_mode": "anchor"} if long else {}
    axes.set_xticks(x, names, **turned)
    axes.set_ylabel("largest blade-tip amplitude [mm]")
    axes.set_ylim(bottom=0)
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def running(files):
    """Running means of the percentiles against the number of samples."""
    figure, axes = _convergence(ordered(files), "mean_of_percentile", 1.0)
    for panel in axes:
        panel.set_ylabel("mean of the percentile of $A_{nl}$ [-]")
    return figure


def errors(files):
    """Convergence errors of the percentiles against the number of samples."""
    files = ordered(files)
    target = {"color": BLACK, "lw": 1.2, "ls": ":"}
    handle = Line2D([], [], **target, label="target")
    figure, axes = _convergence(files, "convergence_error", 100.0, [handle])
    for file, panel in zip(files, axes, strict=True):
        panel.axhline(100 * file.config.convergence.target_error, **target)
        panel.set(yscale="log", ylabel="convergence error of $A_{nl}$ [%]")
        for line in panel.get_lines():  # the logarithm of 0, of estimates that are all equal
            line.set_ydata(np.ma.masked_less_equal(line.get_ydata(), 0.0))
    return figure


def _convergence(files, name, scale, more_handles=()):
    """A statistic of the contact amplifications: colours tell σ, markers the percentile."""
    figure, axes = _panels(files)
    colours = _colours(files)
    at = sorted({p for file in files for p in file.config.convergence.percentiles})
    markers = {p: MARKERS[i % len(MARKERS)] for i, p in enumerate(at)}
    for file, panel in zip(files, axes, strict=True):
        seen = file.read("statistics/contact/samples_seen")
        values = scale * file.read(f"statistics/contact/{name}")
        marks = np.unique(np.geomspace(1, max(len(seen), 1), 8).astype(int) - 1)
        for sigma, of_level in zip(file.read("sigma"), values, strict=True):
            for p, curve in zip(file.config.convergence.percentiles, of_level, strict=True):
                panel.plot(
                    seen, curve, color=colours[sigma], lw=1.5, ms=6, marker=markers[p],
                    markevery=[m for m in marks if m < len(seen)],
                )  # fmt: skip
        panel.set(xscale="log", xlabel="samples")
        panel.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        panel.xaxis.set_major_formatter("{x:,.0f}")
        panel.xaxis.set_minor_formatter("")
    handles = [
        Line2D([], [], color=colour, label=f"σ = {100 * sigma:.1f} %")
        for sigma, colour in colours.items()
    ]
    handles += [
        Line2D([], [], color=BLACK, ls="", marker=marker, label=f"percentile {p:g}")
        for p, marker in markers.items()
    ]
    handles += more_handles
    figure.legend(handles=handles, loc="outside lower center", ncols=max(4, len(colours)))
    return figure, axes
