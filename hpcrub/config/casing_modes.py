"""Sections `casing.ring` and `casing.modes` of the input: a casing that vibrates."""

from typing import Annotated, ClassVar

from pydantic import Field

from hpcrub.config.types import Number, Section, Whole, si

MOST_WAVES = 200
Waves = Annotated[
    tuple[Annotated[Whole, Field(ge=0, le=MOST_WAVES)], ...], Field(min_length=1, max_length=50)
]


class Ring(Section):
    """The casing as an elastic ring of rectangular section, in place of a rigid casing."""

    thickness_mm: Number | None = Field(None, gt=0, le=1e4)
    """radial thickness of the ring; null: the casing is no ring [mm]"""
    width_mm: Number = Field(100.0, gt=0, le=1e5)
    """axial width [mm]"""
    radius_mm: Number | None = Field(None, gt=0, le=1e5)
    """radius of the middle of its section; null: its inner face stands at the blade tips [mm]"""
    young_modulus_gpa: Number = Field(210.0, ge=1e-6, le=1e5)
    """Young's modulus [GPa]"""
    density_kg_m3: Number = Field(7800.0, ge=1e-3, le=1e6)
    """density [kg/m³]"""
    damping_ratio: Number = Field(0.005, ge=0, lt=1)
    """damping ratio of every mode of the ring [-]"""
    bed_radial_n_per_m2: Number = Field(0.0, ge=0, le=1e15)
    """stiffness of the bed that holds the ring, radial, per metre of circumference [N/m²]"""
    bed_tangential_n_per_m2: Number = Field(0.0, ge=0, le=1e15)
    """the same along the circumference [N/m²]"""
    waves: Waves = (2, 3, 4, 5, 6, 7, 8)
    """numbers of waves around the circumference that are followed; 1 needs a bed [-]"""

    young_modulus: ClassVar = si("young_modulus_gpa", "Pa", times=1e9)
    width: ClassVar = si("width_mm", "m", per=1000)


class CasingMode(Section):
    """A pair of modes of the casing, cos nθ and sin nθ, of one frequency."""

    waves: Whole = Field(2, ge=0, le=MOST_WAVES)
    """waves around the circumference, n [-]"""
    frequency_hz: Number = Field(100.0, gt=0, le=1e6)
    """natural frequency at rest [Hz]"""
    modal_mass_kg: Number = Field(100.0, gt=0, le=1e9)
    """modal mass of a mode whose largest radial displacement at the contact circle is 1 [kg]"""
    tangential_ratio: Number = Field(0.0, ge=-1e3, le=1e3)
    """largest tangential over largest radial displacement there, v = ratio (c sin nθ − s cos nθ)
    beside w = c cos nθ + s sin nθ; about −1/n in bending [-]"""
    damping_ratio: Number = Field(0.005, ge=0, lt=1)
    """damping ratio [-]"""
