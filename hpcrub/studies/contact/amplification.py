"""Results of one disk in a contact study, and the tuned disk as reference of all others."""

from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from hpcrub import effects
from hpcrub.config.schema import Config
from hpcrub.contact import status
from hpcrub.contact.status import AVERAGED, NO_POINT, NOT_STEADY, STEADY
from hpcrub.effects.effect import largest
from hpcrub.errors import HpcrubError
from hpcrub.model.reduction import Modes, mistuned_modes
from hpcrub.response.linear import linear_peak
from hpcrub.response.scene import Scene
from hpcrub.response.sweep import SweepResult
from hpcrub.results.storage import ResultFile
from hpcrub.setup.disks import modes_of, rubbing_modes, run_deviation
from hpcrub.setup.problem import Problem
from hpcrub.statistics.percentiles import finite
from hpcrub.studies.contact import layout

DIFFERENT = 0.1  # relative change of an amplitude that means another motion or accuracy
LONGER = 4.0  # times as long as a study a disk is followed to see whether its motion stays
AIM = 1.0 / 3.0  # of max_error: error of an average of the tuned disk, which all others share
ROUNDING = 1e-9  # share of clearance plus casing height up to which a motion is rounding


class Reference(NamedTuple):
    """Amplitudes of the tuned disk by which all others are divided [m]."""

    contact: float  # median over all tuned runs
    linear: float  # linear response
    rounding: float = 0.0  # up to this value `contact` is rounding

    @property
    def usable(self) -> bool:
        """Whether amplitudes can be divided by `contact`."""
        return self.contact > self.rounding


def peak(result: SweepResult, speeds_hz: np.ndarray) -> tuple[float, float]:
    """Largest amplitude of a frequency response [m] and its speed [Hz].

    NaN when all points diverged. On a coating the amplitude at any time counts, because a motion
    that has worn itself free does not say what a blade had to bear.
    """
    return largest(amplitudes(result), speeds_hz)


def amplitudes(result: SweepResult) -> np.ndarray:
    """Amplitudes at all speeds, whose largest is the peak (S,) [m]; NaN where there is none."""
    amplitude = result.wear.amplitude if result.wear.around.size else result.amplitude
    usable = np.isin(result.point_status, (STEADY, AVERAGED, NOT_STEADY))
    return np.where(usable, amplitude, np.nan)


def peak_status(result: SweepResult, speeds_hz: np.ndarray) -> int:
    """Status of the point of the largest amplitude; NO_POINT where there is none."""
    return int(result.point_status[speeds_hz == peak(result, speeds_hz)[1]].max(initial=NO_POINT))


def linear_amplitude(config: Config, problem: Problem, modes: Modes, blades: np.ndarray) -> float:
    """Largest tip displacement under the linear engine-order excitation of a configuration [m].

    modes: of the disk with stiffness deviations `blades` (N,) [-].
    """
    scene = problem.scene
    assert config.engine_order is not None  # `Contact.problems` has checked it
    load = config.forcing.amplitude, config.forcing.sense * config.engine_order, scene.interface
    at = partial(modes_of, config, problem, blades)
    return linear_peak(modes, scene.damping_ratio, *load, config.disk.n_blades, at)[0]


class Integrated(NamedTuple):
    """A sweep of one disk, or the part of it that one rank has integrated."""

    result: SweepResult | None  # None: it failed
    seconds: float
    message: str = ""
    checks: dict[str, Any] = {}  # SweepResult of every one of the `checks`, where it is checked

    @property
    def n_steps(self) -> int:
        """Number of time steps at all speeds, those of the checks included."""
        return sum(sweep.n_steps for sweep in (self.result, *self.checks.values()) if sweep)

    def peak(self, speeds_hz: np.ndarray) -> tuple[float, float]:
        """The `peak` of a disk that did not fail, of all speeds."""
        assert self.result is not None
        return peak(self.result, speeds_hz)


def values_of(config: Config, found: Integrated) -> dict[str, Any]:
    """Results of one disk by their names in the result file: at every speed, and largest ones.

    found: of all speeds, and not failed. Effects of the `checks` are there where it was checked.
    """
    result, speeds_hz = found.result, config.speeds.values_hz
    assert result is not None  # it has not failed
    values: dict[str, Any] = result.by_name()
    values["peak_amplitude_m"], values["peak_speed_hz"] = peak(result, speeds_hz)
    for effect in effects.of(config):
        values |= effect.of_disk(result, speeds_hz)
    for name, other in found.checks.items():
        before, after = amplitudes(result), amplitudes(other)
        known = np.isfinite(before) & np.isfinite(after)
        differs = np.abs(after - before)[known] > DIFFERENT * np.maximum(after, before)[known]
        values[f"{name}_peak_m"] = peak(other, speeds_hz)[0]
        values[f"{name}_differs"] = float(differs.mean()) if known.any() else np.nan
    return values


def checks(scene: Scene) -> dict[str, Scene]:
    """Scenes in which some disks are integrated once more, by the names of their results."""
    return {"half_step": finer(scene), "followed": followed(scene)}


