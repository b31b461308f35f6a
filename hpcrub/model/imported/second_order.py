"""Second order of the blades of a reduced model, from the arrays of `bent_blades`."""

from typing import Any

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from hpcrub.errors import InputError
from hpcrub.model.imported import bent_blades
from hpcrub.model.imported.bent_blades import BLADE, MODES
from hpcrub.model.imported.neutral import NeutralModel, contact_rows
from hpcrub.model.second_order import SecondOrder

LIKE = 0.8  # smallest cosine between the tips' motions in a mode of the file and in its blades
SIZES = 0.5, 2.0  # ratio of the sizes of both
STRONG = 1e3  # of C s, in units of w^2 u / R for a motion u of the tip: what no blade has


def second_order(model: NeutralModel) -> SecondOrder | None:
    """Second order of the blades of a reduced, cylindrical model; None where it tells none.

    Raises InputError: the modes are not those of `blade_participation`, or C cannot be right.
    """
    own = model.bent
    if own is None:
        return None
    p, n_modes = len(own.coupling), 0
    if model.participation is not None and model.blade_frequencies is not None:
        n_modes = model.participation.shape[1]
    if p > n_modes:
        raise InputError(
            f"{MODES}: {p} modes, and the blades have {n_modes} cantilever modes; second order "
            "needs blade_frequencies_hz and blade_participation, which --reduce makes of K_blade"
        )
    omega = 2 * np.pi * model.blade_frequencies[0, :p]
    radius = np.hypot(*model.nodes[model.contact_node, :2].T)
    bent_blades.check(own, radius)
    _check_coupling(own, omega, float(radius.max()))
    shortening, curvature = bent_blades.before_casing(model)
    return SecondOrder(
        participation=_signs(model, p)[:, :, None] * model.participation[:, :p],
        shortening=shortening,
        observed=shortening[:, 1],
        coupling=own.coupling,
        omega=omega,
        curvature=curvature,
        motion=own.modes[:, 1],
    )


def _signs(model: Any, p: int) -> Any:
    """Signs (N, p) that turn the modes of every blade into those of the file's second order.

    Of all motions in which one amplitude of the bent modes is one and all others are zero, that of
    least energy is the mode of one blade alone: K^-1 P^T (P K^-1 P^T)^-1.
    """
    loads = model.participation[:, :p].reshape(-1, len(model.dof)).T
    try:
        moved = cho_solve(cho_factor(model.stiffness[0]), loads)
        moved = cho_solve(cho_factor(loads.T @ moved), moved.T).T
    except np.linalg.LinAlgError:
        raise InputError(
            "K, blade_participation: the disk is not held, or the modes of its blades are not "
            "independent"
        ) from None
    rows = contact_rows(model)
    directions = len(rows)
    signs = np.zeros((model.n_blades, p))
    for blade in range(model.n_blades):
        mine = model.contact_blade == blade
        found = moved[rows[:, mine]][..., blade * p : (blade + 1) * p]
        told = model.bent.modes[mine, :directions].transpose(1, 0, 2)
        size, other = (np.sqrt((a**2).sum(axis=(0, 1))) for a in (told, found))
        cosine = (told * found).sum(axis=(0, 1)) / np.maximum(size * other, 1e-300)
        for mode in range(p):
            _check_mode(blade, mode, cosine[mode], size[mode] / max(other[mode], 1e-300))
        signs[blade] = np.sign(cosine)
    return signs


def _check_mode(blade: int, mode: int, cosine: float, ratio: float) -> None:
    if abs(cosine) < LIKE:
        raise InputError(
            f"{MODES}: mode {mode} does not move the tips as that of blade {blade} does by "
            f"blade_participation (cosine {cosine:.2f}, at least {LIKE:g} is expected); modes are "
            "those of a blade alone, its root held, in the order of their frequencies"
        )
    if not SIZES[0] <= ratio <= SIZES[1]:
        raise InputError(
            f"{MODES}: mode {mode} moves the tips {ratio:.3g} times as far as that of blade "
            f"{blade} does by blade_participation, {SIZES[0]:g} to {SIZES[1]:g} is expected; are "
            "modes mass-normalised, and the units those of the file?"
        )


def _check_coupling(own: Any, omega: Any, radius: float) -> None:
    """Raise InputError for a C of wrong units."""
    square = np.cbrt(np.einsum("a,b,c->abc", *3 * [omega**2]))
    tip = np.sqrt((own.modes[:, :, 0] ** 2).sum(axis=1).mean())  # of a unit of the first mode
    strongest = float(np.abs(own.coupling / square).max() * radius / tip)  # in w^2 u / R
    if strongest > STRONG:
        raise InputError(
            f"{BLADE}: bent by a hundredth of the tip's radius the blade would change its "
            f"stiffness by {strongest / 100:.3g} of it; are the units those of the file?"
        )
