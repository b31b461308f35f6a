"""Reduction of imported models, to the ReducedModel that every study starts from.

Blades may be known by their own frequencies, with the root held (component mode mistuning): with
u = psi u_root + phi q in a blade, phi its cantilever modes, a blade whose cantilever eigenvalues
differ by delta adds delta q^T Lambda q to the stiffness, and q follows from the motion of the tuned
disk: Lambda q = phi^T K_blade u. Source: Lim, Bladh, Castanier, Pierre (2007), AIAA Journal 45(9),
equations (14) to (20).
"""

from typing import Any

import numpy as np

from hpcrub.errors import InputError
from hpcrub.model import reduction
from hpcrub.model.imported import craig_bampton
from hpcrub.model.imported.assembly import SHARED
from hpcrub.model.imported.craig_bampton import lowest_modes
from hpcrub.model.imported.frames import node_angle, to_cylindrical
from hpcrub.model.imported.neutral import NeutralModel, contact_rows, stiffness_at
from hpcrub.model.imported.second_order import second_order
from hpcrub.model.interface import Interface
from hpcrub.model.reduction import ReducedModel, project

BLADE_MODES = 4  # cantilever modes of each blade that are kept
# limits of the blades' stiffness at rest as a share of the disk's at a speed, in any motion
SMALLEST_SHARE, LARGEST_SHARE = 1e-6, 1.5
SOLVABLE = 1e100  # share of the stiffness up to which eigenvalues do not overflow


def reduce_disk(
    disk: NeutralModel, n_modes: int, speed: float = 0.0
) -> tuple[NeutralModel, np.ndarray]:
    """Reduce an assembled NeutralModel of kind "disk" to one of kind "reduced".

    n_modes, speed: see `craig_bampton.basis`. Returns model; basis (n, m) on rows of the disk.
    """
    basis, boundary = craig_bampton.basis(disk, n_modes, speed)
    n_points, m = len(disk.contact_node), basis.shape[1]
    directions = len(boundary) // n_points
    dof = np.column_stack([np.full(m, -1), np.zeros(m, int)])
    dof[: len(boundary), 0] = np.tile(np.arange(n_points), directions)
    dof[: len(boundary), 1] = np.repeat(np.arange(1, directions + 1), n_points)
    blades = frequencies = participation = None
    if disk.blade_stiffness is not None:
        own = [np.flatnonzero(disk.row_blade == blade) for blade in range(disk.n_blades)]
        blades = np.stack([project(disk.blade_stiffness[r][:, r], basis[r]) for r in own])
        frequencies, participation = cantilever(disk, basis, BLADE_MODES)
    model = NeutralModel(
        kind="reduced",
        mass=project(disk.mass, basis),
        stiffness=tuple(project(k, basis) for k in disk.stiffness),
        speeds=disk.speeds,
        nodes=disk.nodes[disk.contact_node],
        dof=dof,
        frame="cylindrical",
        contact_node=np.arange(n_points),
        contact_blade=disk.contact_blade,
        contact_clearance=disk.contact_clearance,
        contact_normal=disk.contact_normal,
        blade_stiffness=blades,
        blade_frequencies=frequencies,
        participation=participation,
        stress=disk.stress @ basis,
        stress_blade=disk.stress_blade,
        stress_static=disk.stress_static,
        bent=disk.bent,
    )
    return model, basis


def inner_rows(disk: NeutralModel) -> list[np.ndarray]:
    """Rows of every blade without its root: the rest of the disk has no stiffness in them."""
    K = disk.stiffness[0]
    foreign = abs(K - disk.blade_stiffness).max(axis=1).toarray().ravel()
    own = np.where(foreign < SHARED * abs(K).max(), disk.row_blade, -1)
    return [np.flatnonzero(own == blade) for blade in range(disk.n_blades)]


