"""One clamped blade of the reference disk: with exact rotations, and as modes of second order."""

from functools import cache

import numpy as np
from scipy.linalg import eigh

from evidence.truth.corotational import planar_blade
from evidence.truth.disk import MATERIAL, disk_section, make_disk
from evidence.truth.second_order import Structure
from hpcrub.model.second_order_planar import planar_second_order


@cache
def clamped(bow, damping_ratio=0.0):
    """A `corotational.Blade` of a bow [-], its mass, and the `second_order.Structure` of it."""
    section, disk = disk_section({"bow": bow}), make_disk({"bow": bow})
    blade, mass = planar_blade(section, MATERIAL)
    model = planar_second_order(disk, np.eye(len(disk.mass)), section, MATERIAL)
    own = disk.blade_dof[0][3:]
    values, modes = eigh(disk.stiffness[np.ix_(own, own)], mass)
    structure = Structure(
        omega=np.sqrt(values),
        damping_ratio=np.full(len(values), damping_ratio),
        normal=modes[-3:-2],
        tangential=modes[-2:-1],
        axial=np.zeros((0, len(values))),
        blade=np.zeros(1, dtype=int),
        angle=np.zeros(1),
        radius=disk.contact_radius[:1],
        bent=model.participation[:1][..., own] @ modes,
        shortening=model.shortening[:1],
        coupling=model.coupling,
        curvature=model.curvature[:1],
    )
    return blade, mass, structure
