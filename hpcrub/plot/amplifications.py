"""Percentiles of amplifications and amplitudes over mistuning, load, damping and studies.

Colours tell contact from linear, or one study from another, and markers tell the percentiles. The
last figures show how the percentiles converge with the number of samples.
"""

import re
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, LogLocator

from hpcrub.config.text import counted
from hpcrub.errors import InputError
from hpcrub.plot import intervals
from hpcrub.plot.canvas import ENTRY, Canvas, figure
from hpcrub.plot.families import labels, level_colours, reference
from hpcrub.plot.style import BLACK, BLUE, DOTTED, ORANGE, marker
from hpcrub.results.samples import SEEN, of_levels
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import MIN_VALUES, confidence, finite, with_interval
from hpcrub.studies.contact import layout
from hpcrub.studies.contact import summary as contact_summary
from hpcrub.studies.contact.survey import shared_uncertainty

MOST_PANELS = 6  # files that get a panel each; more files are rows of one panel
CURVE_SHIFT = 0.012  # sideways shift of curves, part of the range of levels: intervals stay visible
ROW_SHIFT = 0.22  # of contact and linear amplifications from the middle of a row, parts of it
PERCENTILE_SHIFT = 0.11  # from one percentile to the next
SIGMA, AMPLIFICATION = "mistuning σ [%]", "amplification [-]"


class Look(NamedTuple):
    """Colour and style of a curve, and its word in the legend."""

    word: str
    colour: Any
    style: str = "-"


CONTACT, LINEAR = Look("contact", BLUE), Look("linear", ORANGE, "--")
RATIOS = ("amplification", CONTACT), ("linear_amplification", LINEAR)


def draw_curves(
    axes: Axes, x: Any, values: Sequence[Any], at: Sequence[float], look: Look,
    shared: Any = (0.0, 0.0), place: float = 0.0, from_one: bool = True,
) -> None:  # fmt: skip
    """Draw percentiles of values (one array for every x), each with its interval.

    place: sideways position among the curves that share x, such as −1 and 1 of two.
    from_one: begin the curves at the tuned disk, whose amplification is 1.
    """
    known = [v for v in range(len(x)) if len(values[v])]
    by_level = [with_interval(values[v], at, shared) for v in known]
    x = x[known] + place * CURVE_SHIFT * (np.max(x) - (0.0 if from_one else np.min(x)))
    zero, one = ([0.0], [1.0]) if from_one else ([], [])
    for p, curve in enumerate(np.reshape(by_level, (-1, 3, len(at))).T):
        line = [*zero, *x], [*one, *curve[0]]
        axes.plot(*line, look.style, marker=marker(p), color=look.colour, lw=1.6)
        intervals.draw(axes, x, curve, look.colour)
    axes.margins(y=0.18)  # room for the arrows of open ends


def explain(axes: Axes, looks: Sequence[Look], at: Sequence[float]) -> None:
    """Add the colours, and the markers of the percentiles, to the legend."""
    for look in looks:
        axes.plot([], [], look.style, color=look.colour, label=look.word)
    for p, percentile in enumerate(at):
        axes.plot([], [], marker(p), color="0.4", label=f"percentile {percentile:g}")


def draw_kinds(axes: Axes, file: ResultFile, x: Any, from_one: bool = True) -> None:
    """Draw percentiles of both amplifications of a file over x (V,), one for every level."""
    at = file.config.convergence.percentiles
    explain(axes, [CONTACT, LINEAR], at)
    for (name, look), place in zip(RATIOS, (-1, 1), strict=True):
        shared = shared_uncertainty(file, name)
        draw_curves(axes, x, of_levels(file, name), at, look, shared, place, from_one)


@figure("contact", paper="12, 16", what="both amplifications over σ", several=True, alone=False,
        needs="random")  # fmt: skip
