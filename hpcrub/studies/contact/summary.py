"""Results of a contact study as tables and lines for a terminal or a log.

Measured disks and explicit patterns have a line each: percentiles of a few disks say nothing.
"""

from collections.abc import Iterator, Sequence
from itertools import groupby
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from rich.table import Table

from hpcrub import effects
from hpcrub.contact import status as point_status
from hpcrub.contact.status import AVERAGED, DIVERGED, NOT_STEADY
from hpcrub.effects.effect import Kind
from hpcrub.ranks import progress
from hpcrub.results import samples
from hpcrub.results.layout import DONE, FAILED
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import (
    Z_95,
    confidence,
    interval_in_words,
    widened,
    with_interval,
)
from hpcrub.studies.contact import limits, survey
from hpcrub.studies.contact.layout import AMPLIFICATION, STEADY, amplitude, is_untouched, kinds

NAMES = "amplification", "linear_amplification", "peak_amplitude_m", "peak_speed_hz"
MOST_DISKS = 24  # most measured disks with a line each; for more disks there are percentiles
# factor, unit and digits in tables, by the unit in the file
SHOWN = {"1": (1.0, "", ".3f"), "m": (1e3, "mm", ".4g"), "Pa": (1e-6, "MPa", ".4g")}


def answer(file: ResultFile, usable: bool) -> Iterator[str | Table]:
    """Tables and lines about the finished samples, of which there must be some.

    usable: whether the verdict calls percentiles usable.
    """
    if is_untouched(file):
        return
    counts = survey.survey(file)
    if file.config.pattern_deviation is not None or are_few(file):
        yield disk_table(file)
    else:
        yield level_table(file, counts)
        for _, alike in groupby(kinds(file.config), attrgetter("units")):
            yield interval_table(file, list(alike))
    yield tuned_line(file)
    yield from limits.largest_line(file, counts)
    yield from effects.lines(file)
    is_one = file.config.pattern_deviation is not None
    yield from (limits.limit_lines if is_one else limits.chance_table)(file, usable)
    yield from point_lines(counts)


def tuned_line(file: ResultFile) -> str:
    """Peak of the tuned disk, to which all amplifications are relative."""
    peak, runs = file.read("tuned/peak_amplitude_m"), np.sort(file.read("tuned/run_peaks_m"))
    speed = float(file.read("tuned/peak_speed_hz"))
    text = f"tuned disk: {peak * 1e3:.2f} mm at {speed:.2f} Hz"
    best = int(np.abs(file.read("speeds_hz") - speed).argmin())
    half = 1e3 * file.read("tuned/half_peak_to_peak_m")[best]
    if np.isfinite(half):
        text += f" (offset included; half of peak to peak {half:.2f} mm)"
    if np.isfinite(runs).all() and runs[-1] / runs[0] - 1.0 >= 1e-3:
        text += (
            f"; median {file.read('tuned/reference_amplitude_m') * 1e3:.2f} mm of {len(runs)} "
            f"runs ({runs[0] * 1e3:.2f} to {runs[-1] * 1e3:.2f} mm)"
        )
    equal = 1e3 * survey.unstable_peak(file)
    return text + (f"; the symmetric motion, {equal:.2f} mm, does not stay" if equal > 0.0 else "")


def level_table(file: ResultFile, found: survey.Survey) -> Table:
    """One row per mistuning level: how many samples there are, and how far to trust them."""
    headings = "level", "sigma", "samples", "error", "not\nsteady", "diverged"
    table = progress.table("Samples, convergence error of A_nl, points", headings)
    status = file.status[:, : samples.n_counted(file)]
    half_range, sigma = file.read("half_range"), file.read("sigma")
    for level in range(len(half_range)):
        n_done, n_failed = (np.count_nonzero(status[level] == s) for s in (DONE, FAILED))
        points = found.points[level]
        not_steady, diverged = points[[NOT_STEADY, DIVERGED]] / max(1, points[1:].sum())
        error = file.read(AMPLIFICATION.dataset("convergence_error"), level)  # (P, K)
        known = np.flatnonzero(np.isfinite(error).all(axis=0))
        table.add_row(
            f"±{100 * half_range[level]:.3g} %",
            f"{100 * sigma[level]:.2f} %",
            f"{n_done}" + (f" (+{n_failed} failed)" if n_failed else ""),
            f"{100 * error[:, known[-1]].max():.2f} %" if len(known) else "-",
            f"{100 * not_steady:.2f} %",
            f"{100 * diverged:.2f} %",
        )
    return table


