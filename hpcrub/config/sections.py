"""Sections of the input that several studies read, without disk, casing and air.

Keys carry the user's unit (`clearance_mm`); the property without the unit (`clearance`) is SI.
Every key has a default, a range and a description here and nowhere else: error messages and the
tables in docs/reference/ are made from them.
"""

from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, Strict, model_validator

from hpcrub.config.types import (
    MOST_SAMPLES,
    Checksum,
    Deviations,
    Levels,
    Number,
    Pattern,
    Percentiles,
    Section,
    Switch,
    Whole,
    si,
)
from hpcrub.errors import InputError
from hpcrub.model.mistuning import Law
from hpcrub.response.steady import SteadyCriteria

CRITERIA = SteadyCriteria()
OwnLaw = Annotated[str, Strict(), Field(pattern=r"^.+\.py:[A-Za-z_]\w*$", max_length=4096)]


class Coating(Section):
    """Abradable coating of the casing, with the law of Legrand et al. (2012).

    The defaults are of the order of a thermally sprayed aluminium-silicon-polyester coating. They
    differ by factors from one coating to the next, and the result depends on them.
    """

    thickness_mm: Number = Field(5.0, ge=1e-3, le=1e3)
    """thickness of the coating [mm]"""
    young_gpa: Number = Field(1.0, ge=1e-6, le=1e5)
    """its Young's modulus [GPa]"""
    yield_mpa: Number = Field(15.0, gt=0, le=1e9)
    """pressure at which the new coating begins to wear [MPa]"""
    hardening_mpa: Number = Field(200.0, ge=0, le=1e9)
    """growth of this pressure per worn share of the thickness; below 0 the forces of a step would
    not be unique [MPa]"""
    tip_area_mm2: Number | None = Field(None, gt=0, le=1e8)
    """area of a blade's tip, shared by its contact points; null: thickness times width of the
    planar disk's blades [mm²]"""

    thickness: ClassVar = si("thickness_mm", "m", per=1000)
    young: ClassVar = si("young_gpa", "Pa", times=1e9)
    yield_stress: ClassVar = si("yield_mpa", "Pa", times=1e6)
    hardening: ClassVar = si("hardening_mpa", "Pa", times=1e6)


class Contact(Section):
    """Contact between blades and casing."""

    law: Literal["rigid", "elastic", "abradable"] = "rigid"
    """what the casing does: nothing, give as a spring and a damper, or carry a coating that wears
    (with or without giving behind it)"""
    kinematics: Literal["small", "second_order"] = "small"
    """displacements of the blades: small, as in the paper, or to second order, with the shortening
    of bent blades and contact where the tips are then"""
    friction: Number = Field(0.15, ge=0, le=10)
    """coefficient of friction [-]"""
    casing_stiffness_n_per_m: Number | None = Field(None, gt=0, le=1e15)
    """stiffness of the casing at a contact point; null: rigid [N/m]"""
    casing_damping_ns_per_m: Number = Field(0.0, ge=0, le=1e12)
    """damping of the casing at a contact point [N s/m]"""
    coating: Coating = Coating()
    own_law: OwnLaw | None = None
    """contact law of one's own in place of the rigid casing's: FILE.py:CLASS"""
    own_law_sha256: Checksum | None = None
    """checksum of its file, filled in when a run begins"""

    @property
    def bends(self) -> bool:
        """Whether displacements of the blades are of second order."""
        return self.kinematics == "second_order"

    @property
    def wears(self) -> bool:
        """Whether the casing carries a coating that wears."""
        return self.law == "abradable"


