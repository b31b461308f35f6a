"""What a rub does to a coating: how deep, how much, in how many lobes, and whether it goes on.

The coating only ever wears, so that a motion ends for good when neither it nor the worn depth
changes any more. Until then amplitudes are those of a casing that is being cut.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from hpcrub.contact.status import NOT_STEADY, STEADY
from hpcrub.model.coating import Coating
from hpcrub.response.ensemble import Signals, Verdict
from hpcrub.response.scene import Scene

REVOLUTIONS = 10  # in which the growth of the worn depth is looked at
ENDED = 1e-3  # growth in these revolutions of wear that has ended, over the largest depth
AT_REST = 0.01  # amplitude of a motion that has died away, over the largest before
FAINT = 1e-3  # order of the worn depth that is no lobe, over the mean depth
N_ANGLES = 360  # of the worn depths that are kept of every speed


class Wear(NamedTuple):
    """What became of the coating at S speeds; NaN without one."""

    amplitude: np.ndarray  # largest observed displacement at any time, while it wore, too (S,) [m]
    time: np.ndarray  # when, the end of its block (S,) [s]
    depth: np.ndarray  # largest worn depth in the end (S,) [m]
    growth: np.ndarray  # largest growth of any bar in the last revolutions (S,) [m]
    volume: np.ndarray  # worn away (S,) [m³]
    energy: np.ndarray  # that has gone into it (S,) [J]
    lobes: np.ndarray  # of the worn depth (S,) [-]
    around: np.ndarray  # worn depth of Z strips around the casing (S, Z, A) [m]

    @classmethod
    def empty(cls, n: int, n_strips: int) -> "Wear":
        """Of n speeds, not known yet; n_strips: of the coating, 0 without one."""
        around = np.full((n, n_strips, N_ANGLES), np.nan)
        values: tuple[Any, ...] = *np.full((7, n), np.nan), around
        return cls(*values)


class Wearing:
    """Watches a lane on a coating: by another rule of `ensemble`, until nothing wears any more."""

    def __init__(self, rule: Any, scene: Scene, coating: Coating) -> None:
        """Nothing is worn yet."""
        self.rule, self.scene, self.coating = rule, scene, coating
        self.largest, self.time = 0.0, 0.0
        self.depths: list[tuple[int, np.ndarray]] = []  # revolutions, worn depth of every bar

    def see(self, amplitude: float, time: float) -> None:
        """Take note of the largest displacement of a block [m], and of its end since the start [s].

        Blocks are seen in order.
        """
        if amplitude > self.largest:
            self.largest, self.time = amplitude, time

    def keep(self, revolutions: int, worn: np.ndarray) -> None:
        """Keep the worn depth of every bar (Z, S) [m] after some revolutions since the start."""
        self.depths.append((revolutions, worn))
        while len(self.depths) > 1 and self.depths[1][0] + REVOLUTIONS <= revolutions:
            self.depths.pop(0)

    @property
    def growth(self) -> float:
        """Largest growth of a worn depth in the last REVOLUTIONS, or since the start [m]."""
        now, before = self.depths[-1][1], self.depths[0]
        young = before[0] + REVOLUTIONS > self.depths[-1][0]
        return float((now if young else now - before[1]).max())

    def look(
        self, before: np.ndarray, last: np.ndarray, signals: Signals, time: float, over: bool
    ) -> Verdict | None:
        """As `ensemble.Windows.look`; a motion that has died away is steady, too."""
        found = self.rule.look(before, last, signals, time, over)
        known = found is not None and found.status != NOT_STEADY
        wears = self.growth > ENDED * float(self.depths[-1][1].max())
        if not wears and (known or last.max() <= AT_REST * self.largest):
            return found if known else Verdict(STEADY, last, last.max(), math.nan, math.nan)
        return found._replace(status=NOT_STEADY) if over else None

    def write(self, index: int, wear: Wear) -> None:
        """What became of the coating, as speed ``index`` of ``wear`` (modified)."""
        worn = self.depths[-1][1]
        radius = float(self.scene.interface.radius.max())
        values = (
            self.largest,
            self.time,
            worn.max(),
            self.growth,
            volume(worn, self.coating, radius),
            energy(worn, self.coating, radius),
            lobes(worn, self.scene.repeats),
            around(worn),
        )
        for array, value in zip(wear, values, strict=True):
            array[index] = value


def element_area(worn: np.ndarray, coating: Coating, radius: float) -> float:
    """Area of a bar of worn depths (Z, S): a step of the radius by the width of a strip [m²]."""
    n_strips, n_bars = worn.shape
    return coating.width / n_strips * 2.0 * np.pi * radius / n_bars


def volume(worn: np.ndarray, coating: Coating, radius: float) -> float:
    """Volume worn away [m³]; worn depths (Z, S) [m], radius of the casing [m]."""
    return float(worn.sum() * element_area(worn, coating, radius))


def energy(worn: np.ndarray, coating: Coating, radius: float) -> float:
    """Energy that has gone into the wear [J]; as `volume`."""
    return float(coating.energy(worn).sum() * element_area(worn, coating, radius))


def lobes(worn: np.ndarray, repeats: int) -> int:
    """Lobes of worn depths around the casing.

    worn: (Z, S) worn depths [m].
    repeats: times that the casing and the load repeat themselves in a turn.
    Returns strongest order that is not a multiple of ``repeats``, which are those of the casing;
    where there is none, or casing and load have all orders, the strongest of all. 0: no wear.
    """
    size = np.abs(np.fft.rfft(worn.mean(axis=0)))
    if not size[0] > 0.0:
        return 0
    size, mean = size[1:], size[0]
    order = np.arange(1, len(size) + 1)
    own = np.where(order % repeats == 0, 0.0, size) if repeats > 1 else size
    if own.max() <= FAINT * mean:
        own = size
    return int(order[own.argmax()])


def around(worn: np.ndarray) -> np.ndarray:
    """Largest of the worn depths (Z, S) [m] in N_ANGLES equal parts of a turn (Z, N_ANGLES)."""
    n_strips, n_bars = worn.shape
    part = np.arange(n_bars) * N_ANGLES // n_bars
    found = np.zeros((n_strips, N_ANGLES))
    np.maximum.at(found.T, part, worn.T)
    return found
