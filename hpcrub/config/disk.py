"""Sections of the input about the disk: its dimensions, material and reduction."""

from math import pi
from typing import ClassVar, Literal

from pydantic import Field

from hpcrub.config.types import Bands, Checksum, FileName, Number, Ratios, Section, Whole, si


class Blade(Section):
    """Blades: a chord that leans and bows."""

    n_elements: Whole = Field(5, ge=1, le=50)
    """beam elements per blade"""
    thickness_mm: Number = Field(13.309, gt=0, le=1e4)
    """thickness of a blade [mm]"""
    lean_deg: Number = Field(-43.74, gt=-90, lt=90)
    """angle of the chord with the radius at the root [deg]"""
    bow: Number = Field(0.07924, ge=-0.5, le=0.5)
    """largest offset from the chord per chord length [-]"""

    thickness: ClassVar = si("thickness_mm", "m", per=1000)
    lean: ClassVar = si("lean_deg", "rad", times=pi, per=180)


class Disk(Section):
    """Dimensions of the bladed disk."""

    n_blades: Whole = Field(12, ge=1, le=200)
    """number of blades; 1 of a model file only"""
    tip_radius_mm: Number = Field(500.0, gt=0, le=1e5)
    """radius of the tips [mm]"""
    hub_radius_mm: Number = Field(200.0, gt=0, le=1e5)
    """radius of the ring [mm]"""
    inner_radius_mm: Number = Field(160.8, gt=0, le=1e5)
    """radius at which the spokes are clamped [mm]"""
    width_mm: Number = Field(100.0, gt=0, le=1e5)
    """axial width of all sections [mm]"""
    ring_thickness_mm: Number = Field(14.25, gt=0, le=1e4)
    """thickness of ring [mm]"""
    spoke_thickness_mm: Number = Field(7.899, gt=0, le=1e4)
    """thickness of spokes [mm]"""
    blade: Blade = Blade()
    model: FileName | None = None
    """model file of any bladed disk (hpcrub import) in place of the planar one; the other keys of
    disk and the material are then not used, but for the damping ratio"""
    model_sha256: Checksum | None = None
    """checksum of the model file, filled in when a run begins"""
    n_contact_nodes: Whole | None = Field(None, ge=1, le=100_000)
    """of the model file, filled in when a run begins"""
    n_directions: Whole | None = Field(None, ge=2, le=3)
    """in which they move, filled in when a run begins"""
    n_strips: Whole = Field(1, ge=1, le=100_000)
    """axial places of contact nodes, each with a strip of a coating of its own; of the model file,
    filled in when a run begins"""
    n_stresses: Whole = Field(0, ge=0)
    """places at which stresses are known; of the model file, filled in when a run begins"""
    static_mpa: Number | None = Field(None, ge=0, le=1e6)
    """largest stress of the rotation at these places, if known; of the model file, filled in when a
    run begins [MPa]"""
    first_family_hz: Number | None = Field(None, gt=0, le=1e6)
    """highest frequency of its first family, filled in when a run begins [Hz]"""
    least_clearance_mm: Number = Field(0.0, ge=-1e4, le=1e4)
    """of a contact node, beside the casing's own; of the model file, filled in when a run begins
    [mm]"""

    second_order_per_m: tuple[Number, ...] | None = Field(None, min_length=2, max_length=2)
    """what bending to second order does in the first mode: shift of a tip outwards over the square
    of its motion, and change of the blade over the motion; of the model file, filled in when a run
    begins; null: the file does not tell [1/m]"""

    tip_radius: ClassVar = si("tip_radius_mm", "m", per=1000)
    hub_radius: ClassVar = si("hub_radius_mm", "m", per=1000)
    inner_radius: ClassVar = si("inner_radius_mm", "m", per=1000)
    width: ClassVar = si("width_mm", "m", per=1000)
    ring_thickness: ClassVar = si("ring_thickness_mm", "m", per=1000)
    spoke_thickness: ClassVar = si("spoke_thickness_mm", "m", per=1000)
    least_clearance: ClassVar = si("least_clearance_mm", "m", per=1000)

    @property
    def is_resolved(self) -> bool:
        """Whether all keys describe the disk: the model file, if there is one, has been read."""
        return self.model is None or self.model_sha256 is not None

    @property
    def n_points(self) -> int:
        """Number of contact points."""
        return self.n_contact_nodes or self.n_blades

    @property
    def n_dof(self) -> int:
        """Number of degrees of freedom of the planar disk."""
        return self.n_blades * (3 * self.blade.n_elements + 5)


class Material(Section):
    """Material and damping."""

    young_modulus_gpa: Number = Field(210.0, ge=1e-6, le=1e5)
    """Young's modulus [GPa]"""
    density_kg_m3: Number = Field(7800.0, ge=1e-3, le=1e6)
    """density [kg/m³]"""
    damping_ratio: Number = Field(0.005, ge=1e-6, lt=1)
    """damping ratio of every mode [-]"""
    damping_ratios: Ratios | None = None
    """damping ratios of single modes, families or bands (damping_of), in place of the one ratio;
    the last is that of all modes above, too [-]"""
    damping_of: Literal["modes", "families", "bands"] = "modes"
    """to what each of damping_ratios belongs: a mode, by increasing frequency; as many modes as
    there are blades; a band of frequencies"""
    damping_bands_hz: Bands | None = None
    """upper ends of the bands but the last, increasing [Hz]"""

    young_modulus: ClassVar = si("young_modulus_gpa", "Pa", times=1e9)
    density: ClassVar = si("density_kg_m3", "kg/m³")


class Reduction(Section):
    """How the disk is reduced."""

    n_modes: Whole = Field(60, ge=0)
    """fixed-interface modes of the Craig-Bampton basis; whole families of modes are kept, the next
    multiple of the number of blades"""
