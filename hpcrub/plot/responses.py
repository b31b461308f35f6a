"""Frequency responses in contact: one study, and several that differ in a few keys."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from hpcrub.config.text import counted
from hpcrub.contact import status
from hpcrub.contact.status import DIVERGED, NOT_STEADY
from hpcrub.plot import intervals
from hpcrub.plot.amplifications import CONTACT, LINEAR, draw_curves, draw_disks, draw_row, samples
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.families import finished, labels, ordered, reference, uncertainty
from hpcrub.plot.style import BLACK, BLUE, COLOURS, ORANGE
from hpcrub.results.layout import DONE
from hpcrub.results.storage import ResultFile
from hpcrub.studies.contact import layout, measured, trust

MOST = 20_000  # samples of a level behind the band of a frequency response
MOST_LINES = 5  # responses of one panel besides the reference; more get a panel each
BESIDE = 0.01  # of the range of levels: both amplifications to either side
SPEED, AMPLITUDE = "speed of rotation [Hz]", "blade-tip amplitude [mm]"
LOCALISATION = "localisation factor [%]"


@figure("contact", paper="7", what="responses, amplifications", main=True)
def summary(canvas: Canvas) -> None:
    """Frequency responses of one study, and its amplifications.

    Of random samples: the tuned disk and the range of the samples of the widest level, then
    percentiles of both amplifications against the mistuning level. Of one explicit pattern:
    amplitude and localisation over the speeds.
    """
    file = canvas.file
    left, right = canvas.panels(1, 2, (13.5, 5.8))[0]
    if file.config.pattern_deviation is None:
        if measured.are_few(file) and len(file.config.samples) <= MOST_LINES:
            for disk, colour in zip(measured.disks(file), COLOURS, strict=False):
                draw_response(left, file, "samples", disk.where, colour, f"disk {disk.number}")
        else:
            draw_range(left, file)
        draw_response(left, file, "tuned", (), BLACK, "tuned disk")
        _draw_amplifications(right, canvas)
        for line in trust.short(file):
            canvas.note(line)
    else:
        _draw_pattern(left, file, layout.amplitude(file.config), 1e3)
        _draw_pattern(right, file, "localisation", 100)
        right.set(ylabel=LOCALISATION, title="Localisation of the blade-tip amplitudes")
    word = "largest amplitude of any time [mm]"
    left.set(
        ylabel=word if file.config.contact.wears else AMPLITUDE,
        title=f"Response in contact, {file.config.casing.words}",
    )
    canvas.legend_of(left)
    canvas.legend_of(right, drop=42 if right.get_ylabel() == LOCALISATION else 58)


def draw_response(
    axes: Axes, file: ResultFile, group: str, where: Any, colour: Any, label: str | None,
    name: str | None = None, scale: float = 1e3, **how: Any,
) -> None:  # fmt: skip
    """One disk over the speeds, by default its amplitudes; points that were not steady are hollow.

    On a coating amplitudes are the largest of any time, and hollow points had not ended.
    """
    name = name or layout.amplitude(file.config)
    speeds, values = file.read("speeds_hz"), scale * file.read(f"{group}/{name}", where)
    line = {"lw": 1.6, "zorder": 3, **how}
    if name == "amplitude_m":
        wide = np.nan_to_num(scale * file.read(f"{group}/amplitude_scatter_m", where))
        axes.fill_between(speeds, values - wide, values + wide, color=colour, alpha=0.15, lw=0)
    (drawn,) = axes.plot(speeds, values, color=colour, marker=".", ms=5, label=label, **line)
    axes.update_datalim([(speeds[0], 0.0)])
    drawn.sticky_edges.y.append(0.0)  # the axis begins at zero and ends above all that follows
    unsteady = file.read(f"{group}/point_status", where) == NOT_STEADY
    if unsteady.any():
        axes.plot(
            speeds[unsteady], values[unsteady], "o", mfc="w", mec=colour, ms=5, zorder=4,
            label=label and f"{label}, not steady",
        )  # fmt: skip
    _draw_lost(axes, file, group, where, colour, label)
    axes.autoscale_view()
    axes.set_xlabel(SPEED)
    axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))


def _draw_lost(
    axes: Axes, file: ResultFile, group: str, where: Any, colour: Any, label: str | None
) -> None:
    """Crosses at the speeds without a result, with the reasons in words."""
    lost = file.read(f"{group}/point_status", where) == DIVERGED
    if not lost.any():
        return
    speeds, reasons = file.read("speeds_hz"), file.read(f"{group}/point_reason", where)
    for n, code in enumerate(np.unique(reasons[lost])):
        at = speeds[lost & (reasons == code)]
        axes.plot(
            at, np.zeros(len(at)), "xP*d"[n % 4], color=colour, ms=7, clip_on=False, zorder=5,
            label=label and f"{label}: {status.words(code)}",
        )  # fmt: skip


def _draw_pattern(axes: Axes, file: ResultFile, name: str, scale: float) -> None:
    draw_response(axes, file, "samples", (0, 0), BLUE, "mistuned disk", name, scale)
    draw_response(axes, file, "tuned", (), BLACK, "tuned disk", name, scale)


def draw_range(axes: Axes, file: ResultFile, name: str | None = None) -> None:
    """Range of the amplitudes of the widest level's samples at every speed, and their median.

    The band reaches from the lowest to the highest percentile of the input; with so few samples
    that one of these lies beyond them, from the smallest to the largest sample. name: other values
    in metres than the amplitudes.
    """
    done = file.status()[-1, :MOST] == DONE
    name = name or layout.amplitude(file.config)
    amplitude = 1e3 * file.read(f"samples/{name}", (-1, slice(MOST)))[done]
    speeds, percentiles = file.read("speeds_hz"), file.config.convergence.percentiles
    known = np.isfinite(amplitude).any(axis=0)
    if not known.any():
        return
    n, low, high = len(amplitude), percentiles[0], percentiles[-1]
    few = n * min(low, 100 - high) < 100
    ends = [0, 50, 100] if few else [low, 50, high]
    band = np.nanpercentile(amplitude[:, known], ends, axis=0)
    words = f"range of {counted(n, 'sample')}" if few else f"percentiles {low:g} to {high:g}"
    level = f"±{100 * file.read('half_range')[-1]:.3g} %"
    axes.fill_between(
        speeds[known], band[0], band[2], color=BLUE, alpha=0.25, lw=0, label=f"{level}, {words}"
    )
    axes.plot(speeds[known], band[1], color=BLUE, lw=1.6, label=f"{level}, median")


def _draw_amplifications(axes: Axes, canvas: Canvas) -> None:
    """Both amplifications: percentiles against the level, in a row when there is one level alone.

    Of a few measured disks each has a row, as their percentiles say nothing.
    """
    file, open_end = canvas.file, False
    half_range, sigma = 100 * file.read("half_range"), 100 * file.read("sigma")
    names = [f"±{h:.3g} %\nσ = {s:.2g} %" for h, s in zip(half_range, sigma, strict=True)]
    disks = list(measured.disks(file)) if measured.are_few(file) else []
    axes.set_title(f"Amplification, {samples(file)} per level")
    if len(names) > 1:
        axes.axhline(1.0, color="0.6", lw=1)
        open_end = _draw_levels(axes, file, half_range)
        axes.set(xlabel="mistuning: largest deviation of a blade's stiffness, and σ")
        axes.set(ylabel="amplification [-]")
        axes.set_xticks(half_range, names)
        axes.margins(x=0.08, y=0.12)
    else:
        axes.axvline(1.0, color="0.6", lw=1)
        axes.set_xlabel("amplification [-]")
        if disks:
            draw_disks(axes, disks)
            axes.set_title("Amplification of measured disks")
        else:
            open_end = draw_row(axes, 0.0, file)
            axes.set_yticks([0.0], names)
            axes.set_ylim(0.5, -0.5)
    for handle in intervals.handles(open_end):
        axes.add_line(handle)


def _draw_levels(axes: Axes, file: ResultFile, half_range: Any) -> bool:
    """Percentiles of both amplifications at every level (V,) [%]; whether an interval is open."""
    at, open_end = file.config.convergence.percentiles, False
    for (name, word, colour, style), side in zip((CONTACT, LINEAR), (-1, 1), strict=True):
        values, shared = finished(file, name), uncertainty(file, name)
        beside = half_range + side * BESIDE * np.ptp(half_range)  # their intervals hide no other
        open_end |= draw_curves(
            axes, beside, values, at, [colour], style, f"{word}, ", shared, from_one=False
        )
    return open_end


@figure("contact", paper="8, 9", what="responses, differences to the reference", several=True,
        alone=False)  # fmt: skip
def family(canvas: Canvas) -> None:
    """Frequency responses of several studies.

    Up to six that share their speeds lie in one panel, with the differences to a reference below,
    beside what these differ by from run to run at every speed, of both disks together. More of
    them, or such as have other speeds, get a panel each, with the reference in black where it has
    the same speeds.

    The reference is the finest of time steps and reduced models, otherwise the study with the
    default values.
    """
    files = ordered(canvas.files)
    best = reference(files)
    alike = all(np.array_equal(f.read("speeds_hz"), best.read("speeds_hz")) for f in files)
    if alike and 1 < len(files) <= MOST_LINES + 1:
        _draw_together(canvas, files, best)
    else:
        _draw_apart(canvas, files, best)


def _disks(file: ResultFile) -> list[tuple[str, str, Any]]:
    """Title, group and place of the responses of a file."""
    disks: list[tuple[str, str, Any]] = [("tuned disk", "tuned", ())]
    if file.config.pattern_deviation is not None:
        disks.append(("mistuned disk", "samples", (0, 0)))
    return disks


def _draw_together(canvas: Canvas, files: list[ResultFile], best: ResultFile) -> None:
    disks = _disks(best)
    n = len(disks)
    axes = canvas.panels(2, n, (1.5 + 5.5 * n, 8), sharex=True, sharey="row", height_ratios=(3, 2))
    noise = np.zeros((n, len(best.read("speeds_hz"))))
    colours = iter(COLOURS)
    of_best = [_scatter(best, group) for _, group, _ in disks]
    for file, label in zip(files, labels(files), strict=True):
        first = file is best
        colour = BLACK if first else next(colours)
        for (title, group, where), top, bottom in zip(disks, *axes, strict=True):
            name = f"{label} (reference)" if first else label
            draw_response(
                top, file, group, where, colour, name, zorder=4 if first else 3,
                lw=2.2 if first else 1.3,
            )  # fmt: skip
            top.set(title=title, xlabel="")
            if not first:
                values, wanted = (
                    f.read(f"{group}/{layout.amplitude(f.config)}", where) for f in (file, best)
                )
                disk = [g for _, g, _ in disks].index(group)
                noise[disk] = np.fmax(
                    noise[disk], 2e3 * np.hypot(of_best[disk], _scatter(file, group))
                )
                bottom.plot(
                    file.read("speeds_hz"), 1e3 * (values - wanted), color=colour, lw=1.3,
                    marker=".", ms=5,
                )  # fmt: skip
    for bottom, wide in zip(axes[1], noise, strict=True):
        bottom.fill_between(best.read("speeds_hz"), -wide, wide, color="0.85", lw=0, zorder=0)
        bottom.axhline(0.0, color=BLACK, lw=1.2)
        bottom.set_xlabel(SPEED)
    axes[0, 0].set_ylabel(AMPLITUDE)
    axes[1, 0].set_ylabel("difference to\nthe reference [mm]")
    hollow = Line2D([], [], marker="o", mfc="w", mec=BLACK, ls="", label="not steady")
    grey = Patch(color="0.85", label="twice the scatter of both disks from run to run")
    lines = axes[0, -1].get_legend_handles_labels()[0]
    kept = [line for line in lines if "not steady" not in str(line.get_label())]
    canvas.legend([*kept, hollow, grey])


def _scatter(file: ResultFile, group: str) -> Any:
    """By how much an amplitude differs from run to run of the same disk, at every speed (S,) [m].

    The standard deviation of the perturbed runs, three at least; with fewer the standard error by
    the windows of the one, which other motions at the same speed are not in.
    """
    n_speeds = len(file.read("speeds_hz"))
    name = f"{group}/{'run_amplitude_m' if group == 'tuned' else 'amplitude_m'}"
    runs = file.read(name).reshape(-1, n_speeds)
    if len(runs) > 2:
        return np.nan_to_num(runs.std(axis=0, ddof=1))
    return np.nan_to_num(file.read(f"{group}/amplitude_error_m").reshape(-1, n_speeds)[0])


def _draw_apart(canvas: Canvas, files: list[ResultFile], best: ResultFile) -> None:
    columns = min(len(files), 2 if len(files) <= 4 else 4)
    size = (6.0, 4.2) if columns <= 2 else (4.0, 3.4)
    axes = canvas.grid(len(files), columns, size, sharey=True)
    for file, panel, label in zip(files, axes, labels(files), strict=True):
        panel.set_title(label, fontsize=11 if columns > 2 else None)
        if file.config.pattern_deviation is None:
            draw_range(panel, file)
        else:
            draw_response(panel, file, "samples", (0, 0), BLUE, "mistuned disk")
        if file is not best and np.array_equal(best.read("speeds_hz"), file.read("speeds_hz")):
            draw_response(panel, best, "tuned", (), BLACK, "tuned disk, reference", lw=1.0)
            draw_response(panel, file, "tuned", (), ORANGE, "tuned disk")
        else:
            draw_response(panel, file, "tuned", (), BLACK, "tuned disk")
        panel.set_xlabel(SPEED if panel in axes[-columns:] else "")
    for panel in axes[::columns]:
        panel.set_ylabel(AMPLITUDE)
    canvas.legend_of_all(axes)
