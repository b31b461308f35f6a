"""Data that all runs of a study share: casing, contact, time integration, steady state."""

import math
from typing import Any, NamedTuple

import numpy as np

from hpcrub.contact.lanes import WIDTH
from hpcrub.contact.protocols import Law
from hpcrub.model.casing import CasingShape
from hpcrub.model.coating import Coating, ElasticCasing
from hpcrub.model.damping import Damping
from hpcrub.model.interface import Interface
from hpcrub.response.steady import SteadyCriteria

RECORD_INTERVAL = 8e-5  # [s] between recorded displacements: 86 per period at 145 Hz


def enough(lanes: tuple[int, ...], n_speeds: int) -> int:
    """Fewest of increasing numbers of lanes that hold so many speeds; the most where none do."""
    return next((n for n in lanes if n >= n_speeds), lanes[-1])


class Scene(NamedTuple):
    """Data of a contact run that all samples and speeds share."""

    interface: Interface
    damping_ratio: float | Damping  # one for all modes, or one for each
    casing: CasingShape
    clearance: float  # [m]; where it changes with the speed, the smallest
    ramp_time: float  # [s]
    friction: float
    # running clearance, which centrifugal growth, untwist and heat change: increasing speeds [Hz]
    # and the clearance at each [m], straight lines between; None: one clearance at every speed
    running: tuple[tuple[float, float], ...] | None = None
    # change of the clearance over the time of a run-up, as `running`: times [s], clearances [m]
    over_time: tuple[tuple[float, float], ...] | None = None
    load: float = 0.0  # radial engine-order excitation of every blade, at rest in space [N]
    load_order: int = 1  # periods of this load around the casing
    elastic_casing: ElasticCasing | None = None  # None: the casing does not give
    coating: Coating | None = None  # coating that wears; None: the bare casing
    law: type[Law] | None = None  # contact law; None: `Planar` or `Solid`, by the disk
    scheme: str = "central_difference"
    step: float = 1e-6  # [s], an upper bound
    least_steps: float = 0.0  # steps of a revolution, a lower bound
    record_interval: float = RECORD_INTERVAL  # [s], an upper bound
    history_interval: float = math.inf  # [s] between two records of a history, likewise
    look_interval: float = 0.0  # [s] between displacements of which the largest counts, likewise
    steady: SteadyCriteria = SteadyCriteria()
    furthest: float = math.inf  # displacement beyond which its second order says nothing [m]
    observes_stress: bool = False  # whether to follow the stresses of the interface, too
    lanes: tuple[int, ...] = (WIDTH,)  # numbers that a sweep may take, increasing; each is compiled

    def at(self, speed_hz: float) -> "Scene":
        """The scene at a speed of rotation [Hz]."""
        if self.running is None:
            return self
        return self._replace(clearance=float(self.clearances(speed_hz)), running=None)

    def clearances(self, speeds_hz: Any, times: Any = 0.0) -> Any:
        """Clearances [m] at speeds [Hz], and at times [s] of a run-up, of one shape."""
        known = self.running or ((0.0, self.clearance),)
        gaps = np.interp(speeds_hz, *np.array(known).T)
        return gaps if self.over_time is None else np.interp(times, *np.array(self.over_time).T)

    @property
    def repeats(self) -> int:
        """Periods of casing and load together in a turn."""
        casing = self.casing.repeats
        return math.gcd(casing, self.load_order) if self.load else casing

    @property
    def divisor(self) -> int:
        """Divisor of the steps of a turn: the blades where they must all meet the same bars."""
        return self.interface.n_blades if self.coating else 1

    @property
    def n_strips(self) -> int:
        """Number of strips of the coating, 0 without a coating."""
        return self.interface.n_strips if self.coating else 0


def can_touch(scene: Scene) -> bool:
    """Whether a disk that starts at rest can ever touch the casing."""
    if scene.load:
        return True
    return scene.casing.highest > scene.clearance + scene.interface.clearance.min()