class Forcing(Section):
    """Engine-order excitation: the load of the linear response."""

    amplitude_n: Number = Field(150.0, ge=1e-9, le=1e9)
    """radial load on every tip, of the linear response; with in_contact during contact, too [N]"""
    in_contact: Switch = False
    """whether the load acts during contact, too: at rest in space like the casing, its crest at the
    angle 0, from the start of a run"""
    engine_order: Whole | None = Field(None, ge=1, le=1000)
    """periods of the load around the casing; null: casing.n_bumps, or the order of a casing of one
    harmonic alone"""

    travels: Literal["forward", "backward"] = "forward"
    """way of the linear response's load over the disk: forward, with the rotation, as in the
    paper's equation (5), or backward, at rest in space like the casing"""

    amplitude: ClassVar = si("amplitude_n", "N")

    @property
    def sense(self) -> int:
        """Sign of the engine orders of `response.linear`."""
        return 1 if self.travels == "forward" else -1


class Speeds(Section):
    """Speeds of rotation that are looked at."""

    from_hz: Number = Field(33.5, ge=1e-6, le=1e5)
    """lowest speed of rotation [Hz]"""
    to_hz: Number = Field(35.5, ge=1e-6, le=1e5)
    """highest speed of rotation [Hz]"""
    step_hz: Number = Field(0.05, ge=1e-6, le=1e5)
    """step of the speeds [Hz]"""
    from_rpm: Number | None = None
    """lowest speed in revolutions per minute, in place of from_hz, as which it is kept [rpm]"""
    to_rpm: Number | None = None
    """highest speed, in place of to_hz [rpm]"""
    step_rpm: Number | None = None
    """step of the speeds, in place of step_hz [rpm]"""

    @model_validator(mode="before")
    @classmethod
    def _in_hertz(cls, data: Any) -> Any:
        """Turn revolutions per minute into revolutions per second."""
        if not isinstance(data, dict):
            return data
        data = dict(data)
        for name in ("from", "to", "step"):
            rpm, hertz = data.get(f"{name}_rpm"), data.get(f"{name}_hz")
            if isinstance(rpm, bool) or not isinstance(rpm, int | float):
                continue  # what is no number is refused as such
            if hertz is not None:
                raise InputError(
                    f"speeds.{name}_rpm: {rpm:g} and speeds.{name}_hz: {hertz} are both given; "
                    "leave one out (a result file has the latter)"
                )
            data[f"{name}_hz"] = data.pop(f"{name}_rpm") / 60.0
        return data

    @property
    def n_values(self) -> int:
        """Number of speeds."""
        # a millionth of a step forgives the rounding of decimal fractions
        return int((self.to_hz - self.from_hz) / self.step_hz + 1e-6) + 1

    @property
    def values_hz(self) -> np.ndarray:
        """Speeds from `from_hz` by `step_hz` (S,) [Hz]; `to_hz` only if a step reaches it."""
        values = np.round(self.from_hz + self.step_hz * np.arange(self.n_values), 10)
        return np.minimum(values, self.to_hz)


class Time(Section):
    """Time integration."""

    scheme: Literal["central_difference", "exact_modal"] = "exact_modal"
    """time integration between contacts"""
    step_s: Number = Field(3.3e-5, ge=1e-12, le=1e-2)
    """longest time step; a revolution gets a whole number; 1e-5 unless given where the casing gives
    or wears (contact.law), from which a tip springs back [s]"""
    steps_per_bump_width: Number = Field(32.0, ge=1, le=1e4)
    """time steps while a tip passes a bump's width at the highest speed, at least; fewer than 12,
    with which 95 % of amplitudes are within 5 %, are marked [-]"""
    steps_per_period: Number = Field(40.0, ge=1, le=1e5)
    """time steps per period of a clamped blade's first bending, at least; fewer than 16 per period
    of the first family, with which 95 % of amplitudes are within 5 %, are marked [-]"""


