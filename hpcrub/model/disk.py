"""Finite-element model of the bladed disk: ring, clamped spokes, leaned and bowed blades.

The disk is cyclic. Every dof belongs to a polar frame that turns with its sector, so that all
sectors have the same matrices. Sector i has, in this order:

    ring node          u, u', v, v'   (polar at the blade root)
    spoke end          u' of the spoke's axial displacement; u, v and slope are the ring's
    blade nodes 1...   radial, tangential, rotation   (polar at the blade tip, theta_i)

The blade root and the spoke end turn with the ring's section, omega = v/R_h - u'.
"""

from typing import Any, NamedTuple

import numpy as np

from hpcrub.model import elements

_N_RING = 4  # dof of a ring node: u, u', v, v'
_N_FOOT = _N_RING + 1  # dof of a ring node, and the axial derivative of the spoke


class Points(NamedTuple):
    """Nodes of all parts of the disk, with which to draw it and its displacements."""

    position: np.ndarray  # (n_nodes, 2) x, y [m]
    dof: np.ndarray  # (n_nodes, 2) radial and tangential dof, -1 where clamped
    frame: np.ndarray  # (n_nodes,) angle of the polar frame of these dof [rad]
    blades: np.ndarray  # (N, n_elements + 1) nodes of each blade, root to tip
    ring: np.ndarray  # (N, 2) end nodes of each ring element (an arc)
    spokes: np.ndarray  # (N, 2) inner and outer node of each spoke


class Disk(NamedTuple):
    """Full finite-element model of the tuned disk, SI units, n dof, N blades."""

    mass: np.ndarray  # (n, n)
    stiffness: np.ndarray  # (n, n)
    blade_dof: np.ndarray  # (N, nb) dof of each blade
    blade_stiffness: np.ndarray  # (N, nb, nb) part of each blade in the stiffness
    # (N, 2, nb) normal stress on both faces of a blade's root per unit of its dof [Pa/m, Pa]
    blade_stress: np.ndarray
    contact_dof: np.ndarray  # (n_c, 2) u_r, u_t of each contact point
    contact_blade: np.ndarray  # (n_c,) int, blade of each contact point
    contact_angle: np.ndarray  # (n_c,) [rad]
    contact_radius: np.ndarray  # (n_c,) [m]
    points: Points


def build_disk(disk: Any, material: Any) -> Disk:
    """Assemble the tuned bladed disk.

    - disk: any object with the attributes n_blades; tip_radius, hub_radius, inner_radius, width,
      ring_thickness, spoke_thickness [m]; blade.n_elements, blade.thickness [m], blade.lean [rad]
      (chord from the radius through the root, positive towards +theta), blade.bow [-] (offset to
      the chord's left, as a fraction of the chord).
    - material: any object with young_modulus [Pa] and density [kg/m3].

    Raises ValueError: if the leaned chord misses the tip circle.
    Source: Joachim, Nyssen, Batailly (2020), section 2 and figure 1.
    """
    nodes = _blade_nodes(disk)
    blade_mass, blade_stiffness = _blade(disk, material, nodes)
    beam, R_h = _beam(disk, disk.ring_thickness, material), disk.hub_radius
    arc = 2 * np.pi * R_h / disk.n_blades
    ring_mass, ring_stiffness = elements.ring_element(beam, arc, R_h)
    spoke_mass, spoke_stiffness = _spoke(disk, material)

    blade_dof, ring_dof, spoke_dof = _numbering(disk)
    n_dof = blade_dof.max() + 1
    mass, stiffness = np.zeros((n_dof, n_dof)), np.zeros((n_dof, n_dof))
    for dof, m, k in (
        (blade_dof, blade_mass, blade_stiffness),
        (ring_dof, ring_mass, ring_stiffness),
        (spoke_dof, spoke_mass, spoke_stiffness),
    ):
        for d in dof:
            mass[np.ix_(d, d)] += m
            stiffness[np.ix_(d, d)] += k

    return Disk(
        mass=mass,
        stiffness=stiffness,
        blade_dof=blade_dof,
        blade_stiffness=np.repeat(blade_stiffness[None], disk.n_blades, axis=0),
        blade_stress=np.repeat(_root_stress(disk, material, nodes)[None], disk.n_blades, axis=0),
        contact_dof=blade_dof[:, -3:-1],
        contact_blade=np.arange(disk.n_blades),
        contact_angle=_tip_angles(disk),
        contact_radius=np.full(disk.n_blades, float(disk.tip_radius)),
        points=_points(disk, nodes, blade_dof),
    )


def _beam(disk: Any, thickness: Any, material: Any) -> Any:
    E, density = material.young_modulus, material.density
    return elements.rectangular_beam(disk.width, thickness, E, density)


def _tip_angles(disk: Any) -> Any:
    return 2 * np.pi * np.arange(disk.n_blades) / disk.n_blades


def _numbering(disk: Any) -> tuple[Any, Any, Any]:
    """Dof of every blade (N, 3 + 3 n_elements), ring element (N, 8) and spoke (N, 5)."""
    per_sector = _N_FOOT + 3 * disk.blade.n_elements
    first = per_sector * np.arange(disk.n_blades)[:, None]
    root = first + [0, 1, 2]  # u, u', v of the ring
    blade = np.hstack([root, first + np.arange(_N_FOOT, per_sector)])
    ring = first + np.arange(_N_RING)
    ring = np.hstack([ring, np.roll(ring, -1, axis=0)])
    spoke = np.hstack([root, first + _N_RING])
    return blade, ring, spoke


