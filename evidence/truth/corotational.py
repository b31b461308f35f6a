"""A clamped blade of corotational frame elements: exact rotations, small strains in every element.

Every element is a straight beam in a frame that turns with its chord (Crisfield 1991, volume 1,
section 7.3): it stretches by e = l − L and its ends bend by t = r − (turn of the chord), with the
energy EA e²/2L + 2EI (t₁² + t₁t₂ + t₂²)/L. Its mass is that of the place in which it was built.
"""

from typing import NamedTuple

import numba
import numpy as np

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
    from hpcrub.model.disk import build_disk

    disk = build_disk(section, material)
    own = disk.blade_dof[0][3:]
    area = section.width * section.blade.thickness
    E = material.young_modulus
    nodes = disk.points.position[disk.points.blades[0]]
    blade = Blade(nodes, E * area, E * area * section.blade.thickness**2 / 12)
    return blade, disk.mass[np.ix_(own, own)]


@numba.njit
def elastic_force(nodes, axial, bending, u):
    """Elastic force (3n,) [N, N m] at displacements u (3n,), real or complex.

    nodes, axial, bending: members of a Blade. Rows of the root, which rests, are left out.
    """
    force, ux, uy, r = np.zeros_like(u), u[0] * 0, u[0] * 0, u[0] * 0
    for e in range(len(nodes) - 1):
        x0, y0 = nodes[e + 1, 0] - nodes[e, 0], nodes[e + 1, 1] - nodes[e, 1]
        vx, vy, q = u[3 * e], u[3 * e + 1], u[3 * e + 2]
        x, y = x0 + vx - ux, y0 + vy - uy
        L, length = np.sqrt(x0 * x0 + y0 * y0), np.sqrt(x * x + y * y)
        turn = 2 * np.arctan((x0 * y - y0 * x) / (L * length + x0 * x + y0 * y))
        t1, t2, c, s = r - turn, q - turn, x / length, y / length
        N, along = axial * (length - L) / L, 2 * bending / L
        M1, M2 = along * (2 * t1 + t2), along * (t1 + 2 * t2)
        Q = (M1 + M2) / length
        fx, fy = N * c + Q * s, N * s - Q * c
        force[3 * e] += fx
        force[3 * e + 1] += fy
        force[3 * e + 2] += M2
        if e:
            force[3 * e - 3] -= fx
            force[3 * e - 2] -= fy
            force[3 * e - 1] += M1
        ux, uy, r = vx, vy, q
    return force


def tangent(blade, u):
    """Tangent stiffness (3n, 3n) at displacements u (3n,), exact to rounding: complex steps."""
    small = 1e-30
    columns = [elastic_force(*blade, u + small * 1j * one).imag / small for one in np.eye(len(u))]
    return np.transpose(columns)


def equilibrium(blade, load, parts=1):
    """Displacements (3n,) under a dead load (3n,) [N, N m], by Newton, in parts of the load.

    Raises ValueError: they do not converge.
    """
    u = np.zeros(len(load))
    for part in np.arange(1, parts + 1) / parts:
        for _ in range(NEWTON_STEPS):
            left = part * load - elastic_force(*blade, u + 0j).real
            change = np.linalg.solve(tangent(blade, u), left)
            u += change
            if np.abs(change).max() < 1e-13:
                break
        else:
            raise ValueError("the blade finds no equilibrium")
    return u
