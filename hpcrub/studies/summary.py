"""What a contact study has found, as tables and lines for a terminal or a log."""

from collections.abc import Iterator
from math import nan
from typing import Any

import numpy as np
from rich import box
from rich.table import Table

from hpcrub.contact import status as point_status
from hpcrub.contact.status import DIVERGED, NOT_STEADY
from hpcrub.ranks.progress import WIDTH, console, duration, print_line
from hpcrub.results.layout import DONE, FAILED
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import Z_95, confidence, percentile_interval

ROWS = 1000  # samples read at once


def print_summary(file: ResultFile, study: Any, seconds: float) -> None:
    """Print what a finished or interrupted study has found.

    Parameters
    ----------
    file
        Its result file.
    study
        The `contact.MonteCarlo` of rank 0.
    seconds
        Wall time of this run [s].
    """
    out = console()
    if file.config.pattern_deviation is not None:
        out.print(pattern_table(file))
    else:
        table = level_table(file)
        fits = out.measure(table, options=out.options.update(width=WIDTH)).maximum <= out.width
        out.print(table if fits else level_table(file, narrow=True))
        if len(file.config.samples) > 1:
            out.print(interval_table(file))
    print_line(out, tuned_line(file))
    for line in point_lines(file):
        print_line(out, line)
    text = f"wall time {duration(seconds)} on {study.team.size} rank{'s'[: study.team.size > 1]}"
    if study.work.seconds > 0.0:
        rate = study.work.n_steps / study.work.seconds
        text += f", {rate / 1e6:.3g} million steps per second and core"
    out.print(text)


def n_counted(file: ResultFile) -> int:
    """Number of samples of each level that the tables are about.

    All; of a study that stops when it has converged, those up to where it did: how many more there
    are depends on the number of ranks.
    """
    n_all = len(file.config.samples)
    if not file.config.convergence.stop_when_converged:
        return n_all
    known = np.isfinite(file.read("statistics/contact/percentile")).any(axis=1)  # (V, K)
    blocks = np.flatnonzero(known.all(axis=0))
    return int(file.read("statistics/contact/samples_seen", blocks[-1])) if len(blocks) else n_all


def tuned_line(file: ResultFile) -> str:
    """Peak of the tuned disk, to which all amplifications are relative, and how sure it is."""
    peak, runs = file.read("tuned/peak_amplitude_m"), np.sort(file.read("tuned/run_peaks_m"))
    text = f"tuned disk: {peak * 1e3:.2f} mm at {file.read('tuned/peak_speed_hz'):.2f} Hz"
    if not np.isfinite(runs).all() or runs[-1] / runs[0] - 1.0 < 1e-3:
        return text
    reference = file.read("tuned/reference_amplitude_m")
    text += (
        f"; median {reference * 1e3:.2f} mm of {len(runs)} perturbed tuned runs "
        f"({runs[0] * 1e3:.2f} to {runs[-1] * 1e3:.2f} mm)"
    )
    low, high = np.ravel(percentile_interval(runs, [50.0], Z_95))
    if not np.isfinite([low, high]).all():
        return text
    return text + (
        f": all amplifications share an uncertainty of {100 * (reference / high - 1.0):+.1f} to "
        f"{100 * (reference / low - 1.0):+.1f} % (mistuning.tuned_runs)"
    )


def level_table(file: ResultFile, narrow: bool = False) -> Table:
    """One row per mistuning level; narrow: without sigma, and with fewer digits."""
    percentiles = file.config.convergence.percentiles
    names = "/".join(f"{p:g}" for p in percentiles)
    table = Table(
        box=box.SIMPLE_HEAD,
        title=f"Amplifications, percentiles {names}, convergence error",
        padding=(0, 0) if narrow else (0, 1),
    )
    headings = ["level", "sigma", "samples", "A_nl", "A_lin", "error", "not\nsteady", "diverged"]
    for heading in headings:
        if not (narrow and heading == "sigma"):
            table.add_column(heading, justify="right", no_wrap=True)
    digits, n = 2 if narrow else 3, n_counted(file)
    status = file.status()[:, :n]
    half_range, sigma = file.read("half_range"), file.read("sigma")
    for level in range(len(half_range)):
        done = status[level] == DONE
        n_failed = np.count_nonzero(status[level] == FAILED)
        not_steady, diverged = point_shares(file, level)
        contact, linear = (
            _percentile_text(file.read(f"samples/{name}", level)[:n][done], percentiles, digits)
            for name in ("amplification", "linear_amplification")
        )
        table.add_row(
            f"±{100 * half_range[level]:.3g} %",
            *(() if narrow else (f"{100 * sigma[level]:.2f} %",)),
            f"{np.count_nonzero(done)}" + (f" (+{n_failed} failed)" if n_failed else ""),
            contact,
            linear,
            _last_error(file.read("statistics/contact/convergence_error", level)),
            f"{100 * not_steady:.2f} %",
            f"{100 * diverged:.2f} %",
        )
    return table


