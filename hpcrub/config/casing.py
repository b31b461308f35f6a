"""Section `casing` of the input: shape, clearance, bump ramp, and vibration of the casing."""

from math import pi
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, PrivateAttr, model_validator

from hpcrub.config.text import counted
from hpcrub.config.types import Curve, FileName, Increasing, Number, Section, Whole, si
from hpcrub.errors import InputError
from hpcrub.model.casing import BUMP_WIDTH, CasingShape, Outline, Profile, outline

MOST_POINTS = 3600  # most points of a measured profile: one at every tenth of a degree
SMOOTHED = 50  # default cut-off, in waves around the casing, at which smoothing halves heights
PROFILES = "harmonics", "profile_csv", "profile_mm"
MOST_WAVES = 200
Degree = Annotated[Number, Field(ge=0, lt=360)]
Millimetres = Annotated[Number, Field(ge=-1e4, le=1e4)]
Wave = Annotated[Whole, Field(ge=0, le=MOST_WAVES)]
Degrees = Annotated[tuple[Degree, ...], Field(min_length=4, max_length=MOST_POINTS), *Increasing]
Changes = Annotated[tuple[Millimetres, ...], Field(min_length=4, max_length=MOST_POINTS)]
Clearances = Annotated[tuple[Millimetres, ...], Field(min_length=1, max_length=200)]
Waves = Annotated[tuple[Wave, ...], Field(min_length=1, max_length=50)]


class Harmonic(Section):
    """One harmonic of the casing's radius."""

    order: Whole = Field(2, ge=1, le=1000)
    """periods around the casing; 2: an oval"""
    amplitude_mm: Number = Field(0.0, ge=0, le=1e4)
    """largest inward deformation by this harmonic [mm]"""
    phase_deg: Number = Field(0.0, ge=-360, le=360)
    """angle at which it is reached, in the direction of rotation [deg]"""


# Young's modulus [GPa] and density [kg/m³] at room temperature: a steel with 12 % of chromium,
# Ti-6Al-4V, 6061-T6 and Inconel 718
MATERIALS = {
    "steel": (210.0, 7800.0),
    "titanium": (114.0, 4430.0),
    "aluminium": (69.0, 2700.0),
    "nickel": (200.0, 8190.0),
}


class Ring(Section):
    """The casing as an elastic ring of rectangular section, in place of a rigid casing."""

    thickness_mm: Number | None = Field(None, gt=0, le=1e4)
    """radial thickness of the ring; null: the casing is no ring [mm]"""
    width_mm: Number = Field(100.0, gt=0, le=1e5)
    """axial width of the part of the casing that moves, whose mass it sets; between flanges less
    than the whole casing [mm]"""
    radius_mm: Number | None = Field(None, gt=0, le=1e5)
    """radius of the middle of its section; null: its inner face stands at the blade tips [mm]"""
    material: Literal["steel", "titanium", "aluminium", "nickel"] = "steel"
    """material, for whose values at room temperature young_modulus_gpa and density_kg_m3 stand
    unless given: a 12 % chromium steel, Ti-6Al-4V, 6061-T6, Inconel 718"""
    young_modulus_gpa: Number = Field(210.0, ge=1e-6, le=1e5)
    """Young's modulus; that of the material unless given [GPa]"""
    density_kg_m3: Number = Field(7800.0, ge=1e-3, le=1e6)
    """density; that of the material unless given [kg/m³]"""
    damping_ratio: Number = Field(0.005, ge=0, lt=1)
    """damping ratio of every mode of the ring [-]"""
    bed_radial_n_per_m2: Number = Field(0.0, ge=0, le=1e15)
    """stiffness of the bed that holds the ring, radial, per metre of circumference [N/m²]"""
    bed_tangential_n_per_m2: Number = Field(0.0, ge=0, le=1e15)
    """the same along the circumference [N/m²]"""
    waves: Waves = (2, 3, 4, 5, 6, 7, 8)
    """numbers of waves around the circumference that are followed; 1 needs a bed [-]"""

    @model_validator(mode="after")
    def _of_material(self) -> "Ring":
        """Set what the input does not give, which counts as unset: `replace` decides anew."""
        keys = "young_modulus_gpa", "density_kg_m3"
        for key, value in zip(keys, MATERIALS[self.material], strict=True):
            if key not in self.model_fields_set:
                self.__dict__[key] = value
        return self

    young_modulus: ClassVar = si("young_modulus_gpa", "Pa", times=1e9)
    width: ClassVar = si("width_mm", "m", per=1000)


