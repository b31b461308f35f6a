"""Wear of a coating: its depth, volume and lobes, and whether it goes on.

A coating never grows back, so that a motion is over when neither the motion nor the worn depth
changes any more. Until then the amplitudes belong to a casing that is still being cut.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from hpcrub.contact.status import NOT_STEADY, STEADY
from hpcrub.model.coating import Coating
from hpcrub.response.ensemble import Recent, Verdict, Watch
from hpcrub.response.quantities import Quantities, quantity
from hpcrub.response.scene import Scene

REVOLUTIONS = 10  # revolutions over which the growth of the worn depth is taken
ENDED = 1e-3  # growth in these revolutions over the largest depth, below which wear has ended
AT_REST = 0.01  # amplitude over the largest before, below which a motion has died away
FAINT = 0.1  # least depth of lobes over the worn depth, and amplitude of an order over the mean
N_ANGLES = 360  # angles at which a result keeps the worn depths of a speed


@dataclass
class Wear(Quantities):
    """State of the coating at S speeds, at the end of the integration; NaN without a coating."""

    amplitude: np.ndarray = quantity(
        "largest_amplitude_m", "m", "largest tangential displacement of any tip at any time"
    )
    time: np.ndarray = quantity(
        "largest_amplitude_time_s", "s", "when it was that large, to a pitch of the casing"
    )
    depth: np.ndarray = quantity(
        "worn_depth_m", "m", "largest worn depth of the coating in the end"
    )
    growth: np.ndarray = quantity(
        "worn_growth_m", "m", "largest growth of a worn depth in the last ten revolutions or so"
    )
    volume: np.ndarray = quantity(
        "worn_volume_m3", "m3", "volume of coating worn away: depth by arc by width of its strip"
    )
    energy: np.ndarray = quantity(
        "wear_energy_j", "J", "energy that has gone into the wear of this volume"
    )
    lobes: np.ndarray = quantity(
        "lobes", "1", "lobes of the worn depth beyond what blades at rest cut; 0: none"
    )
    around: np.ndarray = quantity(  # (S, Z, N_ANGLES)
        "worn_m", "m", "largest worn depth within an angle of the casing, of each strip"
    )

    @classmethod
    def empty(cls, n: int, n_strips: int) -> "Wear":
        """Wear at n speeds that are not integrated yet; n_strips: of the coating, 0 without one."""
        return cls(**cls.empty_arrays(n, around=(n_strips, N_ANGLES)))


class Wearing(Watch):
    """The rule on a coating: another rule of `ensemble` must be met, and wear must have ended."""

    always = True

    def __init__(self, rule: Any, scene: Scene) -> None:
        """Start with a new coating; scene: at the speed that is watched."""
        self.rule, self.scene = rule, scene
        self.largest, self.time = 0.0, 0.0
        self.depths: list[tuple[int, np.ndarray]] = []  # revolutions, worn depths (Z, S) [m]

    def see(self, amplitude: float, time: float) -> None:
        """Note the largest displacement of the next block [m], which ends at a time [s]."""
        if amplitude > self.largest:
            self.largest, self.time = amplitude, time

    def keep(self, revolutions: int, worn: np.ndarray) -> None:
        """Keep the worn depths (Z, S) [m] of the last REVOLUTIONS; revolutions: since the start."""
        self.depths.append((revolutions, worn))
        while len(self.depths) > 1 and self.depths[1][0] + REVOLUTIONS <= revolutions:
            self.depths.pop(0)

    @property
    def growth(self) -> float:
        """Largest growth of a worn depth in the last REVOLUTIONS, or since the start [m]."""
        now, before = self.depths[-1][1], self.depths[0]
        young = before[0] + REVOLUTIONS > self.depths[-1][0]
        return float((now if young else now - before[1]).max())

    def may_end(self, time: float) -> bool:
        """Whether the next check may end the motion; see `Watch`."""
        return self.rule.may_end(time)

    def look(self, recent: Recent, time: float, over: bool) -> Verdict | None:
        """Verdict once wear has ended; a motion that died away is steady. See `Watch`."""
        verdict, last = self.rule.look(recent, time, over), recent.sizes[1]
        known = verdict is not None and verdict.status != NOT_STEADY
        wears = self.growth > ENDED * float(self.depths[-1][1].max())
        if not wears and (known or last.max() <= AT_REST * self.largest):
            return verdict if known else Verdict(STEADY, last, last.max(), math.nan, math.nan)
        return verdict._replace(status=NOT_STEADY) if over else None

    def write(self, index: int, wear: Wear) -> None:
        """Write the state of the coating; see `Watch.write`."""
        worn = self.depths[-1][1]
        coating, radius = self.scene.coating, float(self.scene.interface.radius.max())
        assert coating is not None  # a scene without coating has no Wearing
        wear.amplitude[index], wear.time[index] = self.largest, self.time
        wear.depth[index], wear.growth[index] = worn.max(), self.growth
        wear.volume[index], wear.energy[index] = worn_away(worn, coating, radius)
        wear.lobes[index], wear.around[index] = lobes(worn, self.scene), around(worn)


def worn_away(worn: np.ndarray, coating: Coating, radius: float) -> tuple[float, float]:
    """Volume [m³] and energy [J] of the wear; worn depths (Z, S) and radius of the casing [m]."""
    n_strips, n_bars = worn.shape
    area = coating.width / n_strips * 2.0 * np.pi * radius / n_bars  # of a bar [m²]
    return float(worn.sum() * area), float(coating.energy(worn).sum() * area)


def cut_at_rest(scene: Scene, n_strips: int, n_bars: int) -> np.ndarray:
    """Worn depths (Z, S) [m] that blades at rest would leave, from bumps and profile alone."""
    face, coating = scene.interface, scene.coating
    assert coating is not None
    phi = 2.0 * np.pi * np.arange(n_bars) / n_bars
    own = np.full(n_strips, np.inf)
    np.minimum.at(own, face.strip, face.clearance)
    beyond = scene.casing.height(phi) - scene.clearance - own[:, None] - coating.depth_at_yield
    return np.clip(coating.kept * beyond, 0.0, coating.thickness)


def lobes(worn: np.ndarray, scene: Scene) -> int:
    """Number of lobes of worn depths (Z, S) [m] around the casing; scene: at their speed.

    Returns the strongest order of the depth beyond `cut_at_rest`; 0 where this depth is next to
    nothing, or uniform around the casing.
    """
    beyond = np.maximum(worn - cut_at_rest(scene, *worn.shape), 0.0).mean(axis=0)
    size = np.abs(np.fft.rfft(beyond))
    if beyond.max() <= FAINT * worn.max() or 2.0 * size[1:].max() <= FAINT * size[0]:
        return 0
    return 1 + int(size[1:].argmax())


def around(worn: np.ndarray) -> np.ndarray:
    """Largest worn depth in N_ANGLES equal parts of a turn (Z, N_ANGLES), from (Z, S) [m]."""
    n_strips, n_bars = worn.shape
    part = np.arange(n_bars) * N_ANGLES // n_bars
    largest = np.zeros((n_strips, N_ANGLES))
    np.maximum.at(largest.T, part, worn.T)
    return largest