def percentiles(canvas: Canvas, files: list[ResultFile]) -> None:
    """Percentiles of both amplifications against σ, a panel for every file.

    Of many files, or of one level only, all lie in one panel, a row each, at the widest level.
    """
    if len(files) > MOST_PANELS or all(len(f.read("sigma")) == 1 for f in files):
        _draw_rows(canvas, files)
        return
    axes = canvas.grid(len(files), 2, (6, 4.2), AMPLIFICATION, sharey=True)
    for file, panel, label in zip(files, axes, labels(files), strict=True):
        draw_kinds(panel, file, 100 * file.read("sigma"))
        panel.set(xlabel=SIGMA, title=f"{label}, {samples([file])}")


def samples(files: Sequence[ResultFile]) -> str:
    """Return how many samples are finished in the levels of files, in words."""
    return _in_words([values for file in files for values in of_levels(file, RATIOS[0][0])])


def _in_words(levels: Sequence[Any]) -> str:
    counts = sorted({len(values) for values in levels})
    return f"{counts[0]}–" * (len(counts) > 1) + counted(counts[-1], "sample")


def _draw_rows(canvas: Canvas, files: list[ResultFile]) -> None:
    """Draw a row for every file, of its widest level, and lines at the reference's percentiles."""
    axes = canvas.panels(1, 1, (10, 1.8 + 0.9 * len(files)))[0, 0]
    best = reference(files)
    names = [f"{label}\n({samples([f])})" for f, label in zip(files, labels(files), strict=True)]
    if len(files) > 1:
        row = files.index(best)
        names[row] = names[row].replace("(", "(lines; ")
        for name, look in RATIOS:
            at = best.config.convergence.percentiles
            for value in with_interval(of_levels(best, name)[-1], at)[0]:
                axes.axvline(value, color=look.colour, lw=0.8, alpha=0.6, zorder=0)
    draw_rows(axes, files, names)
    axes.set_title(f"Amplifications at ±{100 * best.read('half_range')[-1]:.3g} %")


def draw_rows(axes: Axes, files: Sequence[ResultFile], names: Sequence[str]) -> None:
    """Draw percentiles of both amplifications at the widest level of files, a row for each file."""
    for row, file in enumerate(files):
        at = file.config.convergence.percentiles
        explain(axes, [CONTACT, LINEAR._replace(style="-")], at)
        among = PERCENTILE_SHIFT * (np.arange(len(at)) - 0.5 * (len(at) - 1)) * 3 / max(3, len(at))
        for (name, look), beside in zip(RATIOS, (-ROW_SHIFT, ROW_SHIFT), strict=True):
            values, height = of_levels(file, name)[-1], row + beside + among
            if not len(values):
                continue
            interval = with_interval(values, at, shared_uncertainty(file, name))
            for p, value in enumerate(interval[0]):
                axes.plot(value, height[p], marker(p), color=look.colour, ms=7)
            intervals.draw(axes, height, interval, look.colour, sideways=True)
    axes.set_yticks(range(len(files)), names, fontsize=10)
    axes.set(ylim=(len(files) - 0.5, -0.5), xlabel=AMPLIFICATION)


def draw_disks(axes: Axes, found: list[contact_summary.Disk]) -> None:
    """Draw both amplifications of measured disks, a row each; the one in contact has intervals."""
    rows = np.array([disk.number for disk in found], dtype=float)
    contact, linear = np.transpose([(disk.amplification, disk.linear) for disk in found])
    ends = np.transpose([disk.interval for disk in found])
    intervals.draw(axes, rows - ROW_SHIFT, [contact, *ends], BLUE, sideways=True)
    axes.plot(contact, rows - ROW_SHIFT, "o", color=BLUE, ms=7, label=CONTACT.word)
    axes.plot(linear, rows + ROW_SHIFT, "s", color=ORANGE, ms=7, label=LINEAR.word)
    axes.set_yticks(rows, [f"disk {disk.number}" for disk in found])
    axes.set(ylim=(rows.max() + 0.5, rows.min() - 0.5), xlabel=AMPLIFICATION)