def cantilever(
    disk: NeutralModel, basis: np.ndarray, n_modes: int
) -> tuple[np.ndarray, np.ndarray]:
    """Cantilever modes of every blade, expressed in the coordinates of a basis.

    disk: assembled, with the blades' stiffness; basis: (n, m); n_modes: modes of each blade.
    Returns frequencies (N, n_modes) of every blade alone, at rest, with its root held [Hz];
    participation (N, n_modes, m), amplitude of each mode per unit coordinate [sqrt(kg)].
    Raises InputError: a blade has fewer rows than modes.
    """
    frequencies, participation = [], []
    for blade, rows in enumerate(inner_rows(disk)):
        if len(rows) < n_modes:
            raise InputError(f"K_blade: blade {blade + 1} has {len(rows)} rows beyond its root")
        K = disk.blade_stiffness[rows]
        values, phi = lowest_modes(K[:, rows].tocsc(), disk.mass[rows][:, rows].tocsc(), n_modes)
        frequencies.append(np.sqrt(values) / (2 * np.pi))
        participation.append(phi.T @ (K @ basis) / values[:, None])
    return np.array(frequencies), np.array(participation)


def modal_stiffness(frequencies: np.ndarray, participation: np.ndarray) -> np.ndarray:
    """Stiffness (N, m, m) of cantilever modes (N, c) [Hz], participation (N, c, m) [sqrt(kg)]."""
    q = 2 * np.pi * frequencies[:, :, None] * participation
    return np.swapaxes(q, 1, 2) @ q


def interface(model: NeutralModel) -> Interface:
    """Contact interface of a reduced, cylindrical model; it observes tangential displacements.

    Raises InputError for a second order that cannot be that of the model's blades.
    """
    rows, one = contact_rows(model), np.eye(len(model.dof))
    at = model.nodes[model.contact_node]
    normal, tangential, axial = one[rows[0]], one[rows[1]], one[rows[2:].ravel()]
    outward, along = model.contact_normal[:, [0]], model.contact_normal[:, [2]]
    if along.any():  # conical casing: axial becomes the generator's direction
        if not len(axial):
            raise InputError("contact_normal: a contact node that moves in x and y alone has none")
        normal, axial = outward * normal + along * axial, outward * axial - along * normal
    return Interface(
        blade=model.contact_blade,
        angle=node_angle(at),
        radius=np.hypot(at[:, 0], at[:, 1]),
        axial_position=at[:, 2],
        clearance=model.contact_clearance,
        normal=normal,
        tangential=tangential,
        axial=axial,
        observed=tangential,
        observed_blade=model.contact_blade,
        stress=model.stress,
        stress_blade=model.stress_blade,
        stress_static=model.stress_static,
        second_order=second_order(model),
    )


def reduced_model(model: NeutralModel, speed: float, by_modes: bool = False) -> ReducedModel:
    """Convert a NeutralModel of kind "reduced" to a ReducedModel.

    speed: speed of rotation at which the mode shapes are computed [rad/s].
    by_modes: whether mistuning changes the cantilever modes of a blade, not all its stiffness.
    Raises InputError: the model is not positive definite, or has no cantilever modes.
    """
    model = to_cylindrical(model)
    m = len(model.dof)
    if by_modes and model.blade_frequencies is None:
        raise InputError("mistuning.by: the model file has no blade_frequencies_hz")
    if by_modes:
        blades = modal_stiffness(model.blade_frequencies, model.participation)
    elif model.blade_stiffness is None:
        blades = np.zeros((model.n_blades, m, m))
    else:
        blades = model.blade_stiffness
    K, face, slopes = stiffness_at(model.stiffness, speed), interface(model), model.stiffness[1:]
    try:
        result = reduction.reduced_model(model.mass, K, blades, np.eye(m), face, speed, slopes)
    except np.linalg.LinAlgError:
        raise InputError("M: the mass matrix is not positive definite") from None
    if result.tuned_eigenvalues[0] <= 0:
        raise InputError("K: the disk is not held: its lowest eigenvalue is not positive")
    _check_blades(result)
    return result


def _check_blades(model: Any) -> None:
    """Raise InputError when the blades' stiffness cannot be a part of the disk's stiffness."""
    if model.modal_blade_stiffness.any():
        scale = 1.0 / np.sqrt(model.tuned_eigenvalues)
        part = model.modal_blade_stiffness.sum(axis=0) * np.outer(scale, scale)
        low, high = 0.0, float(np.abs(part).max())
        if high < SOLVABLE:
            low, *_, high = np.linalg.eigvalsh(part)
        if low < -SMALLEST_SHARE or not high <= LARGEST_SHARE:
            raise InputError(
                f"K_blade: from {min(low, 0.0):.3g} to {high:.3g} of the disk's "
                "stiffness, of which it must be a part; is it of the same model, units and rows?"
            )
