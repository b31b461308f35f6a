"""Studies of a few motions, of which the largest is computed to second order as well."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from hpcrub.response.sweep import run_sweep
from hpcrub.results.layout import PENDING, Values
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import Finding
from hpcrub.runs import findings
from hpcrub.runs.job import Round
from hpcrub.runs.study import Poll, StudyInTime
from hpcrub.setup.disks import fixed_disks, rubbing_modes
from hpcrub.setup.problem import build_problem, to_second_order
from hpcrub.studies.contact import second_order
from hpcrub.studies.contact.trials import BENT, BENT_STATUS

AROUND, MOST_SPEEDS = 0.04, 8  # how far from the speed of the largest motion, and how many speeds


class Motions(StudyInTime):
    """A study of a few motions, with the datasets of a `bent_table`, a row for each motion.

    A sweep at the speed of the largest motion, and at some around it, tells what small
    displacements leave out. It begins at rest, as the motions whose peak it is compared to.
    """

    to_second_order = True
    amplitude = "amplitude_m"  # dataset (rows, speeds) [m] or (rows,)
    at_rest = slice(None)  # its rows that begin at rest
    disks = slice(None)  # of the disks of the input, one for each of these rows

    def next_round(self, file: ResultFile) -> Round:
        """The motions; then the largest one to second order, where that may matter."""
        last = super().next_round(file)
        if last.tasks:
            return last
        sizes = self._sizes(file).max(axis=1)
        row = int(sizes.argmax())
        most = second_order.FURTHER * float(sizes[row])  # while it begins
        done = file.read(BENT_STATUS, row) != PENDING
        if done or not second_order.matters(file.config, most):
            return last
        phase, where = "disks to second order", BENT_STATUS
        return Round([(row,)], {}, None, phase, where, to_second_order=True)

    def compute_to_second_order(
        self, file: ResultFile, tasks: Sequence[Any], poll: Poll
    ) -> Iterator[tuple[Any, list[Values]]]:
        """Sweep disks once more around the speeds of their largest motions; tasks: (row,)."""
        config = to_second_order(file.config)
        problem, speeds, disks = build_problem(config), config.speeds.values_hz, fixed_disks(config)
        for (row,) in tasks:
            modes = rubbing_modes(config, problem, disks[self.disks][row])
            peak = int(self._sizes(file)[row].argmax())
            near = np.flatnonzero(np.abs(speeds / speeds[peak] - 1.0) <= AROUND)
            some = np.linspace(0, len(near) - 1, min(len(near), MOST_SPEEDS - 1)).astype(int)
            found = run_sweep(modes, problem.scene, speeds, poll, selection={peak, *near[some]})
            size = np.fmax.reduce(found.amplitude)
            yield (row,), [(BENT, row, np.nan_to_num(size, nan=np.inf))]

    def findings(self, file: ResultFile) -> Iterator[Finding]:
        """Findings against the points and amplitudes of all disks, or starts."""
        names = "amplitude_m", "point_status", "point_reason"
        amplitude, states, reasons = map(file.read, names)
        yield from findings.of_points(file.config, amplitude, states, reasons, self.time_key)
        yield from self.kinematics(file, amplitude)

    def kinematics(self, file: ResultFile, sizes: np.ndarray) -> Iterator[Finding]:
        """Findings about the size of motions [m], by the one to second order if there is one."""
        before, after = self._sizes(file).max(axis=1), file.read(BENT)[self.at_rest]
        told = second_order.of_others(file, "the disk that moves furthest", before, after)
        yield from findings.kinematics(file.config, sizes, told)

    def _sizes(self, file: ResultFile) -> np.ndarray:
        """Amplitudes of the motions that begin at rest (rows, speeds) [m]; 0 without one."""
        sizes = file.read(self.amplitude)[self.at_rest]
        return np.nan_to_num(sizes.reshape(len(sizes), -1))
