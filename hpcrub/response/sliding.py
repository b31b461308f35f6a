"""Stability of a contact point that slides along the casing, from the modes of the free disk.

A point that a normal force λ holds at the casing, and friction μλ rubs, has the compliance

    c(μ) = sum_k R_k (R_k + μ T_k) / ω_k²,

with R and T its normal and tangential displacement per unit modal coordinate. Where c(μ) < 0 the
force presses the point further into the casing: the point *locks itself*, and no sliding contact
lasts. The model has no stick, wear or large displacements, which bound the motion in a machine.
Brakes show the same as *sprag*; Applied Sciences 10 (2020), article 2748, has a minimal model. The
criterion is derived here; `evidence.validation.sliding` checks it by integration in time.
"""

from typing import Any

import numpy as np

from hpcrub.contact import status
from hpcrub.model.coating import ElasticCasing
from hpcrub.model.damping import Damping, ratios_of, state_matrix
from hpcrub.model.reduction import Modes

PERMANENT = 0.99  # share of the last window that a blade touches, above which contact is permanent


def critical_friction(modes: Modes, casing: ElasticCasing | None = None) -> float:
    """Smallest coefficient of friction at which a contact point locks itself; inf: none does.

    casing: ElasticCasing whose compliance 1/k is added to c(μ); None: the casing is rigid.
    """
    normal, tangential = _compliances(modes)
    normal = normal + (1.0 / casing.stiffness if casing else 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        critical = np.where(tangential < 0.0, -normal / tangential, np.inf)
    return float(critical.min())


def growth_rate(modes: Modes, damping_ratio: float | Damping, friction: float) -> float:
    """Rate of growth of the motion at the contact point that slides least stably [1/s].

    This is the largest real part of the eigenvalues of the disk with this point held at the casing,
    q'' = -(1 - G (R G)⁻¹ R) (2ξω q' + ω² q), G = -(R + μT)ᵀ. Zero where the point is stable.
    """
    normal, tangential = _compliances(modes)
    point = int(np.argmin((normal + friction * tangential) / normal))
    R, T = modes.normal[point], modes.tangential[point]
    G = R + friction * T
    held = np.eye(len(R)) - np.outer(G, R) / (R @ G)
    xi = ratios_of(damping_ratio, modes.omega)
    state = state_matrix(held * (2.0 * xi * modes.omega), held * modes.omega**2)
    # the constraint makes two eigenvalues zero, which rounding moves a little
    rate = float(np.linalg.eigvals(state).real.max())
    return rate if rate > 1e-3 * modes.omega.min() else 0.0


def permanent_contact(share: np.ndarray, modes: Modes, scene: Any, speed_hz: float) -> int:
    """Whether a motion is in permanent contact, so that its amplitude means nothing.

    A blade that touches the casing all the time either follows the casing or, where sliding
    contact is not stable, takes energy from friction. On a coating contact is never permanent: it
    ends when enough is cut.

    share: (N,) share of the last window in which each blade touches; (0,) where it is not known.
    scene: response.scene.Scene; speed_hz: of the motion [Hz].
    Returns code of ``status``: NONE, PERMANENT or FLUTTER.
    """
    if scene.coating or not (len(share) and share.max() > PERMANENT):
        return status.NONE
    locks = scene.friction > critical_friction(modes.at(speed_hz), scene.elastic_casing)
    return status.FLUTTER if locks else status.PERMANENT


def _compliances(modes: Modes) -> tuple[Any, Any]:
    """Normal displacement of every point under a unit normal and tangential force (C,) [m/N]."""
    flexible = modes.normal / modes.omega**2
    return (flexible * modes.normal).sum(axis=1), (flexible * modes.tangential).sum(axis=1)