def interval_table(file: ResultFile, alike: Sequence[Kind]) -> Table:
    """One row per level and percentile: kinds of numbers of one unit, with their intervals."""
    factor, unit, form = SHOWN.get(alike[0].units, (1.0, alike[0].units, ".4g"))
    words = " and ".join(kind.words for kind in alike)
    at, share = file.config.convergence.percentiles, f"{100 * confidence(Z_95):.4g} %"
    title = f"Percentiles of {words}, and their intervals ({share})" + f" [{unit}]" * bool(unit)
    names = (kind.symbol or kind.name.replace("_", " ") for kind in alike)
    headings = (word for name in names for word in (name, "interval"))
    table = progress.table(title, ("level", "percentile", *headings))
    for level, half_range in enumerate(file.read("half_range")):
        columns = []
        for kind in alike:
            values = factor * samples.finished(file, level, kind.of)
            columns.append(with_interval(values, at, survey.shared_uncertainty(file, kind.of)).T)
        for percentile, *found in zip(at, *columns, strict=True):
            parts = (part for value, *ends in found for part in ([value], ends))
            cells = (interval_in_words(*part, form=form) for part in parts)
            table.add_row(f"±{100 * half_range:.3g} %", f"{percentile:g}", *cells)
    return table


class Disk(NamedTuple):
    """Results of one measured disk."""

    number: int  # row of the file of measured disks, from 1
    where: tuple[int, int]  # place in the result file
    amplification: float  # in contact [-]
    interval: np.ndarray  # its 95 % interval by the windows of the peak and the tuned runs
    linear: float  # linear amplification [-]
    peak: float  # largest amplitude [m]
    speed_hz: float  # speed of the peak
    localisation: float  # factor at the peak [-]
    not_steady: float  # share of the points that are not steady
    diverged: float  # share of the points that have diverged


def point_lines(found: survey.Survey) -> Iterator[str]:
    """Numbers of points by the reason why they have no result, and sweeps of the force solver."""
    yield from point_status.lines(found.reasons, found.n_points)
    yield f"contact forces: at most {found.sweeps} sweeps of the solver in a step"


def are_few(file: ResultFile) -> bool:
    """Whether the samples of a file are so few measured disks that each has its own line."""
    config = file.config
    return config.mistuning.pattern_file is not None and len(config.samples) <= MOST_DISKS


def disks(file: ResultFile) -> Iterator[Disk]:
    """All measured disks of a file that have a result."""
    shared, status = survey.shared_uncertainty(file), file.status[0]
    for i in np.flatnonzero(status == DONE):
        where = 0, int(i)
        value, linear, peak, speed = (float(file.read(f"samples/{n}", where)) for n in NAMES)
        states, local = (file.read(f"samples/{n}", where) for n in ("point_status", "localisation"))
        best = int(np.argmin(np.abs(file.read("speeds_hz") - speed)))
        known = states[best] == AVERAGED and amplitude(file.config) == STEADY
        error = float(file.read("samples/amplitude_error_m", where)[best]) if known else 0.0
        middle, reach = np.array(value), Z_95 * error / peak * value
        interval = np.array(widened(middle, middle - reach, middle + reach, shared))
        shares = (float(np.mean(states == s)) for s in (NOT_STEADY, DIVERGED))
        number = file.config.samples[i] + 1
        yield Disk(number, where, value, interval, linear, peak, speed, float(local[best]), *shares)


def disk_table(file: ResultFile) -> Table:
    """A row for each disk."""
    rows = progress.table(
        f"Single disks, {100 * confidence(Z_95):.4g} % intervals, localisation at the peak",
        ("disk", "A_nl", "interval", "A_lin", "[mm]", "[Hz]", "LF", "not\nsteady", "diverged"),
    )
    for disk in disks(file):
        rows.add_row(
            f"{disk.number}",
            f"{disk.amplification:.3f}",
            "{:.3f} to {:.3f}".format(*disk.interval),
            f"{disk.linear:.3f}",
            f"{1e3 * disk.peak:.2f}",
            f"{disk.speed_hz:.2f}",
            f"{100 * disk.localisation:.1f} %",
            f"{100 * disk.not_steady:.0f} %",
            f"{100 * disk.diverged:.0f} %",
        )
    return rows