def _blade_nodes(disk: Any) -> Any:
    """Nodes of a blade, root to tip, in the polar frame of its tip, (n_elements + 1, 2) [m]."""
    R, R_h, lean = disk.tip_radius, disk.hub_radius, disk.blade.lean
    if not R_h < R:
        raise ValueError("the blade's chord does not reach the tip circle")
    chord = np.sqrt(R**2 - (R_h * np.sin(lean)) ** 2) - R_h * np.cos(lean)
    root_angle = -np.arcsin(chord * np.sin(lean) / R)  # seen from the tip's radius
    z = np.linspace(0, 1, disk.blade.n_elements + 1)[:, None]
    along = _direction(root_angle + lean)
    left = _direction(root_angle + lean + np.pi / 2)
    offset = 4 * disk.blade.bow * z * (1 - z)
    return R_h * _direction(root_angle) + chord * (z * along + offset * left)


def _blade(disk: Any, material: Any, nodes: Any) -> tuple[Any, Any]:
    """Mass and stiffness of a blade on the dof of `_numbering`: ring u, u', v, then its nodes."""
    beam = _beam(disk, disk.blade.thickness, material)
    n = 3 * len(nodes)
    mass, stiffness = np.zeros((n, n)), np.zeros((n, n))
    for e, edge in enumerate(np.diff(nodes, axis=0)):
        length = np.hypot(*edge)
        turn = np.kron(np.eye(2), _turn_node(edge / length))
        dof = slice(3 * e, 3 * e + 6)
        m, k = elements.frame_element(beam, length)
        mass[dof, dof] += turn.T @ m @ turn
        stiffness[dof, dof] += turn.T @ k @ turn
    to_ring = np.eye(n)
    to_ring[:3, :3] = _root_motion(disk, nodes)
    return to_ring.T @ mass @ to_ring, to_ring.T @ stiffness @ to_ring


def _root_motion(disk: Any, nodes: Any) -> Any:
    """Matrix (3, 3) from ring u, u', v to the motion of a blade's root in the frame of its tip."""
    radial = nodes[0] / np.hypot(*nodes[0])
    return _turn_node(radial).T @ _section_motion(disk.hub_radius)


def _root_stress(disk: Any, material: Any, nodes: Any) -> Any:
    """Stress on both faces of a blade's root per unit dof (2, nb): E (strain ± t/2 curvature)."""
    edge = nodes[1] - nodes[0]
    length = np.hypot(*edge)
    turn = np.kron(np.eye(2), _turn_node(edge / length))
    strain, curvature = (row @ turn for row in elements.strains_at_start(length))
    bending = disk.blade.thickness / 2.0 * curvature
    faces = np.zeros((2, 3 * len(nodes)))
    faces[:, :6] = material.young_modulus * np.array([strain + bending, strain - bending])
    faces[:, :3] = faces[:, :3] @ _root_motion(disk, nodes)
    return faces


def _spoke(disk: Any, material: Any) -> tuple[Any, Any]:
    """Mass and stiffness of a spoke that is clamped inside, on ring u, u', v and the spoke's u'."""
    beam = _beam(disk, disk.spoke_thickness, material)
    m, k = elements.spoke_element(beam, disk.hub_radius - disk.inner_radius)
    u, v, slope = _section_motion(disk.hub_radius)
    to_ring = np.zeros((4, 4))  # u, u', v, v' of the outer end
    to_ring[[0, 2, 3], :3] = u, v, slope
    to_ring[1, 3] = 1
    return to_ring.T @ m[4:, 4:] @ to_ring, to_ring.T @ k[4:, 4:] @ to_ring


def _section_motion(radius: Any) -> Any:
    """Matrix (3, 3) from ring u, u', v to the motion u, v, omega = v/R_h - u' of the section."""
    return np.array([[1, 0, 0], [0, 0, 1], [0, -1, 1 / radius]])


def _direction(angle: Any) -> Any:
    return np.array([np.cos(angle), np.sin(angle)])


def _turn_node(axis: Any) -> Any:
    """Matrix (3, 3) that turns the motion of a node into the frame with this first axis."""
    c, s = axis
    return np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])


def _points(disk: Any, nodes: Any, blade_dof: Any) -> Any:
    """Points with the nodes of all blades, root to tip, then the inner ends of the spokes."""
    n_blades, n_nodes = disk.n_blades, len(nodes)
    tip = _tip_angles(disk)
    root = tip + np.arctan2(nodes[0, 1], nodes[0, 0])
    turn = np.array([[np.cos(tip), -np.sin(tip)], [np.sin(tip), np.cos(tip)]])
    blade_xy = np.einsum("xyi,ny->inx", turn, nodes)
    inner_xy = disk.inner_radius * _direction(root).T

    own = 3 * np.arange(n_nodes)[:, None] + [0, 1]  # radial and tangential dof of a node
    own[0, 1] = 2  # the root is a node of the ring
    frame = np.repeat(tip[:, None], n_nodes, axis=1)
    frame[:, 0] = root

    blades = np.arange(n_blades * n_nodes).reshape(n_blades, n_nodes)
    inner = n_blades * n_nodes + np.arange(n_blades)
    return Points(
        position=np.vstack([blade_xy.reshape(-1, 2), inner_xy]),
        dof=np.vstack([blade_dof[:, own].reshape(-1, 2), np.full((n_blades, 2), -1)]),
        frame=np.concatenate([frame.ravel(), root]),
        blades=blades,
        ring=np.column_stack([blades[:, 0], np.roll(blades[:, 0], -1)]),
        spokes=np.column_stack([inner, blades[:, 0]]),
    )
