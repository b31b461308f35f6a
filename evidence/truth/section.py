"""Stress at the roots of planar blades from the forces that hold a blade, not from its strains.

The whole stiffness of a blade tells the force and the moment with which its ring holds it. What
hpcrub observes comes from the strain and the curvature of the first finite element.
"""

from typing import Any

import numpy as np

from evidence.truth.motion import recorded
from hpcrub.contact.bank import allocate
from hpcrub.model.disk import Disk
from hpcrub.model.reduction import Modes
from hpcrub.response.revolution import cut_revolution
from hpcrub.response.scene import Scene


def root_stress(disk: Disk, section: Any, x: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Stress of both faces of every blade's root (N, 2, ...) [Pa].

    section: dimensions of the disk; x: displacements of all its dof (n, ...); deviation: of the
    blades' stiffness (N,).
    """
    held = disk.blade_stiffness @ x[disk.blade_dof].reshape(*disk.blade_dof.shape, -1)
    held = (1.0 + deviation)[:, None, None] * held
    radial, slope, tangential = held[:, 0], held[:, 1], held[:, 2]
    # work of a force and a moment on u, v and the turn v/R - u' of the ring's section
    moment = -slope
    tangential = tangential - moment / section.hub_radius
    root, first = disk.points.position[disk.points.blades[0, :2]]
    axis = (first - root) / np.hypot(*(first - root))
    outward = root / np.hypot(*root)
    around = np.array([-outward[1], outward[0]])
    normal = -(radial * (axis @ outward) + tangential * (axis @ around))
    width, thickness = section.width, section.blade.thickness
    direct, bending = normal / (width * thickness), 6.0 * moment / (width * thickness**2)
    return np.stack([direct + bending, direct - bending], axis=1)


def largest(
    modes: Modes, scene: Scene, speed_hz: float, begin: float, end: float, stress: np.ndarray
) -> float:
    """Largest stress of all steps between two times of a run from rest [Pa].

    begin, end: in revolutions; stress: rows (R, K) [Pa/(m √kg)].
    """
    grid = cut_revolution(speed_hz, scene)
    bank = allocate(modes, scene, grid, 8, [speed_hz])
    first, last = (round(turns * grid.steps_per_revolution) for turns in (begin, end))
    parts = [np.abs(stress @ part.position[..., 0, None]) for part in recorded(bank, last)]
    return float(np.concatenate(parts)[first:].max())
