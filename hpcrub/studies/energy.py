"""Strain energy of the blades, for the samples of a contact study with the largest A_nl.

Every speed is integrated to its steady state as in the contact study, and from there over one more
window, in which the energy is taken. The window begins with the coating as it is worn by then, and
the energy that wear has taken is kept, too.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from hpcrub import effects
from hpcrub.config.schema import Config
from hpcrub.contact import status
from hpcrub.contact.status import DIVERGED, POINT_REASON, POINT_STATUS
from hpcrub.effects.effect import peaks_of_disks
from hpcrub.errors import InputError
from hpcrub.model.reduction import Modes, blade_stiffness
from hpcrub.response import history
from hpcrub.response.scene import Scene
from hpcrub.response.sweep import Motion, SweepResult, run_sweep
from hpcrub.results.layout import DONE, SPEEDS, Dataset
from hpcrub.results.samples import n_counted
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import Finding
from hpcrub.runs import findings
from hpcrub.runs.cost import Cost
from hpcrub.runs.study import Poll, StudyInTime, Values
from hpcrub.setup.disks import rubbing_modes, run_deviation
from hpcrub.setup.problem import Problem, build_problem
from hpcrub.statistics.percentiles import finite
from hpcrub.studies.contact.study import open_contact, require_complete

_SAMPLE, _SS = ("sample",), ("sample", "speed")
LAYOUT = (
    SPEEDS,
    Dataset("level", _SAMPLE, "1", "mistuning level of a sample in the source", "i8"),
    Dataset("number", _SAMPLE, "1", "its number in the source", "i8"),
    Dataset("sigma", _SAMPLE, "1", "standard deviation of a blade's stiffness at its level"),
    Dataset("deviation", ("sample", "blade"), "1", "its stiffness deviations"),
    Dataset("amplification", _SAMPLE, "1", "its A_nl by displacements, from the source"),
    Dataset("tuned/energy_j", ("speed", "blade"), "J", "largest strain energy of the tuned disk"),
    Dataset("tuned/point_status", ("speed",), "1", POINT_STATUS, "u1"),
    Dataset("tuned/point_reason", ("speed",), "1", POINT_REASON, "u1"),
    Dataset("energy_j", (*_SS, "blade"), "J", "largest strain energy of a blade"),
    Dataset("point_status", _SS, "1", POINT_STATUS, "u1"),
    Dataset("point_reason", _SS, "1", POINT_REASON, "u1"),
)


class Chosen(NamedTuple):
    """Data that every rank needs."""

    problem: Problem  # of the tuned disk
    deviation: np.ndarray  # stiffness deviations of the chosen samples (n, N)


def energies(
    modes: Modes, stiffness: np.ndarray, scene: Scene, speeds_hz: np.ndarray, poll: Poll
) -> tuple[np.ndarray, SweepResult]:
    """Largest strain energy of every blade at every speed, (S, N) [J]; NaN where diverged.

    stiffness: matrices of the blades in modal coordinates (N, K, K) [rad2/s2].
    Also returns the SweepResult.
    """
    motion = Motion.at_rest(len(speeds_hz), modes.n_rows)
    result = run_sweep(modes, scene, speeds_hz, poll, motion=motion)
    energy = np.full((len(speeds_hz), len(stiffness)), np.nan)
    reason = np.zeros(len(speeds_hz), dtype=np.uint8)
    for group in history.groups(speeds_hz):
        usable = group[result.point_status[group] != DIVERGED]
        if not len(usable):
            continue
        part = Motion(*(values[usable] for values in motion))
        duration = scene.steady.window_revolutions / speeds_hz[usable].max()
        peak = -np.inf
        for piece in history.integrate(modes, scene, speeds_hz[usable], duration, part, poll):
            R, K, S = piece.position.shape
            q = np.moveaxis(piece.position, 1, 2).reshape(R * S, K)
            now = np.stack([0.5 * ((q @ k) * q).sum(axis=1) for k in stiffness], axis=1)
            peak = np.maximum(peak, now.reshape(R, S, -1).max(axis=0))
            reason[usable] = piece.reason
        energy[usable] = peak
    result = result.continued(reason)
    energy[result.point_status == DIVERGED] = np.nan
    return energy, result


def amplification(file: ResultFile) -> np.ndarray:
    """A_nl(E) of every sample: its largest energy over the tuned disk's, (n,).

    NaN where all points of the sample or of the tuned disk have diverged.
    """
    energy, tuned = peaks_of_disks(file, "energy_j")
    return energy / (tuned if tuned > 0.0 else np.nan)


class Energy(StudyInTime):
    """Strain energy of the worst samples of a contact study."""

    name = "energy"
    what = "amplification of the blades' strain energy"
    sections = ("energy",)
    mistunes = True
    n_sources = 1
    datasets = LAYOUT

    def sizes(self, config: Config) -> dict[str, int]:
        """Number of samples."""
        return {"sample": config.energy.samples}

    def prepare(self, config: Config) -> Chosen:
        """Return the tuned disk and the chosen samples. Raises InputError as `constants` does."""
        return Chosen(build_problem(config), self.constants(config)["deviation"])

    def constants(self, config: Config) -> dict[str, Any]:
        """The samples with the largest A_nl of the source.

        Raises InputError when the source has too few finished samples or other physics.
        """
        n_wanted = config.energy.samples
        with open_contact(config.sources[0]) as file:
            require_complete(file, config)
            n = n_counted(file)
            values, done = file.read("samples/amplification")[:, :n], file.status[:, :n] == DONE
            if np.count_nonzero(done) < n_wanted:
                raise InputError(
                    f"energy.samples: {n_wanted:,} is more than the {np.count_nonzero(done):,} "
                    f"finished samples of {file.path}"
                )
            largest = np.argsort(-values[done], kind="stable")[:n_wanted]
            level, number = (places[largest] for places in np.nonzero(done))
            return {
                "level": level,
                "number": number,
                "sigma": file.read("sigma")[level],
                "deviation": file.read("samples/deviation")[level, number],
                "amplification": values[level, number],
            }

    def n_tasks(self, config: Config) -> int:
        """One task for the tuned disk, then one for every sample."""
        return 1 + config.energy.samples

    def cost(self, config: Config) -> Cost:
        """Cost of every disk at every speed, until it is steady and over one more window."""
        n, window = self.n_tasks(config), config.steady_state.window_revolutions
        return Cost(n, n * window / config.speeds.from_hz, n)

    def compute(self, config: Config, problem: Any, task: int, poll: Poll) -> Iterator[Values]:
        """Compute the strain energies of one disk."""
        tuned, samples = problem
        deviation = samples[task - 1] if task else run_deviation(config, 0)
        modes = rubbing_modes(config, tuned, deviation)
        stiffness = blade_stiffness(tuned.reduced, deviation, modes)
        energy, result = energies(modes, stiffness, tuned.scene, config.speeds.values_hz, poll)
        group, where = ("", task - 1) if task else ("tuned/", ())
        values = {"energy_j": energy} | result.by_name()
        there = {dataset.name for dataset in self.layout(config)}
        for name in (name for name in values if f"{group}{name}" in there):
            yield f"{group}{name}", where, values[name]

    def report(self, file: ResultFile) -> Iterator[str]:
        """Points without a result, and ranges of both amplifications."""
        reason = np.vstack([file.read("tuned/point_reason"), file.read("point_reason")])
        yield from status.lines(status.count(reason), reason.size)
        by_energy, known = amplification(file), file.read("amplification")
        yield f"{len(by_energy)} samples: A_nl {known.min():.3f} to {known.max():.3f}"
        by_energy = finite(by_energy)
        if not len(by_energy):
            yield (
                "by strain energy: not known, all points of the tuned disk or of the samples "
                "diverged"
            )
            return
        low, middle, high = np.percentile(by_energy, [0, 50, 100])
        yield f"by strain energy: {low:.3f} to {high:.3f}, median {middle:.3f}"
        yield from effects.lines(file)

    def findings(self, file: ResultFile) -> Iterator[Finding]:
        """Reasons to distrust points of disks, and largest energies at an end of the speeds."""
        names = "energy_j", "point_status", "point_reason"
        of_all = (np.concatenate([file.read(f"tuned/{n}")[None], file.read(n)]) for n in names)
        energy, states, reasons = of_all
        peaks = energy.max(axis=2)
        yield from findings.of_points(file.config, peaks, states, reasons, self.time_key)


STUDY = Energy()
