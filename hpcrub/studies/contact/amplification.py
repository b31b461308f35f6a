"""What a contact study says of one disk: its peak in contact, its linear peak, all its points."""

from typing import Any, NamedTuple

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.contact.status import AVERAGED, NOT_STEADY, STEADY
from hpcrub.model.reduction import Modes
from hpcrub.response.linear import linear_peak
from hpcrub.response.sweep import SweepResult
from hpcrub.setup.problem import Problem
from hpcrub.studies import worn


class Reference(NamedTuple):
    """What amplitudes are divided by [m]: the median of all tuned runs, and the linear response."""

    contact: float
    linear: float
    rounding: float = 0.0  # up to which `contact` is no amplitude

    @property
    def usable(self) -> bool:
        """Whether an amplitude can be divided by it."""
        return self.contact > self.rounding


def peak(result: SweepResult, speeds_hz: np.ndarray) -> tuple[float, float]:
    """Largest amplitude of a frequency response [m] and its speed [Hz].

    NaN when all points diverged. On a coating it is that of any time: what is left when the motion
    has worn itself free does not say what a blade had to bear.
    """
    amplitude = result.wear.amplitude if result.wear.around.size else result.amplitude
    usable = np.isin(result.point_status, (STEADY, AVERAGED, NOT_STEADY)) & np.isfinite(amplitude)
    if not usable.any():
        return np.nan, np.nan
    best = np.argmax(np.where(usable, amplitude, -np.inf))
    return float(amplitude[best]), float(speeds_hz[best])


def deepest(result: SweepResult, speeds_hz: np.ndarray) -> tuple[float, float]:
    """Largest worn depth of a coating at any speed [m], and that speed [Hz]; NaN without."""
    depth = result.wear.depth
    if not np.isfinite(depth).any():
        return np.nan, np.nan
    best = np.nanargmax(depth)
    return float(depth[best]), float(speeds_hz[best])


def linear_amplitude(config: Config, problem: Problem, modes: Modes) -> float:
    """Largest tip displacement under the linear engine-order excitation of a configuration [m]."""
    scene = problem.scene
    assert config.engine_order is not None  # `contact.problems` sees to it
    order = config.forcing.sense * config.engine_order
    load = config.forcing.amplitude, order, scene.interface
    return linear_peak(modes, scene.damping_ratio, *load, config.disk.n_blades)[0]


def point_values(result: SweepResult) -> dict[str, Any]:
    """Arrays of a frequency response by their names in the result file."""
    return {
        "amplitude_m": result.amplitude,
        "amplitude_error_m": result.error,
        "amplitude_scatter_m": result.scatter,
        "time_s": result.time,
        "localisation": result.localisation,
        "point_status": result.point_status,
        "point_reason": result.point_reason,
        "max_sweeps": result.max_sweeps,
    } | worn.values(result.wear)
