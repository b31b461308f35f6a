"""One clamped blade of the reference disk: with exact rotations, and as modes of second order."""

from functools import cache

import numpy as np
from scipy.linalg import eigh

from evidence.truth.corotational import planar_blade
from evidence.truth.disk import MATERIAL, disk_section, make_disk
from evidence.truth.exact_rubbing import of_blade
from hpcrub.model.interface import planar_interface
from hpcrub.model.reduction import Modes
from hpcrub.model.second_order_planar import planar_second_order


@cache
def clamped(bow):
    """A blade of a bow [-]: its `exact_rubbing.Structure`, Modes and Interface of second order."""
    section, disk = disk_section({"bow": bow}), make_disk({"bow": bow})
    blade, mass = planar_blade(section, MATERIAL)
    own = disk.blade_dof[0][3:]
    values, modes = eigh(disk.stiffness[np.ix_(own, own)], mass)
    basis = np.zeros((len(disk.mass), len(values)))
    basis[own] = modes
    model = planar_second_order(disk, basis, section, MATERIAL)
    of_points = "participation", "shortening", "observed", "curvature", "motion"
    second = model._replace(**{name: getattr(model, name)[:1] for name in of_points})
    radius = disk.contact_radius[0]
    normal, tangential = modes[-3:-2], modes[-2:-1]
    face = planar_interface(np.zeros(1), radius, normal, tangential)
    face = face._replace(second_order=second, axial=np.zeros_like(normal))
    of_small = Modes.planar(np.sqrt(values), normal, tangential)
    return of_blade(blade, mass, radius), of_small._replace(axial=face.axial, bent=face.bent), face