def interval_table(file: ResultFile) -> Table:
    """One row per level and percentile: amplifications with their confidence intervals."""
    c = file.config.convergence
    table = Table(
        box=box.SIMPLE_HEAD,
        title=f"Percentiles and their confidence intervals ({100 * confidence(Z_95):.4g} %)",
    )
    for heading in ("level", "percentile", "A_nl", "interval", "A_lin", "interval"):
        table.add_column(heading, justify="right", no_wrap=True)
    n = n_counted(file)
    status = file.status()[:, :n]
    names = "samples/amplification", "samples/linear_amplification"
    for level, half_range in enumerate(file.read("half_range")):
        done = status[level] == DONE
        columns = []
        for name in names:
            values = file.read(name, level)[:n][done]
            low, high = percentile_interval(values, c.percentiles, Z_95)
            middle = np.percentile(values, c.percentiles) if len(values) else np.full_like(low, nan)
            columns += [[_number(x) for x in middle], list(map(_interval, low, high))]
        for percentile, *cells in zip(c.percentiles, *columns, strict=True):
            table.add_row(f"±{100 * half_range:.3g} %", f"{percentile:g}", *cells)
    return table


def _number(x):
    return f"{x:.3f}" if np.isfinite(x) else "-"


def _interval(low, high):
    """An end is open when there are too few samples for it."""
    return f"{_number(low)} to {_number(high)}"


def point_lines(file: ResultFile) -> Iterator[str]:
    """What went wrong in single points, in words with counts, and the work of the force solver."""
    counts = point_status.count(file.read("tuned/point_reason"))
    most = int(file.read("tuned/max_sweeps").max())
    tuned = file.read("tuned/point_status")
    n_points, n_not_steady = np.count_nonzero(tuned), np.count_nonzero(tuned == NOT_STEADY)
    for part in _pieces(file):
        counts = counts + point_status.count(file.read("samples/point_reason", part))
        most = max(most, int(file.read("samples/max_sweeps", part).max(initial=0)))
        status = file.read("samples/point_status", part)
        n_points += np.count_nonzero(status)
        n_not_steady += np.count_nonzero(status == NOT_STEADY)
    yield from point_status.lines(counts, int(n_points))
    if n_not_steady:
        yield (
            f"not steady: {n_not_steady} of {n_points} points had not settled at "
            "steady_state.max_time_s; theirs is the largest amplitude of the last revolutions"
        )
    yield f"contact forces: at most {most} sweeps of the solver in a step"


def _pieces(file, levels=None):
    """Places of all samples that count, level by level, a few at a time."""
    n = n_counted(file)
    for level in range(len(file.config.levels)) if levels is None else levels:
        for first in range(0, n, ROWS):
            yield level, slice(first, min(n, first + ROWS))


def point_shares(file: ResultFile, level: int) -> tuple[float, float]:
    """Shares of the computed points of a level that were not steady, and that diverged."""
    counts = np.zeros(4, dtype=np.int64)
    for part in _pieces(file, [level]):
        counts += np.bincount(file.read("samples/point_status", part).ravel(), minlength=4)[:4]
    n_points = max(counts[1:].sum(), 1)
    return counts[NOT_STEADY] / n_points, counts[DIVERGED] / n_points


def _percentile_text(values, percentiles, digits):
    if len(values) < 2:
        return f"{values[0]:.{digits}f}" if len(values) else "-"
    return "/".join(f"{p:.{digits}f}" for p in np.percentile(values, percentiles))


def _last_error(error):
    """Largest of the latest convergence errors (P, K) over the percentiles."""
    known = np.flatnonzero(np.isfinite(error).all(axis=0))
    return f"{100 * error[:, known[-1]].max():.2f} %" if len(known) else "-"


def pattern_table(file: ResultFile) -> Table:
    """Largest amplitude and localisation of the tuned disk and of an explicit pattern."""
    table = Table(box=box.SIMPLE_HEAD, title="Amplitude, speed, localisation factor")
    for heading in ("", "[mm]", "[Hz]", "LF [%]"):
        table.add_column(heading, justify="right" if heading else "left", no_wrap=True)
    speeds = file.read("speeds_hz")
    for name, group, where, by in (
        ("tuned, largest amplitude", "tuned", (), "amplitude_m"),
        ("pattern, largest amplitude", "samples", (0, 0), "amplitude_m"),
        ("pattern, largest localisation", "samples", (0, 0), "localisation"),
    ):
        keys = "amplitude_m", "localisation"
        values = {key: file.read(f"{group}/{key}", where) for key in keys}
        if np.isfinite(values[by]).any():
            best = np.nanargmax(values[by])
            size, localisation = 1e3 * values[keys[0]][best], 100 * values[keys[1]][best]
            table.add_row(name, f"{size:.1f}", f"{speeds[best]:.2f}", f"{localisation:.1f}")
    return table
