"""A clamped blade of corotational frame elements: exact rotations, small strains in every element.

Every element is a straight beam in a frame that turns with its chord (Crisfield 1991, volume 1,
section 7.3): it stretches by e = l − L and its ends bend by t = r − (turn of the chord), with the
energy EA e²/2L + 2EI (t₁² + t₁t₂ + t₂²)/L. Its mass is that of the place in which it was built.
"""

from typing import NamedTuple

import numpy as np

from hpcrub.model.disk import build_disk

NEWTON_STEPS = 60


class Blade(NamedTuple):
    """Nodes from the clamped root to the tip, and the section of the beam between them."""

    nodes: np.ndarray  # (n + 1, 2) radial and tangential place, in the frame of the tip [m]
    axial: float  # EA [N]
    bending: float  # EI [N m2]


def planar_blade(section, material):
    """The Blade of a disk's section (see `truth.disk.disk_section`), and its mass (3n, 3n).

    The mass is that of the linear elements, which the disk has, too.
    """
    disk = build_disk(section, material)
    own = disk.blade_dof[0][3:]
    area = section.width * section.blade.thickness
    E = material.young_modulus
    nodes = disk.points.position[disk.points.blades[0]]
    blade = Blade(nodes, E * area, E * area * section.blade.thickness**2 / 12)
    return blade, disk.mass[np.ix_(own, own)]


def elastic_force(blade, moved):
    """Elastic forces (..., n + 1, 3) on all nodes [N, N m], at displacements of the same shape.

    Both are radial, tangential and of rotation; displacements may be complex.
    """
    first = np.diff(blade.nodes, axis=0)
    edge = first + moved[..., 1:, :2] - moved[..., :-1, :2]
    L, length = np.hypot(*first.T), np.sqrt((edge * edge).sum(axis=-1))
    direction = edge / length[..., None]
    across = first[:, 0] * edge[..., 1] - first[:, 1] * edge[..., 0]
    turn = 2.0 * np.arctan(across / (L * length + (first * edge).sum(axis=-1)))
    t1, t2 = moved[..., :-1, 2] - turn, moved[..., 1:, 2] - turn
    N, along = blade.axial * (length - L) / L, 2.0 * blade.bending / L
    M1, M2 = along * (2.0 * t1 + t2), along * (t1 + 2.0 * t2)
    shear = (M1 + M2) / length
    turned = np.stack([direction[..., 1], -direction[..., 0]], axis=-1)
    on_end = N[..., None] * direction + shear[..., None] * turned
    force = np.zeros_like(moved)
    force[..., 1:, :2] += on_end
    force[..., :-1, :2] -= on_end
    force[..., 1:, 2] += M2
    force[..., :-1, 2] += M1
    return force


def clamped_force(blade, u):
    """Elastic forces (..., 3n) on the nodes beyond the root, which rests, at displacements u."""
    moved = np.zeros((*u.shape[:-1], len(blade.nodes), 3), dtype=u.dtype)
    moved[..., 1:, :] = u.reshape(*u.shape[:-1], -1, 3)
    return elastic_force(blade, moved)[..., 1:, :].reshape(u.shape)


def tangent(blade, u):
    """Tangent stiffness (3n, 3n) at displacements u (3n,), exact to rounding: complex steps."""
    small = 1e-30
    return clamped_force(blade, u + small * 1j * np.eye(len(u))).imag.T / small


def equilibrium(blade, load, parts=1):
    """Displacements (3n,) under a dead load (3n,) [N, N m], by Newton, in parts of the load.

    Raises ValueError: they do not converge.
    """
    u = np.zeros(len(load))
    for part in np.arange(1, parts + 1) / parts:
        for _ in range(NEWTON_STEPS):
            left = part * load - clamped_force(blade, u)
            change = np.linalg.solve(tangent(blade, u), left)
            u += change
            if np.abs(change).max() < 1e-13:
                break
        else:
            raise ValueError("the blade finds no equilibrium")
    return u
