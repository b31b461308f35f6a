"""How deep mistuned disks cut into a coating, beside the tuned one: a table and lines."""

from collections.abc import Iterator

import numpy as np
from rich import box
from rich.table import Table

from hpcrub.model.coating import Coating
from hpcrub.results.layout import DONE
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import Z_95, percentile_interval, probability_interval
from hpcrub.studies.contact import trust

REACHED = 1.0 - 1e-9  # of the depth of a coating that is worn through: rounding


def table(file: ResultFile) -> Table:
    """One row per level and percentile: largest amplitudes and worn depths with their intervals."""
    percentiles = file.config.convergence.percentiles
    found = Table(box=box.SIMPLE_HEAD, title="Coating: percentiles and their intervals (95 %) [mm]")
    for heading in ("level", "percentile", "amplitude", "interval", "worn depth", "interval"):
        found.add_column(heading, justify="right", no_wrap=True)
    for level, half_range in enumerate(file.read("half_range")):
        columns = []
        for name in ("peak_amplitude_m", "deepest_m"):
            values = 1e3 * _finished(file, level, name)
            if not len(values):
                return found
            low, high = percentile_interval(values, percentiles, Z_95)
            columns += [
                [f"{x:.4g}" for x in np.percentile(values, percentiles)],
                [f"{_end(a)} to {_end(b)}" for a, b in zip(low, high, strict=True)],
            ]
        for percentile, *cells in zip(percentiles, *columns, strict=True):
            found.add_row(f"±{100 * half_range:.3g} %", f"{percentile:g}", *cells)
    return found


def lines(file: ResultFile) -> Iterator[str]:
    """How much deeper the worst disk of every level cuts than the tuned one.

    Nothing of a casing without a coating.
    """
    if "tuned/run_deepest_m" not in file:
        return
    runs = 1e3 * file.read("tuned/run_deepest_m")
    tuned = float(np.median(runs[np.isfinite(runs)])) if np.isfinite(runs).any() else np.nan
    yield f"the tuned disk cuts {tuned:.3g} mm deep ({_range(runs)} in {len(runs)} runs of it)"
    for level, half_range in enumerate(file.read("half_range")):
        depth = 1e3 * _finished(file, level, "deepest_m")
        if not len(depth) or not tuned > 0.0:
            continue
        beyond = probability_interval(0, len(depth), Z_95)[1]
        yield (
            f"±{100 * half_range:.3g} %: the worst of {len(depth)} disks cuts {depth.max():.3g} mm "
            f"deep, {depth.max() / tuned:.2f} times the tuned one; another disk cuts deeper with a "
            f"probability below {100 * beyond:.2g} % (95 % confidence)"
        )
    c = file.config.contact.coating
    depth_of_all = Coating(c.thickness, c.young, c.yield_stress, c.hardening, area=0.0).worn_through
    through = n_disks = 0
    for level, part in trust.pieces(file):
        depth = file.read("samples/worn_depth_m", (level, part))
        n_disks += int(np.count_nonzero(file.status[level, part] == DONE))
        cut = (depth >= REACHED * depth_of_all).any(axis=1)
        through += int(np.count_nonzero(cut))
    if through:
        yield (
            f"{through} of {n_disks} disks cut through the coating, {1e3 * depth_of_all:.3g} mm, "
            "at some speed: their tips reach the casing behind it, and depths say no more"
        )


def _finished(file, level, name):
    """Numbers of the disks of a level that are finished, of those that count."""
    n = trust.n_counted(file)
    values = file.read(f"samples/{name}", level)[:n][file.status[level, :n] == DONE]
    return values[np.isfinite(values)]


def _end(x):
    """An end is open when there are too few samples for it."""
    return f"{x:.4g}" if np.isfinite(x) else "-"


def _range(runs):
    return f"{np.nanmin(runs):.3g} to {np.nanmax(runs):.3g} mm"