@figure("contact", paper="13", what="largest amplitudes over n_d", several=True, alone=False,
        needs="random")  # fmt: skip
def amplitudes(canvas: Canvas, files: list[ResultFile]) -> None:
    """Largest amplitudes of the tuned disk and percentile 99 of the samples, a place each file.

    The levels stand side by side.
    """
    quantity, names = _places(files)
    wide = max(len(line) for name in names for line in name.splitlines()) / ENTRY
    axes = canvas.panels(1, 1, (max(8.0, max(1.3, 0.4 + wide) * len(files)), 5.6))[0, 0]
    x = np.arange(len(files))
    tuned = np.array([1e3 * file.read("tuned/reference_amplitude_m") for file in files])
    runs = [1e3 * file.read("tuned/run_peaks_m") for file in files]
    spread = [tuned - [np.nanmin(r) for r in runs], [np.nanmax(r) for r in runs] - tuned]
    axes.errorbar(
        x, tuned, spread, fmt="s", color=BLACK, ms=7, elinewidth=1.2, capsize=3,
        label="tuned disk, range of its perturbed runs",
    )  # fmt: skip
    colours = level_colours(files)
    for i, file in enumerate(files):
        peaks = of_levels(file, "peak_amplitude_m")
        for sigma, values in zip(file.read("sigma"), peaks, strict=True):
            if not len(values):
                continue
            level, label = list(colours).index(sigma), f"percentile 99, σ = {100 * sigma:.1f} %"
            place, interval = i + 0.06 * (level + 1), with_interval(1e3 * values, [99])
            look: dict[str, Any] = {"color": colours[sigma], "label": label}
            axes.plot(place, interval[0], marker(level), ms=7, **look)
            intervals.draw(axes, place, interval, colours[sigma])
    axes.set_xticks(x, names)
    axes.set_xlim(-0.5, len(files) - 0.5)  # the places of a file's levels stay beside its name
    axes.set(ylabel=quantity, title=f"Largest of all speeds, {samples(files)} per level")
    axes.set_ylim(0, 1.12 * axes.get_ylim()[1])


def _places(files: list[ResultFile]) -> tuple[str, list[str]]:
    """Return the label of an axis of amplitudes, and a name for each file, in short lines."""
    casing = files[0].config.casing
    case = casing.words if casing.profile.exists else f"$n_d$ = {casing.n_bumps}"
    whole = labels(files) if len(files) > 1 else [case]
    names = [re.sub(r", (?![^\[]*\])", "\n", name) for name in whole]  # lists stay whole
    words = [layout.AMPLITUDES[layout.amplitude(file.config)] for file in files]
    if len(set(words)) == 1:
        return f"{words[0]},\nmax $|u_t|$ [mm]", names
    return "max $|u_t|$ [mm]", [f"{n}:\n{word}" for n, word in zip(names, words, strict=True)]


@figure("linear", paper="4", what="linear amplification over σ and n_d", main=True)
def linear(canvas: Canvas, file: ResultFile) -> None:
    """Percentiles of the linear amplification against σ, a panel for every load."""
    diameters, sigma = file.read("n_diameters"), 100 * file.read("sigma")
    axes = canvas.grid(len(diameters), 3, (4, 3.3), AMPLIFICATION, sharex=True, sharey=True)
    for d, panel in enumerate(axes):
        values = [finite(level) for level in file.read("amplification", (slice(None), d))]
        at = file.config.convergence.percentiles
        explain(panel, [LINEAR], at)
        draw_curves(panel, sigma, values, at, LINEAR)
        if file.config.aero.exists:
            limit = file.read("aero/largest_amplification", d)
            if np.isfinite(limit):
                panel.axhline(limit, label="limit (Whitehead)", **DOTTED)
        panel.set_title(f"$n_d$ = {diameters[d]}")
    canvas.figure.suptitle(f"Linear amplification, {_in_words(values)} per level")
    for panel in axes[-3:]:
        panel.set_xlabel(SIGMA)


