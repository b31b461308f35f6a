"""The tuned disk of a contact study: the reference that all amplifications are relative to."""

from typing import NamedTuple

import numpy as np

from hpcrub.errors import HpcrubError
from hpcrub.layout import TUNED_REPEATS
from hpcrub.schedule import Tuned, most_parts, n_parts
from hpcrub.study import linear_amplitude, modes_of, peak, point_values
from hpcrub.sweep import SweepResult

NUDGE = 1e-12  # relative change of stiffness, as small as rounding


class Reference(NamedTuple):
    """What amplitudes are divided by [m]."""

    contact: float
    linear: float

    @property
    def usable(self):
        return self.contact > 0.0


class Marched(NamedTuple):
    """A sweep of one disk, or the part of it that one rank has marched."""

    result: SweepResult | None  # None: it failed
    seconds: float
    message: str = ""


def modes_of_tuned(config, problem, repeat):
    """Modes of the tuned disk (repeat 0), or of one that differs by rounding: where the motion is
    not periodic, its amplitude is one draw of many."""
    return modes_of(config, problem, np.full(config.disk.n_blades, NUDGE * repeat))


def join(parts):
    """One Marched of n parts, the p-th of which holds the speeds p, p + n, ..."""
    failed = next((part for part in parts if part.result is None), None)
    seconds = sum(part.seconds for part in parts)
    if failed:
        return failed._replace(seconds=seconds)
    whole = SweepResult.empty(len(parts[0].result.amplitude))
    for first, part in enumerate(parts):
        mine = slice(first, None, len(parts))
        for values, new in zip(whole[:-1], part.result[:-1], strict=True):
            values[mine] = new[mine]
    n_steps = sum(part.result.n_steps for part in parts)
    return Marched(whole._replace(n_steps=n_steps), seconds)


class TunedDisk:
    """Rank 0's book of the tuned disk."""

    def __init__(self, config, problem, file):
        self.config, self.problem, self.file = config, problem, file
        self.reference = None
        self.parts = {}
        self.missing = range(1, TUNED_REPEATS + 1)

    def take_stock(self):
        """Take up the results that are there."""
        tuned = self.file.tuned()
        if tuned:
            self.reference = Reference(tuned["peak_amplitude_m"], tuned["linear_amplitude_m"])
        missing = np.isnan(self.file.read("tuned/peak_repeats_m"))
        self.missing = [int(repeat) + 1 for repeat in np.flatnonzero(missing)]

    def tasks(self, n_ranks):
        """Tasks that give the reference, and those that repeat it."""
        cut = n_parts(1, n_ranks, most_parts(self.config.speeds.n_values))
        parts = [] if self.reference else [Tuned(0, part, cut) for part in range(cut)]
        return parts, [Tuned(repeat) for repeat in self.missing]

    def collect(self, task, marched):
        """Take and write the result of a task."""
        if task.repeat:
            amplitude = peak(marched.result, self.config.speeds.values_hz)[0]
            self.file.write({"tuned/peak_repeats_m": amplitude}, task.repeat - 1)
            return
        self.parts[task.part] = marched
        if len(self.parts) == task.n_parts:
            whole = join([self.parts[part] for part in range(task.n_parts)])
            self.reference = self._write(whole.result)

    def n_speeds(self):
        """Number of speeds that have been marched."""
        return sum(np.count_nonzero(part.result.point_status) for part in self.parts.values())

    def _write(self, result):
        modes = modes_of_tuned(self.config, self.problem, 0)
        values = point_values(result) | {"frequencies_hz": modes.omega / (2.0 * np.pi)}
        found = peak(result, self.config.speeds.values_hz)
        values["peak_amplitude_m"], values["peak_speed_hz"] = found
        values["linear_amplitude_m"] = linear_amplitude(self.config, self.problem, modes)
        self.file.write_tuned(values)
        return Reference(found[0], values["linear_amplitude_m"])

    def check(self):
        """Raises HpcrubError for a reference that amplitudes cannot be divided by."""
        if np.isnan(self.reference.contact):
            raise HpcrubError(
                "the tuned disk diverges at every speed: nothing to compare samples with"
            )
        if not self.reference.usable:
            raise HpcrubError(
                "the tuned disk is not excited: the bumps never reach the blades "
                "(casing.clearance_mm, casing.bump_height_mm)"
            )