class CasingMode(Section):
    """A pair of modes of the casing, cos nθ and sin nθ, of one frequency."""

    waves: Wave
    """waves around the circumference, n; must be given [-]"""
    frequency_hz: Number = Field(gt=0, le=1e6)
    """natural frequency at rest; must be given [Hz]"""
    modal_mass_kg: Number = Field(gt=0, le=1e9)
    """modal mass of a mode whose largest radial displacement at the contact circle is 1; must be
    given [kg]"""
    tangential_ratio: Number = Field(0.0, ge=-1e3, le=1e3)
    """largest tangential over largest radial displacement there, v = ratio (c sin nθ − s cos nθ)
    beside w = c cos nθ + s sin nθ; about −1/n in bending [-]"""
    damping_ratio: Number = Field(0.005, ge=0, lt=1)
    """damping ratio [-]"""


class Casing(Section):
    """The casing: bumps, harmonics, measured profile, clearance and ramp."""

    n_bumps: Whole = Field(4, ge=1, le=1000)
    """bumps of the casing, n_d"""
    clearance_mm: Number = Field(0.25, ge=0, le=1e4)
    """clearance of tips at rest [mm]"""
    clearance_hz_mm: Curve | None = None
    """clearance over the speed in place of clearance_mm: points of a speed [Hz] and a clearance
    [mm], with straight lines between them; or a file with columns speed_hz and clearance_mm"""
    clearance_s_mm: Curve | None = None
    """clearance over the time of a run-up in place of clearance_mm: points of a time [s] and a
    clearance [mm], with straight lines between them; or a file with columns time_s, clearance_mm;
    at constant speeds its smallest counts"""
    clearance_offset_mm: Millimetres = 0.0
    """addition to the clearance, such as the reserve that a threshold study searches for
    beside clearance_hz_mm or clearance_s_mm [mm]"""
    blade_clearance_mm: Clearances | None = None
    """what each blade has beyond that, such as a blade that is shorter, at every speed; below 0:
    less [mm]"""
    bump_height_mm: Number = Field(1.25, ge=0, le=1e4)
    """height of the bumps; 0 unless given where there are harmonics or a profile [mm]"""
    bump_width: Number = Field(BUMP_WIDTH, ge=1e-3, le=0.25)
    """distance from its crest at which a bump has 1/e of its height, in parts of the pitch [-]"""
    harmonics: Annotated[tuple[Harmonic, ...], Field(max_length=100)] = ()
    """harmonics of the casing's radius, beside the bumps"""
    profile_csv: FileName | None = None
    """file of a measured casing, beside bumps and harmonics; columns angle_deg and
    radius_change_mm"""
    profile_deg: Degrees | None = None
    """angles of its points, filled in when a run begins [deg]"""
    profile_mm: Changes | None = None
    """change of radius there, outward positive, filled in when a run begins [mm]"""
    smoothing_mm: Number | None = Field(None, ge=0, le=1e6)
    """cut-off wavelength along the circumference with which the measured points are smoothed; null:
    a fiftieth of the circumference; 0: straight lines between them [mm]"""
    growth_time_s: Number = Field(0.01, ge=0, le=1e4)
    """time in which the shape grows from a circle [s]"""
    ring: Ring = Ring()
    modes: Annotated[tuple[CasingMode, ...], Field(max_length=100)] = ()
    """modes of a casing that vibrates, from other programs, in place of a ring; filled in from
    modes_csv when a run begins"""
    modes_csv: FileName | None = None
    """file of these modes; columns waves, frequency_hz, modal_mass_kg, tangential_ratio,
    damping_ratio"""

    bump_height: ClassVar = si("bump_height_mm", "m", per=1000)
    growth_time: ClassVar = si("growth_time_s", "s")

    _tip_radius_mm: float = PrivateAttr(500.0)  # of the disk; `Config` fills it in

    @model_validator(mode="before")
    @classmethod
    def _profile_replaces_bumps(cls, data: Any) -> Any:
        """Set the default bump height to 0 where harmonics or a profile are given."""
        if isinstance(data, dict) and any(data.get(key) for key in PROFILES):
            return {"bump_height_mm": 0.0} | data
        return data

    @property
    def is_resolved(self) -> bool:
        """Whether the files of profile and clearance, if any, have been read."""
        curves = self.clearance_hz_mm, self.clearance_s_mm
        return not (self.profile_is_missing or any(isinstance(curve, str) for curve in curves))

    @property
    def vibrates(self) -> bool:
        """Whether the casing is elastic: a ring, or a casing with modes."""
        return self.ring.thickness_mm is not None or bool(self.modes or self.modes_csv)

    @property
    def profile_is_missing(self) -> bool:
        """Whether a file of the profile is given and has not been read yet."""
        return self.profile_csv is not None and self.profile_mm is None

    @property
    def running(self) -> tuple[tuple[float, float], ...] | None:
        """Points of speed [Hz] and clearance [m]; None if the clearance does not depend on speed.

        Raises InputError before the file of the clearance has been read.
        """
        if isinstance(self.clearance_hz_mm, str):
            raise InputError(f"casing.clearance_hz_mm: {self.clearance_hz_mm} is not read yet")
        offset = self.clearance_offset_mm
        if self.clearance_hz_mm is not None:
            return tuple((f, (c + offset) / 1000) for f, c in self.clearance_hz_mm)
        return None

    @property
    def over_time(self) -> tuple[tuple[float, float], ...] | None:
        """Points of time [s] of a run-up and clearance [m]; None if it does not depend on time."""
        if isinstance(self.clearance_s_mm, str):
            raise InputError(f"casing.clearance_s_mm: {self.clearance_s_mm} is not read yet")
        if self.clearance_s_mm is None:
            return None
        offset = self.clearance_offset_mm
        return tuple((t, (c + offset) / 1000) for t, c in self.clearance_s_mm)

    def clearances(self, speeds_hz: float | np.ndarray) -> Any:
        """Clearance [m] at speeds [Hz], of any shape; over the time of a run-up the smallest."""
        alone = (0.0, (self.clearance_mm + self.clearance_offset_mm) / 1000)
        same_at_all = ((0.0, min(c for _, c in self.over_time or (alone,))),)
        return np.interp(speeds_hz, *np.array(self.running or same_at_all).T)

    @property
    def profile(self) -> Profile:
        """Harmonics and measured profile. Raises InputError before the file has been read."""
        if self.profile_is_missing:
            raise InputError(f"casing.profile_csv: {self.profile_csv} has not been read yet")
        harmonics = tuple(
            (h.order, h.amplitude_mm / 1000, h.phase_deg * pi / 180)
            for h in self.harmonics
            if h.amplitude_mm > 0.0
        )
        # other numbers of angles than of changes are told by the checks, beside other mistakes
        points = zip(self.profile_deg or (), self.profile_mm or (), strict=False)
        measured = tuple((a * pi / 180, -r / 1000) for a, r in points)
        cut_off = self.smoothing / self._tip_radius_mm * 1000 if measured else 0.0
        return Profile(harmonics, measured, cut_off)

    @property
    def smoothing(self) -> float:
        """Cut-off wavelength of the measured points [m]."""
        usual = 2.0 * pi * self._tip_radius_mm / SMOOTHED
        return (usual if self.smoothing_mm is None else self.smoothing_mm) / 1000

    @property
    def shape(self) -> CasingShape:
        """Shape of the casing over the circumference."""
        return CasingShape(self.n_bumps, self.bump_height, self.profile, self.bump_width)

    @property
    def outline(self) -> Outline:
        """Properties of the shape that determine loads and time steps."""
        return outline(self.shape)

    @property
    def main_order(self) -> int:
        """Engine order that the casing excites most strongly."""
        orders = self.outline.orders if self.profile.exists else ()
        return orders[0] if orders else self.n_bumps

    @property
    def words(self) -> str:
        """The casing in a few words, for titles."""
        orders, ring = ", ".join(str(h.order) for h in self.harmonics), self.ring.thickness_mm
        words = []
        if len(self.harmonics) == 1:
            words.append(f"harmonic {orders} of {self.harmonics[0].amplitude_mm:g} mm")
        elif orders:
            words.append(f"harmonics {orders}")
        if self.profile_csv:
            words.append(f"profile {Path(self.profile_csv).stem}")
        elif self.profile_mm:
            words.append("measured profile")
        if self.bump_height_mm > 0.0 or not words:
            words.insert(0, counted(self.n_bumps, "bump"))
        if self.vibrates:
            words.append(f"ring of {ring:g} mm" if ring else "casing modes")
        return " + ".join(words)