@figure("contact", paper="10", what="running means of the percentiles", several=True, alone=False,
        needs="random")  # fmt: skip
def running_means(canvas: Canvas, files: list[ResultFile]) -> None:
    """Running means of the percentiles of A_nl: a row for every file, a column each percentile."""
    for panel in _draw(canvas, files, "mean_of_percentile", 1.0, 1)[:, 0]:
        panel.set_ylabel("mean of the\npercentile of $A_{nl}$ [-]")


@figure("contact", paper="11", what="convergence errors", several=True, alone=False, needs="random")
def convergence_errors(canvas: Canvas, files: list[ResultFile]) -> None:
    """Convergence errors, equation (6): a row for every file, a column for each percentile.

    They begin where convergence is judged, with the tenth estimate.
    """
    z = sorted({file.config.convergence.z for file in files})
    level = " and ".join(f"{100 * confidence(value):.1f} %" for value in z)
    axes = _draw(canvas, files, "convergence_error", 100.0, MIN_VALUES)
    for file, row in zip(files, axes, strict=True):
        for panel in row:
            panel.axhline(100 * file.config.convergence.target_error, label="target", **DOTTED)
            panel.set_yscale("log")
            panel.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            panel.yaxis.set_major_formatter("{x:g}")
            panel.yaxis.set_minor_formatter("")
        row[0].set_ylabel("convergence error\nof $A_{nl}$ [%]")
    canvas.figure.suptitle(f"Convergence error by equation (6) of the paper, for {level}")


def _draw(canvas: Canvas, files: list[ResultFile], name: str, scale: float, least: int) -> Any:
    """Draw a statistic of the contact amplifications over the samples seen; colours tell σ.

    least: number of the first estimate that is drawn.
    Raises InputError when fewer than two estimates would be drawn.
    """
    shown = sorted({p for file in files for p in file.config.convergence.percentiles})
    colours = level_colours(files)
    size = (max(6.0, 4.0 * len(shown)), 2.9 * len(files) + 1.0)
    axes = canvas.panels(len(files), len(shown), size, sharey="row", sharex="row")
    for file, row, label in zip(files, axes, labels(files), strict=True):
        at = list(file.config.convergence.percentiles)
        values = scale * file.read(layout.AMPLIFICATION.dataset(name))
        values[..., : least - 1] = np.nan
        seen = file.read(SEEN)
        _limit(row[0], file, seen[np.isfinite(values).any(axis=(0, 1))], least)
        values[values <= 0.0] = np.nan  # an error of 0, of equal estimates, has no logarithm
        for panel, percentile in zip(row, shown, strict=True):
            panel.set_title(f"{label}: percentile {percentile:g}", fontsize=11)
            if percentile not in at:
                panel.set_axis_off()
                continue
            for sigma, of_level in zip(file.read("sigma"), values, strict=True):
                line, colour = of_level[at.index(percentile)], colours[sigma]
                panel.plot(seen, line, color=colour, lw=1.6, label=f"σ = {100 * sigma:.1f} %")
            panel.set_xlabel("samples" if file is files[-1] else "")
    return axes


def _limit(axes: Axes, file: ResultFile, known: Any, least: int) -> None:
    """Set a logarithmic axis of samples, from the first to the last number with an estimate."""
    if len(known) < 2:
        step = file.config.convergence.step
        raise InputError(
            f"{file.path}: this figure needs at least {(least + 1) * step} finished samples of a "
            f"level, {least + 1} steps of convergence.step = {step}"
        )
    axes.set(xscale="log", xlim=(0.9 * known[0], 1.1 * known[-1]))
    many = len(known) >= MIN_VALUES
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)) if many else FixedLocator(known))
    axes.xaxis.set_major_formatter("{x:,.0f}")
    axes.xaxis.set_minor_formatter("")
