"""Frequency responses in contact: one study, and several that differ in a few keys."""

import itertools
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from hpcrub.config.text import counted
from hpcrub.contact import status
from hpcrub.contact.status import DIVERGED, NOT_STEADY
from hpcrub.plot.amplifications import AMPLIFICATION, draw_disks, draw_kinds, draw_rows, samples
from hpcrub.plot.canvas import Canvas, figure
from hpcrub.plot.families import labels, lost_disks, reference
from hpcrub.plot.style import BLACK, BLUE, COLOURS, DOTTED, ORANGE
from hpcrub.results.layout import DONE
from hpcrub.results.storage import ResultFile
from hpcrub.studies.contact import findings, layout
from hpcrub.studies.contact import summary as contact_summary
from hpcrub.studies.contact.survey import unstable_peak

SCATTER = "± standard deviation of the windows"
MOST_LINES = 5  # responses in one panel besides the reference; of more, each gets a panel
SPEED = "speed of rotation [Hz]"
GREY = "0.4"  # in legends, of symbols that disks of all colours have
LOST = "x4P123xXx*xd"  # symbols of the reasons of ``status``, one for each that ends a point


@figure("contact", paper="7", what="responses, amplifications", main=True)
def summary(canvas: Canvas, file: ResultFile) -> None:
    """Frequency responses of one study, and its amplifications.

    Of random samples: the tuned disk and the range of the samples of the widest level, then
    percentiles of both amplifications against the mistuning level. Of one explicit pattern:
    amplitude and localisation over the speeds.
    """
    left, right = canvas.panels(1, 2, (13.5, 5.8))[0]
    if file.config.pattern_deviation is None:
        disks = list(contact_summary.disks(file)) if contact_summary.are_few(file) else []
        if 0 < len(disks) <= MOST_LINES:
            for disk, colour in zip(disks, COLOURS, strict=False):
                draw_response(left, file, "samples", disk.where, colour, f"disk {disk.number}")
            draw_response(left, file, "tuned", (), BLACK, "tuned disk")
        else:
            draw_all(left, file)
        _draw_amplifications(right, file, disks)
    else:
        draw_all(left, file)
        draw_all(right, file, "localisation", 100)
        right.set(ylabel="localisation factor [%]", title="Localisation of the amplitudes")
    left.set(ylabel=size(file), title=f"Response in contact, {file.config.casing.words}")
    canvas.note(*findings.verdict(file).lines[:2])  # and the weightiest finding


def size(file: ResultFile, name: str | None = None) -> str:
    """Return the label of an axis of amplitudes; by default of a file's peak amplitudes."""
    return f"{layout.AMPLITUDES[name or layout.amplitude(file.config)]},\nmax $|u_t|$ [mm]"


def draw_response(
    axes: Axes, file: ResultFile, group: str, where: Any, colour: Any, label: str | None,
    name: str | None = None, scale: float = 1e3, **how: Any,
) -> None:  # fmt: skip
    """Draw one disk over the speeds, by default its amplitudes; hollow points were not steady.

    Hollow triangles are points at which a wave still grows.
    On a coating amplitudes are the largest at any time, and at hollow points wear had not ended.
    Symbols at zero are speeds without a result, one for each reason.
    """
    name = name or layout.amplitude(file.config)
    speeds, values = file.read("speeds_hz"), scale * file.read(f"{group}/{name}", where)
    line: dict[str, Any] = {"lw": 1.6, "zorder": 3, **how}
    if name == "amplitude_m":
        wide = np.nan_to_num(scale * file.read(f"{group}/amplitude_scatter_m", where))
        axes.fill_between(speeds, values - wide, values + wide, color=colour, alpha=0.15, lw=0)
        if wide.any():
            axes.fill_between([], [], color="0.5", alpha=0.3, lw=0, label=SCATTER)
    (drawn,) = axes.plot(speeds, values, color=colour, marker=".", ms=5, label=label, **line)
    axes.update_datalim([(speeds[0], 0.0)])
    drawn.sticky_edges.y.append(0.0)  # the axis begins at zero and ends above what is drawn later
    point_status = file.read(f"{group}/point_status", where)
    unsteady, lost = point_status == NOT_STEADY, point_status == DIVERGED
    reasons = file.read(f"{group}/point_reason", where)
    for symbol, words, there in (
        ("o", "not steady", unsteady & (reasons != status.GROWING)),
        ("^", "still growing", unsteady & (reasons == status.GROWING)),
    ):
        _draw_symbol(axes, speeds[there], values[there], symbol, colour, words, mfc="w", ms=5)
    size = 7 if colour == BLACK else 10  # of two at the same speed both are seen
    for code in np.unique(reasons[lost]):
        at, symbol = speeds[lost & (reasons == code)], LOST[code % len(LOST)]
        _draw_symbol(axes, at, 0 * at, symbol, colour, status.words(code), mfc=colour, ms=size)
    axes.autoscale_view()
    axes.set_xlabel(SPEED)
    axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))


