"""Blades with exact rotations that rub in a circular casing with bumps: no penalty, exact geometry.

Central differences take the elastic forces of the blades as they are. At the end of a step forces
close the gaps between tips and wall, where they are then: in polar coordinates, along the wall's
normal there, with friction along its tangent. Only ring and spokes of a disk are linear.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh

from evidence.truth import ring
from evidence.truth.corotational import clamped_force, elastic_force, tangent

CLOSINGS = 4  # solutions for the forces of a step, each at the place that the one before left


class Structure(NamedTuple):
    """n dof and C tips."""

    mass: np.ndarray  # (n, n)
    stiffness: np.ndarray  # of small motion (n, n)
    force: callable  # elastic force (n,) at displacements (n,) [N, N m]
    tips: np.ndarray  # radial and tangential dof (C, 2) int
    angle: np.ndarray  # of the tips (C,) [rad]
    radius: float  # [m]


def of_blade(blade, mass, radius):
    """Structure of a `corotational.Blade` whose root is held; mass (3n, 3n)."""
    K, n = tangent(blade, np.zeros(len(mass))), len(mass)
    tip = np.array([[n - 3, n - 2]])
    return Structure(mass, K, lambda u: clamped_force(blade, u), tip, np.zeros(1), radius)


def of_disk(disk, blade, hub_radius):
    """Structure of a planar Disk with blades of exact rotations, their roots moved by its ring."""
    linear = disk.stiffness.copy()
    for own, K in zip(disk.blade_dof, disk.blade_stiffness, strict=True):
        linear[np.ix_(own, own)] -= K
    c, s = blade.nodes[0] / np.hypot(*blade.nodes[0])
    n = disk.blade_dof.shape[1]
    root = np.eye(n)  # of u, u', v of the ring: moves by u and v, turns by v/R_h - u'
    root[:3, :3] = [[c, 0.0, -s], [s, 0.0, c], [0.0, -1.0, 1.0 / hub_radius]]

    def force(u):
        moved = (u[disk.blade_dof] @ root.T).reshape(-1, n // 3, 3)
        total = linear @ u
        part = elastic_force(blade, moved).reshape(-1, n) @ root
        np.add.at(total, disk.blade_dof, part)
        return total

    radius = disk.contact_radius[0]
    return Structure(disk.mass, disk.stiffness, force, disk.contact_dof, disk.contact_angle, radius)


def rub(structure, wall, speed_hz, h, n, damping_ratio=0.0):
    """Displacements of the tips (n, C, 2) [m] and forces (n, C) [N] after each of n steps.

    wall: `ring.Wall`, at the start, at rest, with a crest at the angle zero; h: [s]; damping_ratio:
    of the modes of small motion.
    """
    mass, tips = structure.mass, structure.tips
    values, modes = eigh(structure.stiffness, mass)
    damper = mass @ modes * (damping_ratio * np.sqrt(values) * h) @ modes.T @ mass  # C h/2
    step = np.linalg.inv(mass + damper)
    keep, push = step @ (mass - damper), h * h * step
    on_tips = np.ascontiguousarray(push[:, tips])  # (dof, C, 2)
    u, d = np.zeros((2, len(mass)))
    places, pressed = np.zeros((n, *tips.shape)), np.zeros((n, len(tips)))
    for k in range(n):
        free = keep @ d - push @ structure.force(u)
        before, u, d = u, u + free, free
        angle, t = structure.angle + 2.0 * np.pi * speed_hz * h * (k + 1), h * (k + 1)
        for _ in range(CLOSINGS):
            depth, normal = meeting(structure.radius, wall, angle, t, u[tips])
            if depth.max() <= 0.0 and not pressed[k].any():
                break
            along = normal + wall.friction * np.stack([-normal[:, 1], normal[:, 0]], axis=1)
            answer = np.einsum("icx,cx->ic", on_tips, along)
            W = np.einsum("cx,cxb->cb", normal, answer[tips])
            pressed[k] = ring.forces(W, depth + W @ pressed[k])
            d = free - answer @ pressed[k]
            u = before + d
        places[k] = u[tips]
    return places, pressed


def meeting(radius, wall, angle, t, u):
    """Penetrations of tips (C,) [m], and outward normals of the wall at them (C, 2).

    angle: of the tips at rest from a crest of the wall (C,) [rad]; t: time [s]; u: displacements
    (C, 2) [m].
    """
    rho, phi = np.hypot(radius + u[:, 0], u[:, 1]), np.arctan2(u[:, 1], radius + u[:, 0])
    around = angle + phi + 1e-6 * np.array([-1.0, 0.0, 1.0])[:, None]
    height = ring.bump.py_func(wall, around, t)
    slope = (height[2] - height[0]) / 2e-6 / rho
    c, s, size = np.cos(phi), np.sin(phi), np.hypot(1.0, slope)
    depth = (rho - radius - wall.clearance + height[1]) / size
    return depth, (np.stack([c - slope * s, s + slope * c]) / size).T
