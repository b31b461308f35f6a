"""The tuned disk of a contact study: the reference that all amplifications are relative to."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.contact import status
from hpcrub.errors import HpcrubError
from hpcrub.model.reduction import Modes, mistuned_modes
from hpcrub.response.sweep import SweepResult
from hpcrub.setup.disks import APART
from hpcrub.setup.problem import Problem
from hpcrub.studies.contact import file as contact_file
from hpcrub.studies.contact.amplification import (
    Reference,
    deepest,
    linear_amplitude,
    peak,
    point_values,
)
from hpcrub.studies.contact.tasks import TunedPart, most_parts, n_parts

ROUNDING = 1e-9  # of the clearance and the height of the casing together: no amplitude below


class Integrated(NamedTuple):
    """A sweep of one disk, or the part of it that one rank has integrated."""

    result: SweepResult | None  # None: it failed
    seconds: float
    message: str = ""


def modes_of_tuned(config: Config, problem: Problem, run: int) -> Modes:
    """Modes of the tuned disk (run 0), or of one that hardly differs.

    Where the motion is not periodic, or one of several, its amplitude is one draw of many. All
    amplifications are relative to the median.
    """
    perturbed = np.full(config.disk.n_blades, APART * run)
    return mistuned_modes(problem.reduced, perturbed)


def join(parts: Sequence[Any]) -> Any:
    """One Integrated of n parts, the p-th of which holds the speeds p, p + n, ..."""
    failed = next((part for part in parts if part.result is None), None)
    seconds = sum(part.seconds for part in parts)
    if failed:
        return failed._replace(seconds=seconds)
    whole = SweepResult.empty(*parts[0].result.wear.around.shape[:2])
    for first, part in enumerate(parts):
        whole.take(slice(first, None, len(parts)), part.result)
    n_steps = sum(part.result.n_steps for part in parts)
    return Integrated(whole._replace(n_steps=n_steps), seconds)


class TunedDisk:
    """Rank 0's book of the tuned disk, integrated as it is, and perturbed."""

    def __init__(self, config: Config, problem: Problem | None, file: Any) -> None:
        self.config, self.problem, self.file = config, problem, file
        self.reference: Any = None  # Reference, once known
        self.rounding = ROUNDING * problem.scene.lift if problem else 0.0  # [m]
        self.runs: list[dict[int, Any]] = [
            {} for _ in range(config.mistuning.tuned_runs)
        ]  # Integrated of every part

    def take_stock(self) -> None:
        """Take up the results that are there."""
        if tuned := contact_file.read_tuned(self.file):
            linear = tuned["linear_amplitude_m"]
            contact = float(tuned["reference_amplitude_m"])
            self.reference = Reference(contact, float(linear), self.rounding)

    def tasks(self, n_ranks: int) -> list[TunedPart]:
        """Tasks that are left."""
        n_runs = 0 if self.reference else len(self.runs)
        cut = n_parts(n_runs, n_ranks, most_parts(self.config.speeds.n_values))
        return [TunedPart(run, part, cut) for run in range(n_runs) for part in range(cut)]

    def collect(self, task: TunedPart, response: Any) -> None:
        """Take the result of a task; write all when it is the last one."""
        self.runs[task.run][task.part] = response
        if all(len(parts) == task.n_parts for parts in self.runs):
            wholes = [join([parts[i] for i in range(task.n_parts)]) for parts in self.runs]
            self.reference = self._write([whole.result for whole in wholes])

    def n_speeds(self) -> int:
        """Number of speeds that have been integrated."""
        done = (part.result.point_status for parts in self.runs for part in parts.values())
        return sum(map(np.count_nonzero, done))

    def _write(self, runs):
        speeds = self.config.speeds.values_hz
        modes = modes_of_tuned(self.config, self.problem, 0)
        values = point_values(runs[0]) | {"frequencies_hz": modes.omega / (2.0 * np.pi)}
        values["peak_amplitude_m"], values["peak_speed_hz"] = peak(runs[0], speeds)
        peaks = np.array([peak(run, speeds)[0] for run in runs])
        values["run_deepest_m"] = np.array([deepest(run, speeds)[0] for run in runs])
        values["run_amplitude_m"] = np.array([run.amplitude for run in runs])
        values["run_peaks_m"], known = peaks, peaks[np.isfinite(peaks)]
        values["reference_amplitude_m"] = np.median(known) if known.size else np.nan
        values["linear_amplitude_m"] = linear_amplitude(self.config, self.problem, modes)
        contact_file.write_tuned(self.file, values)
        contact, linear = (values[f"{name}_amplitude_m"] for name in ("reference", "linear"))
        return Reference(contact, linear, self.rounding)

    def check(self) -> None:
        """Raises HpcrubError for a reference that amplitudes cannot be divided by."""
        if np.isnan(self.reference.contact):
            reason = self.file.read("tuned/point_reason")
            why = "; ".join(status.lines(status.count(reason), reason.size))
            raise HpcrubError(
                f"the tuned disk has no result at any speed, nothing to compare samples with: {why}"
            )
        if not self.reference.contact > 0.0:
            raise HpcrubError(
                "the tuned disk is not excited: the casing never reaches the blades "
                "(casing.clearance_mm beside bump_height_mm, harmonics and profile)"
            )
        if not self.reference.usable:
            raise HpcrubError(
                f"the tuned disk moves by {self.reference.contact:.1e} m only, which is rounding: "
                "its tips move radially, and amplitudes are tangential (no lean, no bow, "
                "no friction)"
            )
