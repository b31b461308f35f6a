"""Sections of the input that only one or two studies read."""

import pkgutil
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from hpcrub.config.types import (
    MOST_SAMPLES,
    Curve,
    Deviations,
    Number,
    Section,
    Switch,
    Whole,
    si,
)

_MODULES = pkgutil.iter_modules([str(Path(__file__).parents[1] / "studies")])
# every module of `hpcrub/studies` but `shared` is a study of that name
STUDY_NAMES = tuple(sorted(module.name for module in _MODULES if module.name != "shared"))
if TYPE_CHECKING:
    StudyName = str
else:
    StudyName = Literal[STUDY_NAMES]
Diameter = Annotated[Whole, Field(ge=1, le=100)]
Bound = Annotated[Whole, Field(ge=0, le=MOST_SAMPLES)]
Diameters = Annotated[tuple[Diameter, ...], Field(min_length=1, max_length=100)]
Bounds = Annotated[tuple[Bound, ...], Field(min_length=2, max_length=2)]
Rate = Annotated[Number, Field(gt=0, le=1e4)]
Rates = Annotated[tuple[Rate, ...], Field(max_length=20)]
MOST_VALUES = 1025  # of a threshold study


class Checklist(Section):
    """Which disks are computed again with one thing changed after the other."""

    disks: Whole = Field(8, ge=1, le=10_000)
    """mistuned disks beside the tuned one, the first samples of the last level"""


class Patterns(Section):
    """Which pattern of blade types makes mistuned disks vibrate least."""

    types_percent: Annotated[Deviations, Field(max_length=3)] = (2.0, -2.0)
    """deviations of stiffness of the two or three types of blades, beneath the random part [%]"""
    candidates: Whole = Field(2000, ge=2, le=20_000)
    """most patterns that are tried; where there are more, those that repeat themselves around the
    disk, random ones, and a quarter by a search around the best of these"""
    percentile: Number = Field(99.0, gt=0, lt=100)
    """percentile of the linear amplification by which patterns are ranked [%]"""
    kept: Whole = Field(8, ge=1, le=1000)
    """patterns that are left in the end"""
    contact_samples: Whole = Field(0, ge=0, le=MOST_SAMPLES)
    """disks of each of these, and of the disk without a pattern, that are computed in contact"""


class Threshold(Section):
    """Which value of a key meets the limits."""

    key: str | None = None
    """key of the input whose value is searched for, such as casing.clearance_mm,
    casing.clearance_offset_mm where the clearance depends on speed or time, or
    casing.harmonics[0].amplitude_mm, an element of a list counted from 0"""
    lowest: Number = 0.0
    """lowest value, in the unit of the key"""
    highest: Number = 1.0
    """highest value"""
    tolerance: Number = Field(0.05, gt=0)
    """width of the range in which the value is found, in the unit of the key; the values that are
    tried are half of it apart, or less"""
    probability: Number = Field(0.01, gt=0, lt=1)
    """probability of exceeding one of limits, that is to be met [-]"""

    @property
    def values(self) -> np.ndarray:
        """Values that may be tested (V,), evenly spaced."""
        steps = np.ceil(2.0 * (self.highest - self.lowest) / self.tolerance - 1e-9)
        n = 1 + int(np.clip(steps, 1, MOST_VALUES - 1))
        return np.round(np.linspace(self.lowest, self.highest, n), 10)


class RunUp(Section):
    """How the rotor gains and loses speed."""

    from_hz: Number | None = Field(None, ge=1e-6, le=1e5)
    """speed at the begin; null: speeds.from_hz [Hz]"""
    to_hz: Number | None = Field(None, ge=1e-6, le=1e5)
    """speed at the end, or where the rotor turns back; below from_hz for a run-down; null:
    speeds.to_hz [Hz]"""
    hz_per_s: Rates = ()
    """gain of speed; several values are runs of their own; none: 1 Hz/s [Hz/s]"""
    hold_s: Number = Field(0.0, ge=0, le=1e6)
    """time at to_hz [s]"""
    back: Switch = False
    """whether the rotor comes back to from_hz in the end, at the same rate; a table says so, too"""
    passes: Whole = Field(1, ge=1, le=100)
    """times that the rotor goes to to_hz, coming back in between, as for running in a coating"""
    speed_s_hz: Curve | None = None
    """speed over the time in place of all these: points of a time, from 0 on [s], and a speed [Hz],
    with straight lines between them; or a file with columns time_s and speed_hz"""
    repeats: Whole = Field(8, ge=1, le=8)
    """repetitions of every run of a disk, which begin at evenly spaced angles of the casing"""
    interval_hz: Number | None = Field(None, ge=1e-6, le=1e5)
    """width of the intervals of speed in which the largest displacements are kept; null: a 50th of
    the range [Hz]"""


class Part(Section):
    """What the file of a part of a study holds."""

    samples: Bounds | None = None
    """first sample of a part, counted from 0, and the first after it; null: all"""


class Linear(Section):
    """Loads of a linear study."""

    n_diameters: Diameters = (1, 2, 3, 4, 5, 6)
    """nodal diameters of the loads of a linear study"""


class History(Section):
    """Length and records of whole histories."""

    duration_s: Number = Field(1.0, gt=0, le=1000)
    """time that time_response and interaction_map simulate [s]"""
    record_interval_s: Number | None = Field(None, ge=1e-12, le=1)
    """longest time between two records, in the windows that energy and branches look at, too; one
    step at least; null: 8e-5, or a 20th of the blades' first period where that is shorter [s]"""


class Spectrum(Section):
    """Frequencies of an interaction map."""

    max_frequency_hz: Number = Field(200.0, gt=0, le=1e5)
    """highest frequency of an interaction map [Hz]"""
    step_hz: Number = Field(0.5, ge=1e-3, le=1e4)
    """its step of frequencies [Hz]"""
    window_s: Number = Field(0.5, gt=0, le=1000)
    """end of each history that is transformed [s]"""

    @property
    def n_frequencies(self) -> int:
        """Number of frequencies, zero included."""
        return int(self.max_frequency_hz / self.step_hz + 1e-6) + 1


class Energy(Section):
    """Samples of an energy study."""

    samples: Whole = Field(100, ge=1, le=100_000)
    """samples of an energy study, those with the largest A_nl"""


class Branches(Section):
    """Initial states of a branches study."""

    perturbed: Whole = Field(2, ge=0, le=100)
    """random initial states of a branches study"""
    perturbation_mm: Number = Field(20.0, gt=0, le=1e4)
    """their largest displacement of a tip [mm]"""

    perturbation: ClassVar = si("perturbation_mm", "m", per=1000)
