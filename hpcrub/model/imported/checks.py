"""Checks of an imported model: its mass, size and balance, and errors such as wrong units."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from hpcrub.errors import InputError
from hpcrub.model.imported import bent_blades
from hpcrub.model.imported.frames import turn
from hpcrub.model.imported.neutral import NeutralModel

SLOWEST = 0.1  # [Hz] a first frequency below comes from wrong units
FASTEST = 2e4  # [m/s] first frequency times tip radius; sound in metals has a quarter of it
TIP_RADII = 1e-3, 20.0  # [m]
DENSITIES = 3.0, 3e4  # [kg/m3] mass over the volume of the space that the disk sweeps
RIGID = 1e-3  # residual of a row, as a share of its entries, above which it is unbalanced
UNFELT = 1e-12  # of the usual (median) entries of a row: what is below is rounding
UNBALANCED = 0.5  # share of unbalanced rows above which K is no stiffness of a body
CLEARANCE = 0.1  # of the tip radius; a larger clearance comes from wrong units
BLADES = 100.0  # times K, above which an entry of K_blade cannot be a part of it
ROUNDING = 1e-9  # of the largest entry of K: a smaller one says nothing
STATIC = 1e4, 1e10  # [Pa] a largest stress of rotation outside comes from wrong units
TIP = 0.2  # contact nodes lie in this outer part of the radii


class Findings(NamedTuple):
    """Measured properties of a neutral model."""

    mass: float  # of the whole disk, as far as it has rows [kg]; NaN for a reduced model
    rigid_residual: float  # median of `unbalanced` over the rows; NaN for a reduced model
    loaded_rows: int  # rows with `unbalanced` above RIGID: next to held nodes without rows
    tip_radius: float  # largest radius of a contact node [m]
    tip_gap: float  # tip_radius less the smallest radius of a contact node [m]


def check(model: NeutralModel) -> Findings:
    """Measure a NeutralModel. Raises InputError for impossible values."""
    radius = np.hypot(model.nodes[:, 0], model.nodes[:, 1])
    _check_contact_nodes(model, radius)
    tip = radius[model.contact_node]
    if not TIP_RADII[0] <= tip.max() <= TIP_RADII[1]:
        raise InputError(
            f"units: the contact nodes lie at a radius of {tip.max():.3g} m, which no bladed disk "
            "has; are the units those of the file?"
        )
    worst = int(np.abs(model.contact_clearance).argmax())
    if abs(model.contact_clearance[worst]) > CLEARANCE * tip.max():
        raise InputError(
            f"contact_clearance: {1e3 * model.contact_clearance[worst]:.4g} mm of node "
            f"{model.contact_node[worst]} is more than a tenth of the tip radius; are the units "
            "those of the file?"
        )
    _check_blades(model, tip)
    if model.kind == "reduced":
        if not np.linalg.eigvalsh(model.mass)[0] > 0.0:
            raise InputError("M: the mass matrix is not positive definite")
        return Findings(np.nan, np.nan, 0, float(tip.max()), float(np.ptp(tip)))
    rigid = rigid_motions(model)
    # mass that moves in a translation along each axis; held rows may lack in one [kg]
    masses = np.einsum("nk,nk->k", rigid[:, :3], model.mass @ rigid[:, :3])
    mass = float(masses.max()) * (model.n_sectors or 1)
    _check_mass(model, mass, radius)
    share = unbalanced(model.stiffness[0], rigid)
    loaded = int((share > RIGID).sum())
    if loaded > UNBALANCED * len(share):
        raise InputError(
            f"K: a rigid motion causes forces at {loaded} of {len(share)} rows; the list of rows "
            "(dof), the nodes or the frame is not that of the matrix"
        )
    held = model.dof[model.fixed]
    if lost := set(held[np.isin(held[:, 1], (1, 2)), 0]) & set(model.contact_node):
        raise InputError(f"fixed: contact node {min(lost)} is held; the tips must move")
    return Findings(mass, float(np.median(share)), loaded, float(tip.max()), float(np.ptp(tip)))


def check_frequency(first_hz: float, tip_radius: float) -> None:
    """Raise InputError for a first natural frequency [Hz] that only wrong units can give.

    tip_radius: of the model [m].
    """
    if not first_hz > SLOWEST:
        raise InputError(
            f"the first natural frequency is {first_hz:.3g} Hz: the disk is not held (fixed), or "
            "the units are not those of the file"
        )
    if first_hz > FASTEST / tip_radius:
        raise InputError(
            f"units: the first natural frequency is {first_hz:.3g} Hz, which no bladed disk of "
            f"{1e3 * tip_radius:.4g} mm radius has; are the units those of the file?"
        )


def at_speed(name: str, check: Callable[[float], Any], speed: float) -> Any:
    """Return check(speed). If it fails where check(0) passes, the error names the speed.

    name: key that sets the speed; speed: of rotation [rad/s]. Raises InputError.
    """
    try:
        return check(speed)
    except InputError:
        check(0.0)
        raise too_fast(name, speed) from None


def too_fast(name: str, speed: float) -> InputError:
    """Error for a speed of rotation [rad/s] at which the stiffness is not that of a disk."""
    return InputError(
        f"{name}: at {speed / (2 * np.pi):g} Hz the stiffness of this model is not that of a disk, "
        "at rest it is: the speed is beyond those of the model's matrices, or is not in Hz"
    )


def rigid_motions(model: NeutralModel) -> np.ndarray:
    """Rigid translations and rotations about x, y, z on the rows of a NeutralModel, (n, 6)."""
    nodes = np.nan_to_num(model.nodes[np.maximum(model.dof[:, 0], 0)])
    placed = np.isfinite(model.nodes).all(axis=1)[model.dof[:, 0]] & (model.dof[:, 1] > 0)
    x, y, z = nodes.T
    motion = np.zeros((6, 6, len(x)))  # (motion, direction, row), translations first
    motion[np.arange(6), np.arange(6)] = 1.0
    motion[0, 4], motion[0, 5] = z, -y
    motion[1, 3], motion[1, 5] = -z, x
    motion[2, 3], motion[2, 4] = y, -x
    direction = np.maximum(model.dof[:, 1], 1) - 1
    rigid = motion[direction, :, np.arange(len(direction))] * placed[:, None]
    if model.frame == "cylindrical":
        rigid = turn(model.dof, model.nodes).T @ rigid
    return rigid


def unbalanced(K: Any, rigid: np.ndarray) -> np.ndarray:
    """Unbalanced share of every row (n,): largest |K r| / |K| |r| in the rigid motions r (n, 6)."""
    force, size = np.abs(K @ rigid), abs(K) @ np.abs(rigid)
    usual = [np.median(column[column > 0.0]) if column.any() else 0.0 for column in size.T]
    size = np.where(size > UNFELT * np.array(usual), size, np.inf)
    return (force / size).max(axis=1)


def _check_blades(model: Any, tip: Any) -> None:
    _check_stress(model)
    _check_blade_stiffness(model)
    if model.bent is not None:
        bent_blades.check(model.bent, tip)


def _check_stress(model: Any) -> None:
    lost = np.flatnonzero(np.asarray(abs(model.stress).sum(axis=1)) == 0.0)
    if len(lost):
        raise InputError(
            f"stress: the row of place {lost[0]} is zero, no motion would cause a stress there; "
            "leave it out, or print fewer modes if all of its modes are zero"
        )
    largest = float(np.abs(model.stress_static).max(initial=0.0))
    if largest and not STATIC[0] <= largest <= STATIC[1]:
        raise InputError(
            f"stress_static: up to {1e-6 * largest:.3g} MPa; {1e-6 * STATIC[0]:g} to "
            f"{1e-6 * STATIC[1]:,.0f} MPa are expected of the rotation; are the units those of "
            "the file, or of --table-units?"
        )


def _check_blade_stiffness(model: Any) -> None:
    if model.blade_stiffness is None:
        return
    own, whole = model.blade_stiffness, np.abs(model.stiffness[0].diagonal())
    of_blades = np.abs(own.diagonal() if own.ndim == 2 else np.einsum("bii->i", own))
    share = of_blades / np.maximum(whole, ROUNDING * whole.max())
    if not share.max() <= BLADES:
        raise InputError(
            f"K_blade: {share.max():.3g} times K at row {share.argmax()}; it must be a part of K: "
            "is it of the same model, units and rows?"
        )


def _check_mass(model: Any, mass: Any, radius: Any) -> None:
    placed = np.isfinite(radius)
    size = np.pi * radius[placed].max() ** 2 * np.ptp(model.nodes[placed, 2])
    if not mass > 0:
        raise InputError(f"M: the mass is {mass:.3g} kg, the mass matrix cannot be one")
    if size > 0 and not DENSITIES[0] <= mass / size <= DENSITIES[1]:
        raise InputError(
            f"units: a mass of {mass:.3g} kg in {size:.3g} m3; are the units those of the file?"
        )


def _check_contact_nodes(model: Any, radius: Any) -> None:
    at = radius[model.contact_node]
    if not np.isfinite(at).all():
        node = model.contact_node[~np.isfinite(at)][0]
        raise InputError(f"contact_node: node {node} has no place")
    inner, outer = np.nanmin(radius), np.nanmax(radius)
    low = at < outer - TIP * (outer - inner) - 1e-9 * outer
    if low.any() and model.kind != "reduced":
        raise InputError(
            f"contact_node: node {model.contact_node[low][0]} lies at a radius of "
            f"{1e3 * at[low][0]:.4g} mm, {1e3 * (outer - at[low][0]):.4g} mm below the outermost "
            "node; contact nodes lie on the tips"
        )
