"""Rows of stress: the stress at places of a blade as a linear function of the displacements.

The stress at a point of an element is linear in the displacements of the element's nodes. A least
squares fit to displacements and stresses of some modes gives this function for any element type.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.linalg import eigh

from hpcrub.errors import InputError
from hpcrub.model.imported.craig_bampton import lowest_modes
from hpcrub.model.imported.cyclic import wave_matrices
from hpcrub.model.imported.frames import to_cylindrical
from hpcrub.model.imported.neutral import NeutralModel, row_table, stiffness_at

FAMILIES = 3  # families of modes, each of which chooses a place
LEFT_OUT = 0.2  # share of the modes, the lowest ones, that the fit to the others must predict
MISSED = 0.02  # largest error of this prediction, as a share of the stress of the mode
RANK = 1e-8  # smallest singular value over the largest: printed numbers have few digits
RIGID = 1e-6  # of the largest stress of all modes: a mode with less is taken for rigid
PHASES = np.exp(1j * np.pi * np.arange(16) / 16)  # phases at which a complex mode is examined
COMPONENTS = (0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)  # components of a group's six rows
TENSOR = np.array([[0, 3, 4], [3, 1, 5], [4, 5, 2]])  # these components as a matrix


def fitted(moved: np.ndarray, stress: np.ndarray) -> tuple[np.ndarray, float]:
    """Fit the stresses in an element for a unit of each displacement of its nodes.

    - moved: displacements of its a nodes in k modes (k, a, 3), the lowest first.
    - stress: stresses of these modes, all components of all points (k, c).

    Returns coefficients (c, a, 3), which give no stress in a translation; missed, the largest error
    of a mode that was left out of the fit, relative to the stress of the mode.
    """
    apart = (moved - moved.mean(axis=1, keepdims=True)).reshape(len(moved), -1)
    size = np.linalg.norm(stress, axis=1)
    strained = size > RIGID * size.max()
    weight = 1.0 / np.where(strained, size, max(RIGID * size.max(), 1e-300))[:, None]
    apart, stress = weight * apart, weight * stress
    out = strained & (np.arange(len(moved)) < LEFT_OUT * len(moved))
    part = np.linalg.lstsq(apart[~out], stress[~out], rcond=RANK)[0]
    missed = np.linalg.norm(apart[out] @ part - stress[out], axis=1).max(initial=0.0)
    coefficients = np.linalg.lstsq(apart, stress, rcond=RANK)[0].T.reshape(-1, *moved.shape[1:])
    return coefficients - coefficients.mean(axis=1, keepdims=True), float(missed)


def rows(
    elements: Iterable[tuple[np.ndarray, np.ndarray, np.ndarray]], dof: np.ndarray, n_nodes: int
) -> sp.csr_array:
    """Six rows of stress for each point, on the rows of a model.

    - elements: nodes (a,), their displacements in k modes (k, a, 3) and stresses (k, points, 6),
      the components of each point in the order of COMPONENTS.
    - dof, n_nodes: of the model. Displacements without a row are held.

    Raises InputError: the stress is no linear function of the displacements, or modes are too few.
    """
    table, parts, missed = row_table(dof, n_nodes)[:, 1:4], [], 0.0
    for nodes, moved, stress in elements:
        coefficients, error = fitted(moved, stress.reshape(len(stress), -1))
        missed = max(missed, error)
        at = table[nodes].ravel()
        place = sp.coo_array((np.ones((at >= 0).sum()), (np.flatnonzero(at >= 0), at[at >= 0])),
                             shape=(len(at), len(dof)))  # fmt: skip
        parts.append(sp.csr_array(coefficients.reshape(len(coefficients), -1)) @ place)
    if missed > MISSED:
        raise InputError(
            "--stress: the stress of the lowest fifth of the modes is predicted by the others with "
            f"an error of {100 * missed:.2g} %, at most {100 * MISSED:g} % is allowed; print more "
            "modes (200), and not the stress of C3D8I, which has inner displacements in it"
        )
    return sp.csr_array(sp.vstack(parts))


def chosen(model: NeutralModel, speed: float) -> tuple[NeutralModel, np.ndarray]:
    """Choose one row of stress for each of the first families from groups of six components.

    Its place is where von Mises' stress is largest in the family's mode with most nodal diameters.
    Von Mises' stress is not linear, and the row is its tangent at the mode: both agree for motions
    in proportion to the mode, and the tangent is below von Mises' stress for all other motions.

    - model: a sector; speed: of rotation, at which the modes are computed [rad/s].

    Returns the model with these rows in place of its groups; the stress of each row in the mode of
    its family per unit of the largest displacement of a contact node (families,) [Pa/m].
    """
    flat = to_cylindrical(model)
    P, K, M = wave_matrices(flat, model.n_sectors // 2, speed)
    shapes = P @ lowest_modes(K, M, FAMILIES)[1]
    contact = flat.row[flat.contact_node]
    shapes = shapes / np.abs(shapes[contact[contact >= 0]]).max(axis=0)
    groups = (flat.stress @ shapes).reshape(-1, len(COMPONENTS), FAMILIES)
    tangents, size = [], []
    for mode in groups.transpose(2, 0, 1):
        tensors = (PHASES[:, None, None] * mode).real[..., TENSOR]  # (phases, points, 3, 3)
        values = von_mises(tensors)
        phase, point = np.unravel_index(values.argmax(), values.shape)
        tangents.append(tangent(model.stress[6 * point : 6 * point + 6], tensors[phase, point]))
        size.append(values[phase, point])
    blade = np.zeros(len(tangents), dtype=int)
    stress = sp.csr_array(sp.vstack(tangents))
    return model._replace(stress=stress, stress_blade=blade), np.array(size)


def largest(model: NeutralModel, speed: float) -> float:
    """Largest stress of a reduced model in a mode of its first family [Pa per m of the tips].

    speed: of rotation [rad/s]; modes as they are normalised by their largest displacement of a
    contact node.
    """
    modes = [0, min(model.n_blades, len(model.dof)) - 1]
    shapes = eigh(stiffness_at(model.stiffness, speed), model.mass, subset_by_index=modes)[1]
    tips = model.row[model.contact_node]
    return float((np.abs(model.stress @ shapes).max(axis=0)
                  / np.abs(shapes[tips[tips >= 0]]).max(axis=0)).max())  # fmt: skip


def tangent(group: sp.csr_array, stress: np.ndarray) -> sp.csr_array:
    """Row (1, n) of the tangent of von Mises' stress at `stress` (3, 3); group: six rows (6, n)."""
    slope = 1.5 * _deviator(stress) / max(float(von_mises(stress)), 1e-300)
    return sp.csr_array([[slope[i, j] * (1 + (i != j)) for i, j in COMPONENTS]]) @ group


def von_mises(stress: np.ndarray) -> np.ndarray:
    """Von Mises' stress (...) of stress tensors (..., 3, 3)."""
    return np.sqrt(1.5 * (_deviator(stress) ** 2).sum(axis=(-2, -1)))


def _deviator(stress: Any) -> Any:
    mean = np.trace(stress, axis1=-2, axis2=-1)[..., None, None] / 3.0
    return stress - mean * np.eye(3)