class SteadyState(Section):
    """When a motion has been followed long enough, and what its amplitude is."""

    rule: Literal["ensemble", "last_window"] = "ensemble"
    """ensemble: mean of the windows' largest amplitudes until it is known to max_error, or the
    motion repeats itself; last_window: the largest of the last window once two are alike, as in the
    paper"""
    max_error: Number = Field(CRITERIA.max_error, gt=0, le=1)
    """rule ensemble: a motion that does not repeat itself is averaged until the standard error of
    its mean is below this part of it; the error said is never below max_amplitude_change [-]"""
    first_check_s: Number = Field(CRITERIA.first_check, gt=0, le=1e4)
    """time of the first check [s]"""
    window_revolutions: Whole = Field(CRITERIA.window_revolutions, ge=1, le=1000)
    """revolutions compared with as many before them"""
    extend_revolutions: Whole = Field(CRITERIA.extend_revolutions, ge=1, le=10000)
    """rule last_window: revolutions to the next check when not yet steady"""
    min_correlation: Number = Field(CRITERIA.min_correlation, ge=0, le=1)
    """a motion is steady when the correlation of the two windows is at least this [-]"""
    max_amplitude_change: Number = Field(CRITERIA.max_amplitude_change, gt=0, le=1)
    """a motion is steady when its amplitude changes by less than this part of it; rule ensemble:
    the change that is still to come counts, which the damping of the slowest mode tells [-]"""
    max_time_s: Number = Field(CRITERIA.max_time, gt=0, le=1e4)
    """simulated time after which a point is given up [s]"""
    confirmations: Whole = Field(CRITERIA.confirmations, ge=1, le=1000)
    """rule last_window: checks passed in succession until steady; 1 in the paper"""

    first_check: ClassVar = si("first_check_s", "s")
    max_time: ClassVar = si("max_time_s", "s")


class Mistuning(Section):
    """Levels, samples and patterns of mistuning."""

    half_range_percent: Levels = (1.0, 2.0, 3.0, 4.0)
    """levels: largest deviation of a blade's stiffness; the last one only unless given for
    threshold and rare [%]"""
    samples: Whole = Field(5000, ge=1, le=MOST_SAMPLES)
    """samples per level; unless given for threshold and rare, as many as their question needs"""
    seed: Whole = Field(2020, ge=0, le=2**63 - 1)
    """seed of the random numbers"""
    tuned_runs: Whole = Field(9, ge=1, le=1000)
    """runs of the tuned disk, whose median amplitude is the reference; 1 in the paper"""
    reference: Literal["staying", "symmetric"] = "staying"
    """blades of these runs, and of the runs of a pattern: staying, each blade by another share of
    1e-4 stiffer or softer, so that only a motion that stays is found; symmetric, all stiffer by one
    share below 3e-4, so that a motion of equal blades is kept though it may not stay, as in the
    paper"""
    checked_samples: Whole = Field(2, ge=0, le=MOST_SAMPLES)
    """first samples of the last level that are integrated with half the time step, and for four
    times as long, too, as the tuned disk is, so that the verdict can say what another step changes,
    and whether motions stay; the tuned disk and at most two of them are computed to second order as
    well, where that may matter; of the disks of threshold and rare every fiftieth, and six of
    studies of trials to second order; 0: no disk is"""
    distribution: Literal["uniform", "normal", "measured"] = "uniform"
    """of a blade's deviation within the half range: uniform as in the paper, truncated normal, or
    drawn from the blades of measured_percent"""
    truncation: Number = Field(3.0, ge=1e-3, le=8)
    """standard deviations of a normal distribution per half range"""
    measured_percent: Deviations | None = None
    """measured deviations of blades, drawn with replacement; scaled so that the largest is the half
    range [%]"""
    neighbour_correlation: Number = Field(0.0, ge=0, le=0.99)
    """correlation of two neighbouring blades [-]"""
    intentional_percent: Deviations | None = None
    """intentional mistuning beneath the random part, repeated around the disk: two values for an
    A/B pattern, one for each blade for a sorted one [%]"""
    pattern: Pattern | None = None
    """a value for each blade: one explicit sample, not random; or a CSV file with a row for each
    disk, which is one sample, and a column for each blade"""
    pattern_unit: Literal["percent", "gpa", "hz"] = "percent"
    """what it holds: deviations of stiffness [%], Young's moduli [GPa], or frequencies of the
    blades alone [Hz], whose deviations are from the mean of their disk"""
    pattern_sha256: Checksum | None = None
    """checksum of that file, filled in when a run begins"""
    by: Literal["blade_stiffness", "cantilever_modes"] = "blade_stiffness"
    """what deviates: all stiffness of a blade, or that of its cantilever modes (component mode
    mistuning), of a model file only"""

    @property
    def pattern_file(self) -> str | None:
        """Name of a file with many patterns, if one is given."""
        return self.pattern if isinstance(self.pattern, str) else None

    @property
    def law(self) -> Law:
        """Distribution of the deviations of the blades."""
        return Law(
            self.distribution,
            self.truncation,
            tuple(value / 100 for value in self.measured_percent or ()),
            self.neighbour_correlation,
            tuple(value / 100 for value in self.intentional_percent or ()),
        )

    @property
    def largest(self) -> float:
        """Largest possible deviation of a blade on any level [-]."""
        beneath = max((abs(value) / 100 for value in self.intentional_percent or ()), default=0.0)
        return float(self.half_range.max() + beneath)

    @property
    def half_range(self) -> np.ndarray:
        """Half-width of the stiffness deviation on every level (V,) [-]."""
        return np.array(self.half_range_percent) / 100


