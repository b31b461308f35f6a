"""Stress of the blade: by rotation, and of the first family's mode for a motion of the tip.

Strains are those of the 20-node element at its eight integration points, where they are best known;
the linear function through these gives the corners, where elements are averaged. A mode at speed
strains the blade from its running shape on, so that its displacements belong on that mesh.
"""

import itertools

import numpy as np
import scipy.sparse as sp

from evidence.calculix import POISSON, YOUNG
from evidence.rotor67.mesh import PLACES
from evidence.rotor67.model import DESIGN, Fan
from evidence.rotor67.numbers import Number
from hpcrub.model.imported.craig_bampton import lowest_modes
from hpcrub.model.imported.cyclic import wave_matrices
from hpcrub.model.imported.frames import to_cartesian, to_cylindrical
from hpcrub.model.imported.neutral import NeutralModel, row_table
from hpcrub.model.imported.stress import COMPONENTS, tangent, von_mises

DIAMETERS = 2  # of the mode: the second engine order meets it
PHASES = np.exp(1j * np.linspace(0.0, np.pi, 25))  # of the mode's motion
ULTIMATE, FATIGUE = 950.0, 510.0  # of annealed Ti-6Al-4V [MPa], see docs/rotor67.md
POINTS = (2.0 * np.array(list(np.ndindex(2, 2, 2))) - 1.0) / np.sqrt(3.0)  # of integration
LINEAR = np.array(list(np.ndindex(2, 2, 2)))  # powers of the coordinates
SERENDIPITY = np.array([e for e in np.ndindex(3, 3, 3) if e.count(2) < 2])


def _powers(places, exponents):
    """Products of powers of coordinates (places, exponents)."""
    return np.prod(places[:, None, :] ** exponents, axis=2)


def _slopes():
    """Derivatives of the shape functions at the integration points, (8 points, 3, 20 nodes)."""
    nodal = np.linalg.inv(_powers(PLACES - 1.0, SERENDIPITY))
    parts = [
        SERENDIPITY[:, d] * _powers(POINTS, np.maximum(SERENDIPITY - np.eye(3, dtype=int)[d], 0))
        for d in range(3)
    ]
    return np.stack(parts, axis=1) @ nodal


