"""Frequency response of one sample: many angular speeds, integrated a band at a time (`band`)."""

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from hpcrub.contact import status
from hpcrub.contact.status import DIVERGED, STEADY
from hpcrub.model.reduction import Modes
from hpcrub.response.band import Band
from hpcrub.response.casing_motion import CasingMotion
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


class SweepResult(NamedTuple):
    """Frequency response of one sample over S speeds."""

    amplitude: np.ndarray  # (S,) largest observed displacement [m]; NaN where diverged
    error: np.ndarray  # (S,) standard error of the amplitude [m]; NaN: unknown
    scatter: np.ndarray  # (S,) standard deviation of the windows' amplitudes [m]; NaN: unknown
    half_peak_to_peak: np.ndarray  # (S,) largest of any observed displacement, last window [m]
    # (S,) largest |stress| of the last window, on a coating at any time [Pa]; NaN: not observed
    stress: np.ndarray
    time: np.ndarray  # (S,) simulated [s]
    shows: np.ndarray  # (S,) time at which a wave that still grows will show [s]; NaN: none grows
    localisation: np.ndarray  # (S,) [-]
    point_status: np.ndarray  # (S,) uint8: NO_POINT, STEADY, NOT_STEADY, DIVERGED, AVERAGED
    point_reason: np.ndarray  # (S,) uint8: code of ``status``
    max_sweeps: np.ndarray  # (S,) uint8: most sweeps of the multiplier solver in a step
    casing: CasingMotion
    wear: Wear
    n_steps: int = 0  # time steps of all speeds together

    @classmethod
    def empty(cls, n: int, n_strips: int = 0) -> "SweepResult":
        """Result of n speeds that are not integrated yet; n_strips: of a coating."""
        numbers, codes = np.full((8, n), np.nan), np.zeros((3, n), dtype=np.uint8)
        numbers[5] = 0.0  # time
        motions = CasingMotion(*np.full((4, n), np.nan)), Wear.empty(n, n_strips)
        values: tuple[Any, ...] = *numbers, *codes, *motions
        return cls(*values)

    @property
    def arrays(self) -> tuple[np.ndarray, ...]:
        """All arrays with a row for every speed."""
        return *self[:11], *self.casing, *self.wear

    def take(self, speeds: Any, other: "SweepResult") -> None:
        """Copy the response at some speeds (an index) from another result (self is modified)."""
        for values, new in zip(self.arrays, other.arrays, strict=True):
            values[speeds] = new[speeds]

    def continued(self, reason: np.ndarray) -> "SweepResult":
        """Result without the points that failed in a later run; reason: its codes (S,)."""
        lost = status.are_fatal(reason) & (self.point_status != DIVERGED)
        names = "amplitude", "localisation", "error", "scatter", "half_peak_to_peak", "stress"
        kept: dict[str, Any] = {n: np.where(lost, np.nan, getattr(self, n)) for n in names}
        return self._replace(
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
    """
    speeds_hz = np.asarray(speeds_hz, dtype=float)
    n = len(speeds_hz)
    out, n_steps = SweepResult.empty(n, scene.n_strips), 0
    wanted = set(range(n) if selection is None else selection)
    if motion is None:
        still = [i for i in wanted if not can_touch(scene.at(speeds_hz[i]))]
        _leave_at_rest(out, still, scene)
        wanted -= set(still)
    for band in speed_bands(speeds_hz):
        grid = cut_revolution(speeds_hz[band[0]], scene)
        # fastest first: they take longest to settle, and should not be left to the last lanes
        waiting = [i for i in band[::-1] if i in wanted]
        if waiting:
            n_lanes = width or enough(scene.lanes, len(waiting))
            lanes = Band(modes, scene, grid, speeds_hz, n_lanes, motion)
            n_steps += lanes.run(waiting, out, poll)
    return out._replace(n_steps=n_steps)


def _leave_at_rest(out, still, scene):
    """Write the response at speeds (indices) at which nothing touches (out is modified)."""
    known = 0.0 if scene.steady.rule == "ensemble" else np.nan
    no_stress = 0.0 if scene.observes_stress else np.nan
    at_rest = 0.0, known, known, 0.0, no_stress, 0.0, np.nan, 0.0, STEADY
    for values, rest in zip(out[:9], at_rest, strict=True):
        values[still] = rest
    out.casing.largest[still] = 0.0
    if scene.coating:
        for values in out.wear:
            values[still] = 0.0