def finer(scene: Scene) -> Scene:
    """The scene with half the time step."""
    return scene._replace(step=scene.step / 2.0, least_steps=2.0 * scene.least_steps)


def followed(scene: Scene) -> Scene:
    """The scene with motions that are followed LONGER, which shows whether they stay."""
    first, last = (LONGER * time for time in (scene.steady.first_check, scene.steady.max_time))
    return scene._replace(steady=scene.steady._replace(first_check=first, max_time=last))


def n_runs(config: Config) -> int:
    """Number of runs of the tuned disk: those of the reference, then one of equal blades."""
    return config.mistuning.tuned_runs + (config.mistuning.reference == "staying")


def tuned_run(config: Config, problem: Problem, run: int) -> tuple[Modes, Scene]:
    """Modes and scene of a run of the tuned disk.

    Where the motion is not periodic, or one of several, its amplitude is one draw of many. The
    median over the runs is the reference of the amplifications, and better known than these. The
    run of equal blades keeps its motion, even if it does not stay.
    """
    steady, deviation = problem.scene.steady, np.zeros(config.disk.n_blades)
    if run < config.mistuning.tuned_runs:
        deviation = run_deviation(config, run)
    stays = run < config.mistuning.tuned_runs and config.mistuning.reference == "staying"
    steady = steady._replace(watches_growth=stays, aim=AIM)
    return rubbing_modes(config, problem, deviation), problem.scene._replace(steady=steady)


def join(parts: dict[int, Any]) -> Any:
    """Join {p: Integrated} of n parts to one; part p holds the speeds p, p + n, ..."""
    seconds = sum(part.seconds for part in parts.values())
    if failed := next((part for part in parts.values() if part.result is None), None):
        return failed._replace(seconds=seconds)
    whole = _joined({first: part.result for first, part in parts.items()})
    others = {
        name: _joined({first: part.checks[name] for first, part in parts.items()})
        for name in parts[0].checks
    }
    return Integrated(whole, seconds, checks=others)


def _joined(parts: Any) -> Any:
    """Join {p: SweepResult} of n parts to one."""
    n, n_strips = parts[0].wear.around.shape[:2]
    whole = SweepResult.empty(n, n_strips, parts[0].observed)
    for first, part in parts.items():
        whole.take(slice(first, None, len(parts)), part)
    return replace(whole, n_steps=sum(part.n_steps for part in parts.values()))


def reference_of(file: ResultFile, problem: Problem | None) -> Reference | None:
    """Reference of the amplitudes in a file; None while the tuned disk is not complete.

    problem: None where parts are merged.
    """
    names = "tuned/reference_amplitude_m", "tuned/linear_amplitude_m"
    contact, linear = (float(file.read(name)) for name in names)
    if np.isnan(linear):
        return None
    size = problem.scene.clearance + problem.scene.casing.highest if problem else 0.0
    if "tuned/symmetric_peak_m" in file and file.read("tuned/symmetric_peak_m") <= ROUNDING * size:
        contact = float(file.read("tuned/symmetric_peak_m"))  # all motion is of unlike blades
    return Reference(contact, linear, ROUNDING * size)


def write_tuned(
    config: Config,
    problem: Problem,
    file: ResultFile,
    found: list[Integrated],
    more: dict[str, Any],
) -> None:
    """Write the results of the tuned disk.

    found: all its runs (`tuned_run`); more: further datasets that come before it is complete.
    """
    alike, n = np.zeros(config.disk.n_blades), config.mistuning.tuned_runs
    modes = mistuned_modes(problem.reduced, alike)
    every = [values_of(config, run) for run in found]
    runs, values = every[:n], dict(every[0])
    for equal in every[n:]:
        values["symmetric_amplitude_m"] = equal["amplitude_m"]
        values["symmetric_peak_m"] = equal["peak_amplitude_m"]
    for effect in effects.of(config):
        values |= effect.of_tuned(config, modes, runs)
    values["frequencies_hz"] = modes.omega / (2.0 * np.pi)
    values["run_peaks_m"] = np.array([run["peak_amplitude_m"] for run in runs])
    values["run_amplitude_m"] = np.array([run["amplitude_m"] for run in runs])
    known = finite(values["run_peaks_m"])
    values["reference_amplitude_m"] = np.median(known) if known.size else np.nan
    values["linear_amplitude_m"] = linear_amplitude(config, problem, modes, alike)
    file.write(more, ())
    layout.write_tuned(file, values)


def check_reference(found: Reference, file: ResultFile) -> None:
    """Raise HpcrubError for a reference by which amplitudes cannot be divided.

    Where the casing never reaches the blades that is the answer, and stands for all samples.
    """
    if np.isnan(found.contact):
        reason = file.read("tuned/point_reason")
        why = "; ".join(status.lines(status.count(reason), reason.size))
        raise HpcrubError(
            f"the tuned disk has no result at any speed, nothing to compare samples with: {why}"
        )
    if not found.contact > 0.0:
        layout.write_untouched(file)
    elif not found.usable:
        raise HpcrubError(
            f"the tuned disk moves by {found.contact:.1e} m only, which is rounding: its tips move "
            "radially, and amplitudes are tangential (no lean, no bow, no friction)"
        )
