"""Frequency response of one sample: many angular speeds, integrated a band at a time (`band`)."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from hpcrub.contact import status
from hpcrub.contact.status import DIVERGED, STEADY
from hpcrub.model.reduction import Modes
from hpcrub.response.band import Band, Observers, Point
from hpcrub.response.casing_motion import CasingMotion
from hpcrub.response.quantities import Quantities, quantity
from hpcrub.response.revolution import cut_revolution, speed_bands
from hpcrub.response.scene import Scene, can_touch, enough
from hpcrub.response.wear import Wear


class Motion(NamedTuple):
    """State of every speed at the end of a block, from which a later run can go on."""

    position: np.ndarray  # modal coordinates (S, K) [m·√kg]
    velocity: np.ndarray  # modal velocities, mean over the last step (S, K) [m·√kg/s]
    time: np.ndarray  # since the bumps began to grow (S,) [s]
    memory: np.ndarray  # `memory` of the contact law (S,) of object

    @classmethod
    def at_rest(cls, n_speeds: int, n_modes: int) -> "Motion":
        """Motion of disks at rest, before the bumps begin to grow."""
        still = np.zeros((n_speeds, n_modes))
        return cls(still, still.copy(), np.zeros(n_speeds), np.full(n_speeds, None))


@dataclass(kw_only=True)
class SweepResult(Quantities):
    """Frequency response of one sample over S speeds: arrays (S,), and the number of steps."""

    amplitude: np.ndarray = quantity(
        "amplitude_m",
        "m",
        "largest tangential displacement of any tip over the last revolutions; rule ensemble: its "
        "mean over several windows",
    )
    error: np.ndarray = quantity(
        "amplitude_error_m",
        "m",
        "standard error of amplitude_m by the scatter of its windows; NaN: not known",
        at_rest=np.nan,
    )
    scatter: np.ndarray = quantity(
        "amplitude_scatter_m",
        "m",
        "standard deviation of the windows' amplitudes; NaN: not known",
        at_rest=np.nan,
    )
    half_peak_to_peak: np.ndarray = quantity(
        "half_peak_to_peak_m",
        "m",
        "half of peak to peak, the largest of any tip in the last window, without its offset",
    )
    stress: np.ndarray = quantity(
        "stress_pa",
        "Pa",
        "largest stress of any blade in the last window; on a coating of any time",
        at_rest=np.nan,
    )
    time: np.ndarray = quantity("time_s", "s", "simulated time until steady or given up")
    growth_shows: np.ndarray = quantity(
        "growth_shows_s",
        "s",
        "time at which a wave that still grows at the end will show, so that the motion becomes "
        "another one; NaN: none grows",
        at_rest=np.nan,
    )
    localisation: np.ndarray = quantity(
        "localisation", "1", "localisation factor of the blade-tip amplitudes"
    )
    point_status: np.ndarray = quantity(
        "point_status", "1", status.POINT_STATUS, "u1", at_rest=STEADY
    )
    point_reason: np.ndarray = quantity("point_reason", "1", status.POINT_REASON, "u1")
    max_sweeps: np.ndarray = quantity(
        "max_sweeps",
        "1",
        "most sweeps of the contact force solver in one step; 0: no contact",
        "u1",
    )
    casing: CasingMotion
    wear: Wear
    observed: dict[str, np.ndarray]  # values by the observers of `run_sweep`, (S,) each
    n_steps: int = 0  # time steps of all speeds together

    @classmethod
    def empty(cls, n: int, n_strips: int = 0, observers: Iterable[str] = ()) -> "SweepResult":
        """Result of n speeds that are not integrated yet; n_strips: of a coating."""
        parts = CasingMotion(**CasingMotion.empty_arrays(n)), Wear.empty(n, n_strips)
        observed = {name: np.full(n, np.nan) for name in observers}
        return cls(**cls.empty_arrays(n), casing=parts[0], wear=parts[1], observed=observed)

    def by_name(self) -> dict[str, np.ndarray]:
        """Return {name of the dataset: array (S, ...)} of all quantities."""
        return super().by_name() | self.observed

    def continued(self, reason: np.ndarray) -> "SweepResult":
        """Result without the points that failed in a later run; reason: its codes (S,)."""
        lost = status.are_fatal(reason) & (self.point_status != DIVERGED)
        names = "amplitude", "localisation", "error", "scatter", "half_peak_to_peak", "stress"
        kept: dict[str, Any] = {n: np.where(lost, np.nan, getattr(self, n)) for n in names}
        return replace(
            self,
            **kept,
            point_status=np.where(lost, DIVERGED, self.point_status).astype(np.uint8),
            point_reason=np.where(lost, reason, self.point_reason).astype(np.uint8),
        )


def run_sweep(
    modes: Modes,
    scene: Scene,
    speeds_hz: npt.ArrayLike,
    poll: Callable[[], object] | None = None,
    width: int | None = None,
    selection: Iterable[int] | None = None,
    motion: Motion | None = None,
    observers: Observers = MappingProxyType({}),
) -> SweepResult:
    """Integrate every speed in time to its steady state.

    - modes: of the sample.
    - speeds_hz: (S,) of rotation [Hz].
    - poll: called without arguments after every PIECE of steps, some hundredths of a second; an
      exception from it ends the sweep.
    - width: speeds integrated together, by default as many of `Scene.lanes` as the speeds fill; it
      changes the cost, and not one bit of the result.
    - selection: indices of the speeds to integrate, all by default. A sweep in parts takes the
      same steps, and gives the same bits, as the whole sweep.
    - motion: initial motion, rest by default (modified: it becomes the motion at the end).
    - observers: {name of a quantity: function of the end of a speed}. Its values are `observed` of
      the result; NaN at speeds without an amplitude, and where no blade can touch.
    """
    disk = Disk(modes, selection, motion)
    ((_, result),) = run_sweeps([disk], scene, speeds_hz, poll, width, observers)
    return result


class Disk(NamedTuple):
    """A disk whose response is asked; members as the arguments of `run_sweep`."""

    modes: Modes
    selection: Iterable[int] | None = None
    motion: Motion | None = None


def run_sweeps(
    disks: Sequence[Disk],
    scene: Scene,
    speeds_hz: npt.ArrayLike,
    poll: Callable[[], object] | None = None,
    width: int | None = None,
    observers: Observers = MappingProxyType({}),
) -> Iterator[tuple[int, SweepResult]]:
    """Integrate every speed of several disks, which fill the lanes together.

    disks: of one basis (`model.tuned_basis`), or only one. Other arguments as for `run_sweep`. The
    result of a disk does not depend on the others by one bit.

    Yields (number of the disk, its result) for each disk that is complete.
    """
    speeds_hz = np.asarray(speeds_hz, dtype=float)
    n = len(speeds_hz)
    results = [SweepResult.empty(n, scene.n_strips, observers) for _ in disks]
    waiting: list[Point] = []
    for number, (disk, out) in enumerate(zip(disks, results, strict=True)):
        asked = set(range(n) if disk.selection is None else disk.selection)
        if disk.motion is None:
            asked -= _leave_at_rest(out, asked, speeds_hz, scene)
        # fastest first: they take longest to settle, and should not be left to the last lanes
        order = [i for i in np.argsort(-speeds_hz, kind="stable").tolist() if i in asked]
        waiting += [Point(number, i, disk.modes, out, disk.motion) for i in order]
        if not asked:
            yield number, out
    left = Counter(point.disk for point in waiting)
    for band in speed_bands(speeds_hz):
        points = [point for point in waiting if point.speed in band]
        if not points:
            continue
        n_lanes = width or enough(scene.lanes, len(points))
        grid = cut_revolution(speeds_hz[band[0]], scene)
        lanes = Band(points[0].modes, scene, grid, speeds_hz, n_lanes, observers)
        for point in lanes.run(points, poll):
            left[point.disk] -= 1
            if not left[point.disk]:
                yield point.disk, point.out


def _leave_at_rest(out: Any, wanted: Any, speeds_hz: Any, scene: Scene) -> Any:
    """Write the response at the speeds (indices) at which nothing touches, and return these."""
    still = [i for i in wanted if not can_touch(scene.at(speeds_hz[i]))]
    out.rest(still)
    out.casing.rest(still)
    if scene.steady.rule == "ensemble":
        out.error[still] = out.scatter[still] = 0.0
    if scene.observes_stress:
        out.stress[still] = 0.0
    if scene.coating:
        out.wear.rest(still)
    return set(still)