class Limits(Section):
    """Limits of the vibration; a study tells how probable it is that a fan exceeds them."""

    amplitude_mm: Number | None = Field(None, gt=0, le=1e6)
    """largest tangential displacement of a tip [mm]"""
    stress_mpa: Number | None = Field(None, gt=0, le=1e6)
    """largest stress of a vibrating blade, such as its fatigue strength; computed at the roots of
    planar blades and at the places that a model file knows [MPa]"""
    stress_mpa_per_mm: Number | None = Field(None, gt=0, le=1e6)
    """largest stress in the first family's mode for each millimetre of a tip's tangential
    displacement, in place of computed stresses; too low where other modes take part [MPa/mm]"""
    static_mpa: Number | None = Field(None, ge=0, le=1e6)
    """stress of the rotation at the same place; with strength_mpa it lowers stress_mpa by Goodman's
    line [MPa]"""
    strength_mpa: Number | None = Field(None, gt=0, le=1e6)
    """tensile strength, at which Goodman's line leaves no vibration; of a model file that knows the
    stress of the rotation at its places, it raises the stress of each of them instead [MPa]"""
    probability_error: Number | None = Field(None, ge=0.01, le=1)
    """of a rare study, which ends when half the 95 % interval of the probability of exceeding a
    limit is below this part of the probability [-]"""
    probability_below: Number | None = Field(None, ge=1e-9, lt=1)
    """of a rare study, which ends when this probability is known to be below or above this one, by
    an interval of 99.5 %, which is wider than usual since it is looked at after every round [-]"""

    amplitude: ClassVar = si("amplitude_mm", "m", per=1000)

    @property
    def stress(self) -> float | None:
        """Allowed vibration stress beside the stress of rotation [Pa]; None without a limit."""
        if self.stress_mpa is None or self.static_mpa is None or self.strength_mpa is None:
            return None if self.stress_mpa is None else 1e6 * self.stress_mpa
        return 1e6 * self.stress_mpa * (1.0 - self.static_mpa / self.strength_mpa)

    stress_per_metre: ClassVar = si("stress_mpa_per_mm", "Pa/m", times=1e9)


class Convergence(Section):
    """Percentiles and when they are known well enough."""

    percentiles: Percentiles = (1.0, 50.0, 99.0)
    """percentiles of the amplifications, increasing [%]"""
    z: Number = Field(2.81, gt=0, le=10)
    """normal quantile of the convergence error [-]"""
    step: Whole = Field(10, ge=1, le=1_000_000)
    """samples between two estimates"""
    criterion: Literal["standard_error", "interval"] = "standard_error"
    """error that is compared with the target: equation (6), as in the paper, which is too
    optimistic, or half the confidence interval"""
    target_error: Number = Field(0.005, gt=0, le=1)
    """error of the amplifications' percentiles aimed at [-]"""
    stop_when_converged: Switch = False
    """end the study as soon as all levels are at the target"""
