"""Arrays of a model file that tell the second order of its blades: see `model.second_order`.

They are of one blade alone, its root held, and the same for all blades.
"""

from itertools import permutations
from typing import Any, NamedTuple

import numpy as np

from hpcrub.errors import InputError
from hpcrub.model import second_order
from hpcrub.model.imported.arrays import Arrays

TIPS, BLADE, MODES = "second_order_tips", "second_order_blade", "second_order_modes"
MOST = 6  # bent modes
# largest asymmetry, as a share of the largest entry: matrices of differences
UNEQUAL = {TIPS: 5e-4, BLADE: 0.01}
# Shortening of a blade by a motion u of its tip, over u^2 / 2R. A straight blade of length L has
# 1.2 R/L; the limits are less than 10^3 apart, so that no wrong unit of length passes
SHORTENS = 0.1, 60.0


class BentBlades(NamedTuple):
    """Second order of the tips by p mass-normalised modes, at C contact nodes, in SI units.

    Directions are radial, tangential and axial at each node.
    """

    tips: np.ndarray  # (C, 3, p, p) G of the motion of each contact node [1/(m kg)]
    coupling: np.ndarray  # (p, p, p) C [1/(m sqrt(kg) s2)]
    modes: np.ndarray  # (C, 3, p) motion of the contact nodes in each mode [1/sqrt(kg)]

    def at(self, order: np.ndarray) -> "BentBlades":
        """Those of other contact nodes, by their numbers."""
        return self._replace(tips=self.tips[order], modes=self.modes[order])


def taken(
    left: Arrays, n_contact: int, units: tuple[float, float, float], flip: np.ndarray
) -> BentBlades | None:
    """Take the arrays of a model file, in SI units; None where there are none.

    n_contact: number of contact nodes; units: length [m], mass [kg] and time [s] of the file;
    flip: signs (3,) of the directions. Raises InputError.
    """
    if not any(left.has(name) for name in (TIPS, BLADE, MODES)):
        return None
    length, mass, time = units
    modes = left.floats(MODES, 3, None)
    p = modes.shape[2]
    if not 1 <= p <= MOST:
        raise InputError(f"{MODES}: {p} modes, 1 to {MOST} are allowed")
    tips, coupling = left.floats(TIPS, 3, p, p), left.floats(BLADE, p, p)
    for name, values, n in ((MODES, modes, n_contact), (TIPS, tips, n_contact),
                            (BLADE, coupling, p)):  # fmt: skip
        if len(values) != n:
            what = "modes" if name == BLADE else "contact nodes"
            raise InputError(f"{name}: of {len(values)}, and there are {n} {what}")
    means = (tips + np.swapaxes(tips, 2, 3)) / 2.0, coupled(coupling)
    for name, values, mean in zip((TIPS, BLADE), (tips, coupling), means, strict=True):
        apart, most = float(np.abs(values - mean).max()), float(np.abs(values).max())
        if apart > UNEQUAL[name] * most:
            raise InputError(
                f"{name}: not symmetric in its modes, entries differ from the mean of their "
                f"permutations by {apart:.3g}; at most {UNEQUAL[name]:g} of the largest entry, "
                f"{most:.3g}, is allowed"
            )
    return BentBlades(
        tips=flip[:, None, None] * means[0] / (mass * length),
        coupling=means[1] / (length * np.sqrt(mass) * time**2),
        modes=flip[:, None] * modes / np.sqrt(mass),
    )


def stored(bent: BentBlades | None) -> dict[str, Any]:
    """Arrays of a model file, by name; the inverse of `taken` in SI units."""
    return {} if bent is None else {TIPS: bent.tips, BLADE: bent.coupling, MODES: bent.modes}


def coupled(C: np.ndarray) -> np.ndarray:
    """Mean of C (p, p, p) over the orders of its three modes."""
    return np.mean([C.transpose(order) for order in permutations(range(3))], axis=0)


def check(bent: BentBlades, radius: np.ndarray) -> float:
    """Return the shortening of a blade by a motion u of its tips in the first mode, over u^2 / 2R.

    radius: of the contact nodes (C,) [m]; means over them. Raises InputError for what no blade has.
    """
    square = (bent.modes[:, :, 0] ** 2).sum(axis=1).mean()
    if not square > 0.0:
        raise InputError(f"{MODES}: the first mode moves no contact node")
    shortens = float((radius * bent.tips[:, 0, 0, 0]).mean() / square)
    if shortens < 0.0:
        raise InputError(
            f"{TIPS}: the blade becomes longer when it bends, by {-shortens:.3g} u^2/2R for a "
            "motion u of its tips in the first mode; its radial entry [0, 0] must be positive: "
            "a tip moves outwards by -s G s / 2"
        )
    if not SHORTENS[0] <= shortens <= SHORTENS[1]:
        raise InputError(
            f"{TIPS}: the blade becomes shorter by {shortens:.3g} u^2/2R for a motion u of its "
            f"tips in the first mode, {SHORTENS[0]:g} to {SHORTENS[1]:g} are expected; are the "
            f"units of it and of {MODES} those of the file?"
        )
    return shortens


def before_casing(model: Any) -> tuple[np.ndarray, np.ndarray]:
    """G along normal, tangent and generator of the casing (C, 3, p, p), and its curvature (C,).

    model: NeutralModel with `bent`; SI units.
    """
    outward, along = (model.contact_normal[:, k, None, None] for k in (0, 2))
    radial, tangential, axial = np.moveaxis(model.bent.tips, 1, 0)
    turned = outward * radial + along * axial, tangential, outward * axial - along * radial
    radius = np.hypot(*model.nodes[model.contact_node, :2].T)
    return np.stack(turned, axis=1), model.contact_normal[:, 0] / radius


def size_of(model: Any) -> tuple[float, float] | None:
    """Shift and bend of `model.second_order.size_of`, of a NeutralModel; None: not known."""
    if model.bent is None:
        return None
    (G, curvature), omega = before_casing(model), None
    if model.blade_frequencies is not None:
        omega = 2 * np.pi * model.blade_frequencies[0, : len(model.bent.coupling)]
    motion = model.bent.modes[:, 1]
    return second_order.size_of(G, curvature, motion, model.bent.coupling, omega)