def gradients(nodes: np.ndarray, elements: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Displacement gradients at the integration points, (elements, 8, 3 of moved, 3 of place).

    nodes: (n, 3) places; elements: (e, 20); moved: (n, 3) displacements, real or complex.
    """
    slopes = _slopes()
    jacobian = slopes @ nodes[elements][:, None]
    return np.linalg.solve(jacobian, slopes @ moved[elements][:, None]).swapaxes(-1, -2)


def elastic(strain: np.ndarray) -> np.ndarray:
    """Stress [MPa] of strains (..., 3, 3)."""
    trace = np.trace(strain, axis1=-2, axis2=-1)[..., None, None] * np.eye(3)
    return YOUNG / (1.0 + POISSON) * (strain + POISSON / (1.0 - 2.0 * POISSON) * trace)


def by_strain(nodes: np.ndarray, elements: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Stress at the integration points of small displacements, real or complex."""
    gradient = gradients(nodes, elements, moved)
    return elastic((gradient + gradient.swapaxes(-1, -2)) / 2.0)


def by_rotation(nodes: np.ndarray, elements: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Cauchy stress at the integration points of large displacements from rest."""
    gradient = gradients(nodes, elements, moved)
    F = np.eye(3) + gradient
    second = elastic((F.swapaxes(-1, -2) @ F - np.eye(3)) / 2.0)
    return F @ second @ F.swapaxes(-1, -2) / np.linalg.det(F)[..., None, None]


def at_corners(stress: np.ndarray, elements: np.ndarray, n_nodes: int) -> np.ndarray:
    """Stress (n_nodes, 3, 3) at corners from the integration points; NaN at other nodes."""
    corners = _powers(PLACES[:8] - 1.0, LINEAR) @ np.linalg.inv(_powers(POINTS, LINEAR))
    values = np.einsum("cp,epij->ecij", corners, stress)
    total = np.zeros((n_nodes, 3, 3), dtype=values.dtype)
    count = np.zeros(n_nodes)
    np.add.at(total, elements[:, :8], values)
    np.add.at(count, elements[:, :8], 1.0)
    with np.errstate(invalid="ignore"):
        return total / count[:, None, None]


def rows_at(corner: int, nodes: np.ndarray, elements: np.ndarray, dof: np.ndarray) -> sp.csr_array:
    """Six components of the stress at a corner, as `at_corners`, on rows (node, direction).

    nodes: (n, 3) [mm]; elements: (e, 20); dof: (m, 2), directions x, y, z. Returns (6, m) in MPa
    for a displacement of a metre.
    """
    own = elements[(elements[:, :8] == corner).any(axis=1)]
    table, rows = row_table(dof, len(nodes))[:, 1:4], np.zeros((len(COMPONENTS), len(dof)))
    for node, direction in itertools.product(np.unique(own), range(3)):
        moved = np.zeros_like(nodes)
        moved[node, direction] = 1e3
        stress = at_corners(by_strain(nodes, own, moved), own, len(nodes))[corner]
        if (row := table[node, direction]) >= 0:
            rows[:, row] = [stress[i, j] for i, j in COMPONENTS]
    return sp.csr_array(rows)


def with_rows(fan: Fan, sector: NeutralModel) -> NeutralModel:
    """A free sector at the design speed with rows of stress, and the stress of rotation there [Pa].

    Two places of the first family's mode: that of its largest stress, and the one that fails first
    by Goodman's line. Each row is the tangent of von Mises' stress at the mode.
    """
    elements = fan.running.elements[fan.running.blade_elements]
    _, steady, at_largest = _of_mode(fan, sector)
    places = places_of(fan, sector)
    groups = [1e6 * rows_at(place, fan.running.nodes, elements, sector.dof) for place in places]
    rows = [tangent(g, at_largest[place]) for g, place in zip(groups, places, strict=True)]
    return sector._replace(
        stress=sp.csr_array(sp.vstack(rows)),
        stress_blade=np.zeros(len(places), dtype=int),
        stress_static=1e6 * steady[places],
    )


def places_of(fan: Fan, sector: NeutralModel) -> list[int]:
    """Nodes of the mode's largest stress, and of the stress that fails first beside rotation."""
    moving, steady, _ = _of_mode(fan, sector)
    left = (1.0 - steady / ULTIMATE) / moving  # Goodman's line
    return [int(np.nanargmax(moving)), int(np.nanargmin(left))]


def _of_mode(fan, sector):
    """At every corner: largest von Mises' stress of the mode, that of rotation, the mode's own.

    The last is the stress of the instant at which it is largest (n, 3, 3); all in MPa.
    """
    elements, n = fan.running.elements[fan.running.blade_elements], len(fan.running.nodes)
    found = by_strain(fan.running.nodes, elements, mode(sector, n))
    found = at_corners(found, elements, n)
    instants = (PHASES[:, None, None, None] * found).real
    sizes = von_mises(instants)
    best = np.nan_to_num(sizes).argmax(axis=0)
    moved = by_rotation(fan.at_rest.nodes, elements, fan.moved[DESIGN])
    return (
        sizes.max(axis=0),
        von_mises(at_corners(moved, elements, n)),
        instants[best, np.arange(n)],
    )


def mode(sector: NeutralModel, n_nodes: int) -> np.ndarray:
    """Displacements (n_nodes, 3), complex, of the first family's mode of a free sector at speed.

    Its largest tangential amplitude at a contact point is one.
    """
    sector = to_cylindrical(sector)
    wave, K, M = wave_matrices(sector, DIAMETERS, 0.0)
    shape = wave @ lowest_modes(K, M, 1)[1][:, 0]
    rows = row_table(sector.dof, n_nodes)[:, 1:4]
    moved = np.where(rows >= 0, shape[rows], 0.0)
    moved /= np.abs(moved[sector.contact_node, 1]).max()
    return to_cartesian(sector.nodes, moved)


def numbers(fan: Fan, sector: NeutralModel) -> list[Number]:
    """Stress of the mode for a millimetre, of rotation, and what fatigue leaves beside it."""
    moving, steady, _ = _of_mode(fan, sector)
    place = int(np.nanargmax(moving))
    left = FATIGUE * (1.0 - steady / ULTIMATE) / moving  # Goodman's line
    at = "of the blade, 2 diameters"
    return [
        Number("largest stress of the first family's mode", at, moving[place], "MPa/mm"),
        Number("stress by rotation at the same place", at, steady[place], "MPa"),
        Number("largest stress by rotation", at, float(np.nanmax(steady)), "MPa"),
        Number("amplitude at which the first place reaches its fatigue limit", at,
               float(np.nanmin(left)), "mm"),
    ]  # fmt: skip
