"""Runs of a rotor that gains and loses speed, from the section `run_up` of an input.

All functions take a `Config`, whose module imports this one.
"""

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np

from hpcrub.config.text import lines_of
from hpcrub.response.schedule import Schedule

N_INTERVALS = 50  # intervals of speed, if the input does not say
MOST_INTERVALS = 2000
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
    table, over_time = c.run_up.speed_s_hz or (), c.casing.clearance_s_mm or ()
    if isinstance(table, str) or isinstance(over_time, str):
        return  # their files are not read yet
    if lines := [*_table_problems(c, table)]:
        yield from lines
        return
    if not runs_up(c):
        return
    low, high = sorted(ends_of(c))
    if low == high and not table:
        yield f"run_up.to_hz: {high:g} is run_up.from_hz, too: the rotor gains no speed"
        return
    if low < c.speeds.from_hz or high > c.speeds.to_hz:
        yield (
            f"run_up.to_hz: a run from {low:g} to {high:g} Hz is not within speeds.from_hz, "
            f"{c.speeds.from_hz:g}, and speeds.to_hz, {c.speeds.to_hz:g}; leave these out"
        )
    shortest, *_, longest = 2 * sorted(schedules(c), key=lambda run: run.time[-1])
    if (least := shortest.turned[-1]) < 1.0:
        key = "run_up.speed_s_hz" if table else "run_up.hz_per_s"
        yield (
            f"{key}: a run of {shortest.time[-1]:.2g} s is {least:.2g} revolutions; one is needed"
        )
    lasts = float(longest.time[-1])
    of = f"s say nothing of a run of {lasts:.6g} s"
    yield from short_curve("casing.clearance_s_mm", over_time, 0.0, lasts * (1.0 - 1e-9), of)


def short_curve(key: str, points: Any, low: float, high: float, of: str) -> Iterator[str]:
    """Error line about a curve that does not reach from low to high; of: the end of the line."""
    if points and (low < points[0][0] or high > points[-1][0]):
        yield f"{key}: points from {points[0][0]:g} to {points[-1][0]:g} {of}"


def _table_problems(c: Any, table: Any) -> Iterator[str]:
    """Error lines about a table of speeds over the time."""
    speeds, first = [speed for _, speed in table], table[0][0] if table else 0.0
    back = {np.sign(b - a) for a, b in pairwise(speeds)} >= {-1.0, 1.0}
    yield from lines_of(
        (min(speeds, default=1.0) <= 0.0,
         f"run_up.speed_s_hz: {min(speeds, default=1.0):g} Hz; speeds above 0 are allowed"),
        (first != 0.0, f"run_up.speed_s_hz: the first time is {first:g} s, not 0"),
        (back and not c.run_up.back,
         "run_up.speed_s_hz: the speed turns back; if that is meant, say run_up.back: true"),
    )  # fmt: skip
