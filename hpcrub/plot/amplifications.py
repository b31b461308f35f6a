"""Percentiles of amplifications and amplitudes over mistuning, load, damping and studies."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from hpcrub.config.text import counted
from hpcrub.errors import InputError
from hpcrub.plot import intervals
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.families import (
    finished,
    labels,
    numeric,
    ordered,
    reference,
    require_same,
    uncertainty,
)
from hpcrub.plot.style import BLACK, BLUE, GREEN, MARKERS, ORANGE, shades
from hpcrub.results.storage import ResultFile
from hpcrub.studies.contact import measured

MOST_PANELS = 6  # files with a panel each; more are rows of one panel
CONTACT = ("amplification", "contact", BLUE, "-")
LINEAR = ("linear_amplification", "linear", ORANGE, "--")
BESIDE = -0.12, 0.12  # of a row: both amplifications
SIGMA = "mistuning σ [%]"


def draw_curves(
    axes: Axes, x: Any, values: Sequence[Any], at: Sequence[float], colours: Sequence[str],
    style: str = "-", prefix: str = "", shared: Any = (0.0, 0.0), from_one: bool = True,
) -> bool:  # fmt: skip
    """Percentiles of values (one array for every x), each with its interval.

    from_one: begin at the tuned disk, whose amplification is 1.
    Returns whether an interval has an open end.
    """
    known = [v for v in range(len(x)) if len(values[v])]
    curves = np.array([np.percentile(values[v], at) for v in known]).reshape(-1, len(at)).T
    ends = [intervals.interval(values[v], at, shared) for v in known]
    low, high = np.transpose(ends, (1, 2, 0)) if ends else np.empty((2, len(at), 0))
    x, (zero, one) = x[known], ([0.0], [1.0]) if from_one else ([], [])
    open_end = False
    for p, percentile in enumerate(at):
        colour, marker = colours[p % len(colours)], MARKERS[p % len(MARKERS)]
        axes.plot(
            [*zero, *x], [*one, *curves[p]], style, marker=marker, color=colour, lw=1.6,
            label=f"{prefix}percentile {percentile:g}",
        )  # fmt: skip
        open_end |= intervals.draw(axes, x, curves[p], low[p], high[p], colour)
    axes.margins(y=0.1)
    return open_end


@figure("contact", paper="12", what="both amplifications over σ", several=True, alone=False,
        random=True)  # fmt: skip
def percentiles(canvas: Canvas) -> None:
    """Percentiles of both amplifications against σ, a panel for every file.

    Of many files, or of one level only, all lie in one panel, a row each, at the widest level.
    """
    files = ordered(canvas.files)
    if len(files) > MOST_PANELS or all(len(f.read("sigma")) == 1 for f in files):
        _draw_rows(canvas, files)
        return
    columns = min(2, len(files))
    axes = canvas.grid(len(files), columns, (6, 4.2), sharey=True)
    open_end = False
    for file, panel, label in zip(files, axes, labels(files), strict=True):
        sigma, at = 100 * file.read("sigma"), file.config.convergence.percentiles
        for name, word, colour, style in (CONTACT, LINEAR):
            values = finished(file, name)
            shared = uncertainty(file, name)
            open_end |= draw_curves(panel, sigma, values, at, [colour], style, f"{word}, ", shared)
        panel.set(xlabel=SIGMA, title=f"{label}, {samples(file)}")
    for panel in axes[::columns]:
        panel.set_ylabel("amplification [-]")
    canvas.legend_of_all(axes[:1], intervals.handles(open_end))


def _case(file: ResultFile) -> str:
    casing = file.config.casing
    return casing.words if casing.profile.exists else f"$n_d$ = {casing.n_bumps}"


def samples(file: ResultFile) -> str:
    """How many samples a level has that are finished."""
    return _in_words(finished(file, "amplification"))


def _in_words(levels: Sequence[Any]) -> str:
    counts = sorted({len(values) for values in levels})
    return f"{counts[0]}–" * (len(counts) > 1) + counted(counts[-1], "sample")


def _draw_rows(canvas: Canvas, files: list[ResultFile]) -> None:
    """A row for every file, its widest level; light lines at the percentiles of the reference."""
    axes = canvas.panels(1, 1, (10, 1.6 + 0.55 * len(files)))[0, 0]
    best, open_end = reference(files), False
    for row, file in enumerate(files):
        open_end |= draw_row(axes, row, file)
    if len(files) > 1:
        for name, _, colour, _ in (CONTACT, LINEAR):
            values = finished(best, name)[-1]
            for value in np.percentile(values, best.config.convergence.percentiles):
                axes.axvline(value, color=colour, lw=0.8, alpha=0.6, zorder=0)
    names = [
        f"{label}\n({samples(file)})" for file, label in zip(files, labels(files), strict=True)
    ]
    row = files.index(best)
    names[row] = names[row].replace("(", "(lines; ") if len(files) > 1 else names[row]
    axes.set_yticks(range(len(files)), names, fontsize=10)
    axes.set_ylim(len(files) - 0.5, -0.5)
    level = 100 * best.read("half_range")[-1]
    axes.set(xlabel="amplification [-]", title=f"Amplifications at ±{level:.3g} %")
    canvas.legend_of_all([axes], intervals.handles(open_end))


def draw_row(axes: Axes, row: float, file: ResultFile) -> bool:
    """Percentiles of both amplifications of a file's widest level, with their intervals, in a row.

    Returns whether an interval has an open end.
    """
    at, open_end = file.config.convergence.percentiles, False
    for (name, word, colour, _), beside in zip((CONTACT, LINEAR), BESIDE, strict=True):
        values = finished(file, name)[-1]
        if not len(values):
            continue
        centre = np.percentile(values, at)
        low, high = intervals.interval(values, at, uncertainty(file, name))
        height = np.full(len(at), row + beside)
        open_end |= intervals.draw(axes, height, centre, low, high, colour, sideways=True)
        for p, value in enumerate(centre):
            axes.plot(
                value, height[p], MARKERS[p % len(MARKERS)], color=colour, ms=7,
                label=f"{word}, percentile {at[p]:g}",
            )  # fmt: skip
    return open_end


def draw_disks(axes: Axes, found: list[measured.Disk]) -> None:
    """Both amplifications of measured disks, a row each, with the intervals of those in contact."""
    rows = np.array([disk.number for disk in found], dtype=float)
    contact, linear = (
        np.array([getattr(d, n) for d in found]) for n in ("amplification", "linear")
    )
    low, high = np.transpose([disk.interval for disk in found])
    intervals.draw(axes, rows + BESIDE[0], contact, low, high, BLUE, sideways=True)
    axes.plot(contact, rows + BESIDE[0], "o", color=BLUE, ms=7, label="contact")
    axes.plot(linear, rows + BESIDE[1], "s", color=ORANGE, ms=7, label="linear")
    axes.set_yticks(rows, [f"disk {disk.number}" for disk in found])
    axes.set_ylim(rows.max() + 0.5, rows.min() - 0.5)


@figure("contact", paper="13", what="largest amplitudes over n_d", several=True, alone=False,
        random=True)  # fmt: skip
def amplitudes(canvas: Canvas) -> None:
    """Largest amplitudes of the tuned disk and percentile 99 of the samples, a place each file.

    Lines join them only where the files differ in a number; the levels stand side by side.
    """
    files = ordered(canvas.files)
    axes = canvas.panels(1, 1, (max(8.0, 1.3 * len(files)), 5.6))[0, 0]
    line, x = ("-" if numeric(files) else "none"), np.arange(len(files))
    tuned = np.array([1e3 * file.read("tuned/reference_amplitude_m") for file in files])
    runs = [1e3 * f.read("tuned/run_peaks_m") for f in files]
    axes.plot(
        x, tuned, marker="s", ls=line, color=BLACK, label="tuned disk, range of its perturbed runs"
    )
    spread = np.array(
        [[tuned - [np.nanmin(r) for r in runs]], [[np.nanmax(r) for r in runs] - tuned]]
    )
    axes.errorbar(x, tuned, yerr=spread[:, 0], fmt="none", ecolor=BLACK, capsize=3)
    sigmas = np.unique(np.concatenate([file.read("sigma") for file in files]))
    colours = dict(zip(sigmas, shades(len(sigmas)), strict=True))
    done = [
        dict(zip(file.read("sigma"), finished(file, "peak_amplitude_m"), strict=True))
        for file in files
    ]
    open_end = False
    for level, (sigma, colour) in enumerate(colours.items()):
        have = [i for i in x if len(done[i].get(sigma, ()))]
        if not have:
            continue
        values = [1e3 * done[i][sigma] for i in have]
        top = np.array([np.percentile(v, 99) for v in values])
        low, high = np.array([np.ravel(intervals.interval(v, [99])) for v in values]).T
        beside = np.add(have, 0.06 * (level + 1))
        axes.plot(
            beside, top, ls=line, color=colour, marker=MARKERS[level % len(MARKERS)],
            label=f"percentile 99, σ = {100 * sigma:.1f} %",
        )  # fmt: skip
        open_end |= intervals.draw(axes, beside, top, low, high, colour)
    names = labels(files) if len(files) > 1 else [_case(files[0])]
    long = max(map(len, names)) > 10
    turned: dict[str, Any] = {"rotation": 30, "ha": "right", "rotation_mode": "anchor"}
    axes.set_xticks(x, names, **(turned if long else {}))
    axes.set_ylabel("largest blade-tip amplitude [mm]")
    axes.set_title(", ".join(sorted({samples(file) for file in files})) + " per level")
    axes.set_ylim(0, 1.12 * axes.get_ylim()[1])
    canvas.legend_of_all([axes], intervals.handles(open_end), columns=2)


@figure("linear", paper="4", what="linear amplification over σ and n_d", main=True)
def linear(canvas: Canvas) -> None:
    """Percentiles of the linear amplification against σ, a panel for every load."""
    file = canvas.file
    diameters, sigma = file.read("n_diameters"), 100 * file.read("sigma")
    at = file.config.convergence.percentiles
    columns = min(3, len(diameters))
    axes = canvas.grid(len(diameters), columns, (4, 3.3), sharex=True, sharey=True)
    open_end = False
    for d, panel in enumerate(axes):
        by_level = file.read("amplification", (slice(None), d))
        values = [level[np.isfinite(level)] for level in by_level]
        open_end |= draw_curves(panel, sigma, values, at, [GREEN, BLUE, ORANGE])
        panel.set_title(f"$n_d$ = {diameters[d]}")
    canvas.title(f"Linear amplification, {_in_words(values)} per level")
    for panel in axes[-columns:]:
        panel.set_xlabel(SIGMA)
    for panel in axes[::columns]:
        panel.set_ylabel("amplification [-]")
    canvas.legend_of_all(axes[:1], intervals.handles(open_end), columns=4)


@figure("contact", paper="16", what="percentiles at several dampings", several=True, alone=False,
        random=True)  # fmt: skip
def damping(canvas: Canvas) -> None:
    """Percentiles of both amplifications against σ of files that differ in their damping."""
    files = sorted(canvas.files, key=lambda file: -file.config.material.damping_ratio)
    require_same(files, but="material.damping_ratio")
    if files[0].config.material.damping_ratios is not None:
        raise InputError(f"{files[0].path} has material.damping_ratios, and not one for all modes")
    axes, open_end = canvas.panels(1, 2, (12, 5.4), sharey=True)[0], False
    looks = list(zip((BLUE, ORANGE, GREEN), ("-", "--", ":"), strict=True))
    for (name, word, *_), panel in zip((CONTACT, LINEAR), axes, strict=True):
        for case, file in enumerate(files):
            colour, style = looks[case % len(looks)]
            sigma, at = 100 * file.read("sigma"), file.config.convergence.percentiles
            prefix = f"ξ = {1e3 * file.config.material.damping_ratio:g}·10⁻³, "
            values = finished(file, name)
            open_end |= draw_curves(panel, sigma, values, at, [colour], style, prefix)
        panel.set(xlabel=SIGMA, title=f"{word} amplification")
    axes[0].set_ylabel("amplification [-]")
    canvas.legend_of_all(axes[:1], intervals.handles(open_end), columns=2)
