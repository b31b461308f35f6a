"""Second order of the built-in planar disk: its frame elements, made corotational.

An element between two nodes stretches by e = l − L and bends by t₁, t₂, the turns of its ends less
that of its chord. With the motion of its second end relative to the first, a along and w across
the element, and the turns r₁, r₂ of its ends, e = a + w²/2L and t = r − w/L + a w/L² to second
order, so that its energy EA e²/2L + 2EI (t₁² + t₁t₂ + t₂²)/L has the cubic part

    a w [EA w/2L² + 6EI (r₁ + r₂ − 2w/L)/L³],

a product of three linear forms. V₃ is the sum of their products over all orders, exactly what
differences of the tangent stiffness tend to.

The turn of a blade's root by the ring is a fourth "bent" mode, whose amplitude is an angle: it
bends nothing, but turns the motion of a bent blade, and what a force does to it.
"""

from itertools import permutations
from typing import Any

import numpy as np
from scipy.linalg import eigh

from hpcrub.model import elements
from hpcrub.model.disk import Disk
from hpcrub.model.second_order import N_BENT, SecondOrder

_ROOT = 3  # first dof of a blade, which move its root


def planar_second_order(disk: Disk, basis: np.ndarray, section: Any, material: Any) -> SecondOrder:
    """Second order of the planar disk, whose amplitude is the tangential motion of the tips.

    - disk: tuned, as `build_disk` makes it of section and material, which describe it.
    - basis: (n, m) from the coordinates of the reduced model to the dof of the disk.
    """
    blade = disk.blade_dof[0]
    K = disk.blade_stiffness[0][_ROOT:]
    mass = disk.mass[np.ix_(blade[_ROOT:], blade[_ROOT:])]
    values, modes = eigh(K[:, _ROOT:], mass, subset_by_index=[0, N_BENT - 1])

    tip = np.eye(len(K))[:, -3:-1]  # forces along u_r and u_t
    seen = modes[-3:-1].T / values[:, None]  # (p, 2)
    static = np.linalg.solve(K[:, _ROOT:], tip) - modes @ seen
    nodes = disk.points.position[disk.points.blades[0]]  # in the frame of the first blade's tip
    motions = np.zeros((len(nodes), 3, N_BENT + 3))
    motions[1:, :, :N_BENT] = modes.reshape(-1, 3, N_BENT)
    motions[..., N_BENT] = _turn_about_root(nodes)
    motions[1:, :, -2:] = static.reshape(-1, 3, 2)
    thickness, E = section.blade.thickness, material.young_modulus
    beam = elements.rectangular_beam(section.width, thickness, E, material.density)
    third = third_derivative(nodes, beam, motions)
    coupling = third[:-2, :-2, :-2]
    radial, tangential = third[-2:, :-2, :-2]

    n_points = len(disk.contact_radius)
    shortening = np.array([radial, tangential, np.zeros_like(radial)])
    of_blade = np.vstack([modes.T @ K / values[:, None], np.zeros(len(blade))])
    of_blade[-1, :_ROOT] = 0.0, -1.0, 1.0 / section.hub_radius  # the ring turns the root
    return SecondOrder(
        participation=of_blade @ basis[disk.blade_dof],
        shortening=np.repeat(shortening[None], n_points, axis=0),
        observed=np.repeat(tangential[None], n_points, axis=0),
        coupling=coupling,
        omega=np.append(np.sqrt(values), np.inf),
        curvature=1.0 / disk.contact_radius,
        motion=np.repeat(motions[-1:, 1, :-2], n_points, axis=0),
    )


def _turn_about_root(nodes: Any) -> Any:
    """Motion (n + 1, 3) of all nodes of a blade that turns about its root, without strain."""
    x, y = (nodes - nodes[0]).T
    return np.stack([-y, x, np.ones(len(nodes))], axis=1)


def third_derivative(nodes: np.ndarray, beam: elements.Beam, motions: np.ndarray) -> np.ndarray:
    """Third derivative V₃ of the energy of a chain of corotational elements, at rest.

    nodes: (n + 1, 2) from the root on [m]; beam: their section; motions: (n + 1, 3, k), of every
    node the two displacements in the frame of `nodes` and the rotation.
    Returns V₃ of all triples of motions (k, k, k), symmetric in all three.
    """
    edges = np.diff(nodes, axis=0)
    length = np.hypot(*edges.T)
    axis = edges / length[:, None]
    relative, turn = np.diff(motions[:, :2], axis=0), motions[1:, 2] + motions[:-1, 2]

    along = np.einsum("ex,exk->ek", axis, relative)
    across = np.einsum("ex,exk->ek", axis @ [[0.0, 1.0], [-1.0, 0.0]], relative)
    L = length[:, None]
    force = beam.axial * across / (2 * L**2) + 6 * beam.bending * (turn - 2 * across / L) / L**3
    product = np.einsum("ea,eb,ec->abc", along, across, force)
    orders = permutations(range(3))
    return np.sum([np.transpose(product, order) for order in orders], axis=0)
