"""Second order of the built-in planar disk: its frame elements, made corotational.

An element between two nodes stretches by e and bends by t₁, t₂, the turns of its ends less that of
its chord: its energy is EA e²/2L + 2EI (t₁² + t₁t₂ + t₂²)/L. With a and w, the motion of its
second end relative to the first along and across the element, and σ = r₁ + r₂ − 2w/L of the turns
r₁, r₂ of its ends, the parts of third and fourth order are

    a w [EA w/2L² + 6EI σ/L³],
    w³ [EA w/8L³ + 2EI σ/L⁴] − a² w [(EA/2L³ − 6EI/L⁵) w + 6EI σ/L⁴],

products of linear forms. V₃ and V₄ are the sums of these products over all orders, exactly what
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
    of_blade = np.vstack([modes.T @ K / values[:, None], np.zeros(len(blade))])
    of_blade[-1, :_ROOT] = 0.0, -1.0, 1.0 / section.hub_radius  # the ring turns the root

    nodes = disk.points.position[disk.points.blades[0]]  # in the frame of the first blade's tip
    bent = np.zeros((len(nodes), 3, N_BENT + 1))
    bent[1:, :, :N_BENT] = modes.reshape(-1, 3, N_BENT)
    bent[..., N_BENT] = _turn_about_root(nodes)
    thickness, E = section.blade.thickness, material.young_modulus
    beam = elements.rectangular_beam(section.width, thickness, E, material.density)
    flexibility = np.linalg.inv(K[:, _ROOT:]) - modes / values @ modes.T  # beside the bent modes
    push = _forces_of_pairs(nodes, beam, bent)
    moved = push @ flexibility  # −u_ab of two bent modes (p, p, n)
    radial, tangential = np.moveaxis(moved[..., -3:-1], -1, 0)

    n_points = len(disk.contact_radius)
    shortening = np.array([radial, tangential, np.zeros_like(radial)])
    return SecondOrder(
        participation=of_blade @ basis[disk.blade_dof],
        shortening=np.repeat(shortening[None], n_points, axis=0),
        observed=np.repeat(tangential[None], n_points, axis=0),
        coupling=third_derivative(nodes, beam, bent, bent, bent),
        omega=np.append(np.sqrt(values), np.inf),
        curvature=1.0 / disk.contact_radius,
        motion=np.repeat(bent[-1:, 1], n_points, axis=0),
        quartic=relaxed(fourth_derivative(nodes, beam, bent), push, moved),
        inertia=np.einsum("abi,ij,cdj->abcd", moved, mass, moved)[(np.s_[:N_BENT],) * 4],
    )


def _forces_of_pairs(nodes: Any, beam: Any, bent: Any) -> Any:
    """V₃ of two bent modes and every dof beyond the root (p, p, n): forces on these."""
    n = 3 * (len(nodes) - 1)
    alone = np.zeros((len(nodes), 3, n))
    alone[1:] = np.eye(n).reshape(-1, 3, n)
    return third_derivative(nodes, beam, bent, bent, alone)


def _turn_about_root(nodes: Any) -> Any:
    """Motion (n + 1, 3) of all nodes of a blade that turns about its root, without strain."""
    x, y = (nodes - nodes[0]).T
    return np.stack([-y, x, np.ones(len(nodes))], axis=1)


def _forms(nodes: Any, beam: Any, motions: Any) -> Any:
    """Forms a, w, EI σ (E, k) of every element, and its length (E, 1); motions: (n + 1, 3, k)."""
    edges = np.diff(nodes, axis=0)
    length = np.hypot(*edges.T)
    axis = edges / length[:, None]
    relative, turn = np.diff(motions[:, :2], axis=0), motions[1:, 2] + motions[:-1, 2]
    along = np.einsum("ex,exk->ek", axis, relative)
    across = np.einsum("ex,exk->ek", axis @ [[0.0, 1.0], [-1.0, 0.0]], relative)
    L = length[:, None]
    return along, across, beam.bending * (turn - 2 * across / L), L


def third_derivative(nodes: np.ndarray, beam: elements.Beam, *motions: np.ndarray) -> np.ndarray:
    """Third derivative V₃ of the energy of a chain of corotational elements, at rest.

    nodes: (n + 1, 2) from the root on [m]; beam: their section; motions: three sets (n + 1, 3, k),
    of every node the two displacements in the frame of `nodes` and the rotation.
    Returns V₃ of all triples of motions (k, k, k), each set with a k of its own.
    """
    sets = []
    for each in motions:
        a, w, bends, L = _forms(nodes, beam, each)
        sets.append((a, w, beam.axial * w / (2 * L**2) + 6 * bends / L**3))
    orders = permutations(range(3))
    parts = [[sets[k][form] for k, form in enumerate(order)] for order in orders]
    return np.sum([np.einsum("ea,eb,ec->abc", *part) for part in parts], axis=0)


def fourth_derivative(nodes: np.ndarray, beam: elements.Beam, motions: np.ndarray) -> np.ndarray:
    """Fourth derivative V₄ (k, k, k, k) of one set of motions; see `third_derivative`."""
    a, w, bends, L = _forms(nodes, beam, motions)
    steep = beam.axial * w / (8 * L**3) + 2 * bends / L**4
    short = (6 * beam.bending / L**5 - beam.axial / (2 * L**3)) * w - 6 * bends / L**4
    product = np.einsum("ea,eb,ec,ed->abcd", w, w, w, steep)
    product += np.einsum("ea,eb,ec,ed->abcd", a, a, w, short)
    orders = permutations(range(4))
    return np.sum([np.transpose(product, order) for order in orders], axis=0)


def relaxed(fourth: np.ndarray, push: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Fourth derivative (p, p, p, p) of the energy of bent modes, all other motion at its least.

    fourth: V₄ of the bent modes; push: V₃ φ_a φ_b, a force on every dof (p, p, n); moved:
    displacements by these forces, beside the bent modes (p, p, n).
    """
    pairs = np.einsum("abi,cdi->abcd", push, moved)
    return fourth - pairs - pairs.transpose(0, 2, 1, 3) - pairs.transpose(0, 3, 2, 1)