def _draw_symbol(
    axes: Axes, x: Any, y: Any, symbol: Any, colour: str, label: str, **look: Any
) -> None:
    """Draw symbols in the colour of a disk; the legend has one of all disks, in grey."""
    if len(x):
        axes.plot(x, y, symbol, mec=colour, clip_on=False, zorder=5, **look)
        grey: dict[str, Any] = {"ms": 7, "mec": GREY, "mfc": "w" if look["mfc"] == "w" else GREY}
        axes.plot([], [], symbol, label=label, **grey)


def draw_all(axes: Axes, file: ResultFile, name: str | None = None, scale: float = 1e3) -> None:
    """Draw the tuned disk, and the random samples or the disk of a pattern, by `draw_response`."""
    draw_samples(axes, file, name, scale)
    draw_response(axes, file, "tuned", (), BLACK, "tuned disk", name, scale)
    if np.isfinite(unstable_peak(file)) and name in (None, "amplitude_m"):
        equal = 1e3 * file.read("tuned/symmetric_amplitude_m")
        words = "equal blades: does not stay"
        axes.plot(file.read("speeds_hz"), equal, label=words, zorder=4, **DOTTED)


def draw_samples(axes: Axes, file: ResultFile, name: str | None = None, scale: float = 1e3) -> None:
    """Draw the disk of a pattern; else the range of the widest level's samples, and their median.

    The band reaches from the lowest to the highest percentile of the input. If there are too few
    samples for one of these, it reaches from the smallest to the largest sample. Crosses are speeds
    at which some of them have no result, and are not in the band. name: dataset of other values
    than the amplitudes, which are drawn times `scale`.
    """
    if file.config.pattern_deviation is not None:
        draw_response(axes, file, "samples", (0, 0), BLUE, "mistuned disk", name, scale)
        return
    lost = (file.read("samples/point_status", -1) == DIVERGED).any(axis=0)
    name = name or layout.amplitude(file.config)
    amplitude = scale * file.read(f"samples/{name}", -1)[file.status[-1] == DONE]
    speeds, percentiles = file.read("speeds_hz"), file.config.convergence.percentiles
    known = np.isfinite(amplitude).any(axis=0)
    level = f"±{100 * file.read('half_range')[-1]:.3g} %"
    if lost.any():
        look: dict[str, Any] = {"color": BLUE, "ls": "", "ms": 10, "clip_on": False, "zorder": 5}
        axes.plot(speeds[lost], 0 * speeds[lost], marker="x", label=f"{level}, lost disks", **look)
    if not known.any():
        return
    n, low, high = len(amplitude), percentiles[0], percentiles[-1]
    few = n * min(low, 100 - high) < 100
    ends = [0, 50, 100] if few else [low, 50, high]
    band = np.full((3, len(speeds)), np.nan)
    band[:, known] = np.nanpercentile(amplitude[:, known], ends, axis=0)
    words = f"range of {counted(n, 'sample')}" if few else f"percentiles {low:g} to {high:g}"
    look = {"color": BLUE, "alpha": 0.25, "lw": 0, "label": f"{level}, {words}"}
    axes.fill_between(speeds, band[0], band[2], **look)
    axes.plot(speeds, band[1], ".-", ms=3, color=BLUE, lw=1.6, label=f"{level}, median")


def _draw_amplifications(axes: Axes, file: ResultFile, disks: list[contact_summary.Disk]) -> None:
    """Draw percentiles of both amplifications against the level, or in a row for a single level.

    Each of a few measured disks has a row, because percentiles of a few disks say nothing.
    """
    half_range, sigma = 100 * file.read("half_range"), 100 * file.read("sigma")
    names = [f"±{h:.3g} %\nσ = {s:.2g} %" for h, s in zip(half_range, sigma, strict=True)]
    axes.set_title(f"Amplification, {samples([file])} per level")
    if len(names) > 1:
        axes.axhline(1.0, color="0.6", lw=1)
        draw_kinds(axes, file, half_range, from_one=False)
        axes.set(xlabel="mistuning: largest deviation of a blade's stiffness, and σ")
        axes.set(ylabel=AMPLIFICATION)
        axes.set_xticks(half_range, names)
        axes.margins(x=0.08, y=0.12)
        return
    axes.axvline(1.0, color="0.6", lw=1)
    if disks:
        draw_disks(axes, disks)
        axes.set_title("Amplification of measured disks")
    else:
        draw_rows(axes, [file], names)


@figure("contact", paper="8, 9", what="responses, differences to the reference", several=True,
        alone=False)  # fmt: skip
