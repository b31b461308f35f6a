"""What a rub does to a coating: how deep, how much, in how many lobes, and whether it goes on.

The coating only ever wears, so that a motion ends for good when neither it nor the worn depth
changes any more. Until then amplitudes are those of a casing that is being cut.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from hpcrub.contact.status import NOT_STEADY, STEADY
from hpcrub.model.coating import Coating
from hpcrub.response.ensemble import Signals, Verdict, Watch
from hpcrub.response.scene import Scene

REVOLUTIONS = 10  # in which the growth of the worn depth is looked at
ENDED = 1e-3  # growth in these revolutions of wear that has ended, over the largest depth
AT_REST = 0.01  # amplitude of a motion that has died away, over the largest before
FAINT = 0.1  # of the worn depth: what is less beyond the bumps', or of one order, is no lobe
N_ANGLES = 360  # of the worn depths that are kept of every speed


class Wear(NamedTuple):
    """What became of the coating at S speeds; NaN without one."""

    amplitude: np.ndarray  # largest observed displacement at any time, while it wore, too (S,) [m]
    time: np.ndarray  # when, the end of its block (S,) [s]
    depth: np.ndarray  # largest worn depth in the end (S,) [m]
    growth: np.ndarray  # largest growth of any bar in the last revolutions (S,) [m]
    volume: np.ndarray  # worn away (S,) [m³]
    energy: np.ndarray  # that has gone into it (S,) [J]
    lobes: np.ndarray  # of the worn depth, 0 for none (S,) [-]
    around: np.ndarray  # worn depth of Z strips around the casing (S, Z, A) [m]

    @classmethod
    def empty(cls, n: int, n_strips: int) -> "Wear":
        """Of n speeds, not known yet; n_strips: of the coating, 0 without one."""
        around = np.full((n, n_strips, N_ANGLES), np.nan)
        values: tuple[Any, ...] = *np.full((7, n), np.nan), around
        return cls(*values)


class Wearing(Watch):
    """Watches a lane on a coating: by another rule of `ensemble`, until nothing wears any more."""

    always = True

    def __init__(self, rule: Any, scene: Scene) -> None:
        """Nothing is worn yet; scene: at the lane's speed."""
        self.rule, self.scene = rule, scene
        self.largest, self.time = 0.0, 0.0
        self.depths: list[tuple[int, np.ndarray]] = []  # revolutions, worn depth of every bar

    def see(self, amplitude: float, time: float) -> None:
        """As `Watch.see`."""
        if amplitude > self.largest:
            self.largest, self.time = amplitude, time

    def keep(self, revolutions: int, worn: np.ndarray) -> None:
        """As `Watch.keep`."""
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
        """As `Watch.write`."""
        worn = self.depths[-1][1]
        coating, radius = self.scene.coating, float(self.scene.interface.radius.max())
        assert coating is not None  # what wears is one
        grown = self.largest, self.time, worn.max(), self.growth
        lost = volume(worn, coating, radius), energy(worn, coating, radius)
        shape = lobes(worn, self.scene), around(worn)
        for array, value in zip(wear, (*grown, *lost, *shape), strict=True):
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


def cut_at_rest(scene: Scene, n_strips: int, n_bars: int) -> np.ndarray:
    """Depths (Z, S) [m] that bumps and profile press into the coating where no blade moves."""
    face, coating = scene.interface, scene.coating
    assert coating is not None
    phi = 2.0 * np.pi * np.arange(n_bars) / n_bars
    own = np.full(n_strips, np.inf)
    np.minimum.at(own, face.strip, face.clearance)
    beyond = scene.casing.height(phi) - scene.clearance - own[:, None] - coating.depth_at_yield
    return np.clip(coating.kept * beyond, 0.0, coating.thickness)


def lobes(worn: np.ndarray, scene: Scene) -> int:
    """Lobes of worn depths (Z, S) [m] around the casing; scene: at their speed.

    Returns strongest order of what is worn deeper than blades at rest would have cut; 0 where as
    good as nothing is deeper, or the depth is the same all around.
    """
    beyond = np.maximum(worn - cut_at_rest(scene, *worn.shape), 0.0).mean(axis=0)
    size = np.abs(np.fft.rfft(beyond))
    if beyond.max() <= FAINT * worn.max() or 2.0 * size[1:].max() <= FAINT * size[0]:
        return 0
    return 1 + int(size[1:].argmax())


def around(worn: np.ndarray) -> np.ndarray:
    """Largest of the worn depths (Z, S) [m] in N_ANGLES equal parts of a turn (Z, N_ANGLES)."""
    n_strips, n_bars = worn.shape
    part = np.arange(n_bars) * N_ANGLES // n_bars
    found = np.zeros((n_strips, N_ANGLES))
    np.maximum.at(found.T, part, worn.T)
    return found
