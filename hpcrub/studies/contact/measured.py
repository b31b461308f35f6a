"""Measured disks and explicit patterns, a line each: percentiles of a few disks say nothing."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from rich.table import Table

from hpcrub.contact.status import AVERAGED, DIVERGED, NOT_STEADY
from hpcrub.ranks import progress
from hpcrub.results.layout import DONE
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import Z_95, confidence, widened
from hpcrub.studies.contact.layout import STEADY, amplitude
from hpcrub.studies.contact.survey import shared_uncertainty

NAMES = "amplification", "linear_amplification", "peak_amplitude_m", "peak_speed_hz"
MOST_DISKS = 24  # most measured disks with a line each; for more disks there are percentiles


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


def are_few(file: ResultFile) -> bool:
    """Whether the samples of a file are so few measured disks that each has its own line."""
    config = file.config
    return config.mistuning.pattern_file is not None and len(config.samples) <= MOST_DISKS


def disks(file: ResultFile) -> Iterator[Disk]:
    """All measured disks of a file that have a result."""
    shared, status = shared_uncertainty(file), file.status[0]
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


def table(file: ResultFile) -> Table:
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
