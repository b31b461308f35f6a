"""Section `aero` of the input: damping and frequency of the waves of a family of blade modes."""

from collections import Counter
from collections.abc import Iterator
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from hpcrub.config.types import FileName, Number, Section, Whole

Share = Annotated[Number, Field(gt=-0.5, lt=0.5)]


class AeroWave(Section):
    """A wave of the tuned family, by its nodal diameters and the way it travels over the disk."""

    diameters: Whole = Field(0, ge=0, le=500)
    """nodal diameters [-]"""
    travels: Literal["forward", "backward", "neither"] = "neither"
    """seen from the rotor: forward with the rotation, backward against it, neither with 0 diameters
    or with half as many as blades"""
    damping_ratio: Share = 0.005
    """damping ratio, of structure and air together, at every speed the same share of the frequency
    that the wave has there; give those of the speed that matters; negative: the wave grows [-]"""
    frequency_shift: Share = 0.0
    """change of its frequency by the air, relative, the same at every speed [-]"""


class Influence(Section):
    """What the motion of one blade does to another, as a part of damping and frequency."""

    blades: Annotated[Whole, Field(ge=-500, le=500)] = 0
    """how many blades ahead in the direction of rotation the blade is that moves [-]"""
    damping_ratio: Share = 0.0
    """part in the damping ratio; of the blade itself the mean of all waves [-]"""
    frequency_shift: Share = 0.0
    """part in the relative change of frequency [-]"""


class Aero(Section):
    """Air between the blades of one family, in place of the damping ratio of its modes."""

    family: Annotated[Whole, Field(ge=1, le=20)] = 1
    """family of blade modes whose waves these are [-]"""
    waves: Annotated[tuple[AeroWave, ...], Field(max_length=1000)] = ()
    """all waves of the family, as many as blades; filled in from waves_csv when a run begins"""
    waves_csv: FileName | None = None
    """file of these waves; columns diameters (positive: forward, negative: backward),
    damping_ratio, frequency_shift"""
    influence: Annotated[tuple[Influence, ...], Field(max_length=1000)] = ()
    """influence coefficients, in place of waves"""

    @property
    def exists(self) -> bool:
        """Whether air couples the blades."""
        return bool(self.waves or self.waves_csv or self.influence)

    def table(self, n_blades: int) -> np.ndarray:
        """Damping ratio and frequency shift of waves r = 0 … N−1, counted forward (2, N)."""
        table = np.full((2, n_blades), np.nan)
        for wave in self.waves:
            r = -wave.diameters if wave.travels == "backward" else wave.diameters
            table[:, r % n_blades] = wave.damping_ratio, wave.frequency_shift
        return table


def problems(aero: Aero, n_blades: int) -> Iterator[str]:
    """Error lines about the section for a disk of n_blades."""
    for far in (i.blades for i in aero.influence if abs(i.blades) >= n_blades):
        yield f"aero.influence: {far} blades ahead; a disk of {n_blades} blades has none so far"
    ahead = [influence.blades % n_blades for influence in aero.influence]
    for blades in sorted({b for b in ahead if ahead.count(b) > 1}):
        yield f"aero.influence: {blades} blades ahead is given twice, counted around {n_blades}"
    if not aero.waves:
        return
    known = Counter((wave.diameters, wave.travels) for wave in aero.waves)
    both = range(1, (n_blades + 1) // 2)
    asked = {(h, "neither") for h in (0, n_blades / 2) if h % 1 == 0}
    asked |= {(h, way) for h in both for way in ("forward", "backward")}
    for waves, what in (
        (known.keys() - asked, f"is no wave of {n_blades} blades"),
        ({wave for wave, n in known.items() if n > 1}, "is given twice"),
        (asked - known.keys(), f"is missing; {n_blades} blades have {n_blades} waves"),
    ):
        for h, way in sorted(waves)[:1]:
            yield f"aero.waves: {h:g} nodal diameters, travels: {way}, {what}"
