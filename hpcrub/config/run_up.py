"""Runs of a rotor that gains and loses speed, from the section `run_up` of an input.

All functions take a `Config`, whose module imports this one.
"""

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np

from hpcrub.config.text import curve_problems, lines_of
from hpcrub.response.schedule import Schedule

N_INTERVALS = 50  # intervals of speed, if the input does not say
MOST_INTERVALS = 2000
MOST_TURNS = 1e8  # revolutions of a run
CLEARANCES = 0.0, 1e4  # least and largest of a table [mm]
RATE = (1.0,)  # gain of speed, if the input does not say [Hz/s]
OF_TRIALS = "threshold", "rare", "checklist"  # studies whose disks run up where an input says so


def runs_up(c: Any) -> bool:
    """Whether the disks of a study run up, instead of turning at constant speeds."""
    return c.study == "run_up" or (c.study in OF_TRIALS and c.run_up != type(c.run_up)())


def ends_of(c: Any) -> tuple[float, float]:
    """Speeds at the begin and at the end of the way there [Hz]; of a table the lowest, highest."""
    table = c.run_up.speed_s_hz
    if isinstance(table, tuple):
        speeds = [speed for _, speed in table]
        return min(speeds), max(speeds)
    first, last = c.run_up.from_hz, c.run_up.to_hz
    return c.speeds.from_hz if first is None else first, c.speeds.to_hz if last is None else last


def schedules(c: Any) -> list[Schedule]:
    """Speed over the time of every run: one of a table, else one for each rate."""
    run = c.run_up
    if run.speed_s_hz is not None:
        return [Schedule(*np.array(run.speed_s_hz).T)]
    how = run.hold_s, run.back, run.passes
    return [Schedule.of_rate(*ends_of(c), rate, *how) for rate in run.hz_per_s or RATE]


def rates(c: Any) -> np.ndarray:
    """Rate of every run [Hz/s]; of a table the largest."""
    if c.run_up.speed_s_hz is None:
        return np.array(c.run_up.hz_per_s or RATE)
    return np.array([np.abs(schedules(c)[0].slopes).max()])


def intervals(c: Any) -> np.ndarray:
    """Borders of the intervals of speed (I + 1,) [Hz]."""
    low, high = sorted(ends_of(c))
    width = c.run_up.interval_hz
    n = N_INTERVALS if width is None else np.clip(round((high - low) / width), 1, MOST_INTERVALS)
    return np.linspace(low, high, int(n) + 1)


def problems(c: Any) -> Iterator[str]:
    """Yield error lines about runs that cannot be."""
    table, over_time = c.run_up.speed_s_hz, c.casing.clearance_s_mm
    if isinstance(table, str) or isinstance(over_time, str):
        return  # their files are not read yet
    if lines := [*_table_problems(c, table or ())]:
        yield from lines
        return
    if not runs_up(c):
        return
    low, high = sorted(ends_of(c))
    yield from lines_of(
        (low < c.speeds.from_hz or high > c.speeds.to_hz,
         f"run_up.to_hz: a run from {low:g} to {high:g} Hz is not within speeds.from_hz, "
         f"{c.speeds.from_hz:g}, and speeds.to_hz, {c.speeds.to_hz:g}; leave these out"),
        (low == high and table is None,
         f"run_up.to_hz: {high:g} is run_up.from_hz, too: the rotor gains no speed"),
    )  # fmt: skip
    if low == high and table is None:
        return
    n = (high - low) / (c.run_up.interval_hz or high)
    if n > MOST_INTERVALS:
        yield (
            f"run_up.interval_hz: {c.run_up.interval_hz:g} divides {high - low:g} Hz into more "
            f"than {MOST_INTERVALS:,} intervals"
        )
    runs = sorted(schedules(c), key=lambda run: run.time[-1])
    yield from _length_problems(c, runs[0], runs[-1])
    lasts = float(runs[-1].time[-1])
    yield from curve_problems(
        "casing.clearance_s_mm", over_time, ("times", "s", "mm"), CLEARANCES,
        (0.0, lasts * (1.0 - 1e-9)), f"a run of {lasts:.6g} s",
    )  # fmt: skip


def _length_problems(c: Any, shortest: Any, longest: Any) -> Iterator[str]:
    """Error lines about the shortest and the longest run."""
    key = "run_up.hz_per_s" if c.run_up.speed_s_hz is None else "run_up.speed_s_hz"
    if (most := longest.turned[-1]) > MOST_TURNS:
        yield f"{key}: a run of {most:.2g} revolutions; up to 1e8 can be"
    if (least := shortest.turned[-1]) < 1.0:
        yield f"{key}: a run of {shortest.time[-1]:.2g} s is {least:.2g} revolutions; one is needed"


def _table_problems(c: Any, table: Any) -> Iterator[str]:
    """Error lines about a table of speeds over the time."""
    if not table:
        return
    speeds = [speed for _, speed in table]
    back = {np.sign(b - a) for a, b in pairwise(speeds)} >= {-1.0, 1.0}
    yield from curve_problems("run_up.speed_s_hz", table, ("times", "s", "Hz"), (1e-6, 1e5))
    yield from lines_of(
        (table[0][0] != 0.0, f"run_up.speed_s_hz: the first time is {table[0][0]:g} s, not 0"),
        (back and not c.run_up.back,
         "run_up.speed_s_hz: the speed turns back; if that is meant, say run_up.back: true"),
    )  # fmt: skip