def compare(canvas: Canvas, files: list[ResultFile]) -> None:
    """Frequency responses of several studies.

    Up to six that share their speeds lie in one panel, with the differences to a reference below,
    beside what these differ by from run to run at every speed, of both disks together. More of
    them, or such as have other speeds, get a panel each, with the reference in black where it has
    the same speeds.

    The reference is the finest of time steps and reduced models, otherwise the study with the
    default values. Where only some have a coating that wears, steady amplitudes are compared with
    each other, and the largest amplitudes at any time of the coated ones stand beside them.
    """
    canvas.note(*lost_disks(files))
    best = reference(files)
    alike = all(np.array_equal(f.read("speeds_hz"), best.read("speeds_hz")) for f in files)
    if alike and 1 < len(files) <= MOST_LINES + 1:
        _draw_together(canvas, files, best)
    else:
        _draw_apart(canvas, files, best)


def _draw_together(canvas: Canvas, files: list[ResultFile], best: ResultFile) -> None:
    disks: list[tuple[str, str, Any]] = [("tuned disk", "tuned", ())]
    if best.config.pattern_deviation is not None:
        disks.append(("mistuned disk", "samples", (0, 0)))
    used = {layout.amplitude(file.config) for file in files}
    names = [name for name in layout.AMPLITUDES if name in used]
    n = len(disks) * len(names)
    how: dict[str, Any] = {"sharey": "row" if len(names) == 1 else "none", "height_ratios": (3, 2)}
    axes = canvas.panels(2, n, (1.5 + 5.5 * n, 8), sharex=True, **how)
    columns = itertools.product(names, disks)
    words = dict(zip(files, labels(files), strict=True))
    colours = dict(zip([f for f in files if f is not best], COLOURS, strict=False)) | {best: BLACK}
    for (name, (title, group, where)), top, bottom in zip(columns, *axes, strict=True):
        shown = [f for f in files if name == "amplitude_m" or f.config.contact.wears]
        for file in shown:
            look = {"lw": 2.2, "zorder": 4} if file is best else {"lw": 1.3}
            is_named = file is best and words[file] != "reference"
            label = f"{words[file]} (reference)" if is_named else words[file]
            draw_response(top, file, group, where, colours[file], label, name, **look)
        top.set(title=title, xlabel="", ylabel=size(best, name))
        bottom.set(xlabel=SPEED, ylabel="difference to\nthe reference [mm]")
        others = {file: colours[file] for file in shown if file is not best}
        if best in shown and others:
            _draw_differences(bottom, best, others, f"{group}/{name}", where)
        else:
            bottom.set_axis_off()
            top.tick_params(labelbottom=True)
            top.set_xlabel(SPEED)


def _draw_differences(
    axes: Axes, best: ResultFile, others: dict[ResultFile, Any], name: str, where: Any
) -> None:
    """Draw the amplitudes of other files, each in its colour, less those of the reference."""
    speeds = best.read("speeds_hz")
    for file, colour in others.items():
        values = 1e3 * (file.read(name, where) - best.read(name, where))
        axes.plot(speeds, values, color=colour, lw=1.3, marker=".", ms=5)
    wide = 2e3 * np.max([np.hypot(_scatter(best, name), _scatter(f, name)) for f in others], axis=0)
    if np.isfinite(wide).any():
        axes.fill_between(
            speeds, -wide, wide, fc="none", ec="0.65", hatch="////", lw=0, zorder=0,
            label="twice the scatter of both disks from run to run",
        )  # fmt: skip
    else:
        axes.set_title("what another run would change is not known", fontsize="small", color="0.3")
    axes.axhline(0.0, color=BLACK, lw=1.2)


def _scatter(file: ResultFile, name: str) -> Any:
    """Return the scatter of an amplitude from run to run of one disk (S,) [m], NaN if not known.

    It is the standard deviation of three or more perturbed runs. With fewer runs it is the standard
    error by the windows of one run, which leaves out other motions at the same speed.
    """
    n_speeds = len(file.read("speeds_hz"))
    group, _, kind = name.partition("/")
    if kind != "amplitude_m":
        return np.full(n_speeds, np.nan)
    runs = file.read("tuned/run_amplitude_m" if group == "tuned" else name).reshape(-1, n_speeds)
    if len(runs) > 2:
        return runs.std(axis=0, ddof=1)
    return file.read(f"{group}/amplitude_error_m").reshape(-1, n_speeds)[0]


def _draw_apart(canvas: Canvas, files: list[ResultFile], best: ResultFile) -> None:
    columns = min(len(files), 2 if len(files) <= 4 else 3)
    same = len({size(file) for file in files}) == 1  # whether all files have the same quantity
    axes = canvas.grid(len(files), columns, (5.4, 4.0), sharey=same)
    for file, panel, label in zip(files, axes, labels(files), strict=True):
        panel.set_title(label, fontsize=11)
        draw_samples(panel, file)
        alike = same and np.array_equal(best.read("speeds_hz"), file.read("speeds_hz"))
        beside = alike and file is not best
        if beside:
            draw_response(panel, best, "tuned", (), BLACK, "tuned disk, reference", lw=1.0)
        draw_response(panel, file, "tuned", (), ORANGE if beside else BLACK, "tuned disk")
        panel.set(xlabel=SPEED if panel in axes[-columns:] else "", ylabel=size(file))
