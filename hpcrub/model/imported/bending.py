"""Second order of a blade from its tangent stiffness about bent shapes.

The stiffness about displacements u of all nodes is K + V3(u) + terms of second order in u, so that

    V3(mode b) = [K_T(+eps mode b) - K_T(-eps mode b)] / (2 eps).

As V3 is symmetric in all it acts on, it is needed of the p bent modes only, and no load has to be
applied: with g_bc = V3(mode b) mode c, the entries [b, c] of G and C are

    C_abc = mode a . g_bc,    G_e = e . K^-1 g_bc - sum_a (mode a . e) / w_a^2 C_abc.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from hpcrub.errors import InputError
from hpcrub.model.imported import bent_blades
from hpcrub.model.imported.assembly import PAIRING, assemble, turned
from hpcrub.model.imported.bent_blades import MOST, BentBlades
from hpcrub.model.imported.craig_bampton import factorised, lowest_modes
from hpcrub.model.imported.frames import node_angle
from hpcrub.model.imported.neutral import NeutralModel, contact_rows

UNEQUAL = 0.05  # largest asymmetry, as a share of the largest entry: C3D8I of CalculiX has 0.03
LIKE = 0.999  # smallest cosine between a bent shape and the blade's mode


class BentShape(NamedTuple):
    """One blade bent into one of its modes, forwards and backwards."""

    moved: np.ndarray  # (n_nodes, 3) displacements of all nodes, x, y, z [m]
    forwards: NeutralModel  # the blade's stiffness about these displacements
    backwards: NeutralModel  # the same about their negative


def of_blade(blade: NeutralModel, shapes: Sequence[BentShape]) -> BentBlades:
    """Second order of the contact nodes of one blade alone, its root held.

    blade: of kind disk; shapes: its first modes, one after the other, of any amplitude.
    Raises InputError: a shape is not the mode, or a stiffness is that of another blade.
    """
    if not 1 <= len(shapes) <= MOST:
        raise InputError(f"--second-order: {len(shapes)} bent shapes, 1 to {MOST} are allowed")
    alone = assemble(blade)
    K = alone.stiffness[0].tocsc()
    squares, modes = lowest_modes(K, alone.mass.tocsc(), len(shapes))
    rows, factor = contact_rows(alone), factorised(K)
    static, coupling = [], []  # of each mode b
    for number, shape in enumerate(shapes):
        eps = _amplitude(alone, shape.moved, modes[:, number], number)
        force = _change(alone, shape, number) @ modes / (2.0 * eps)
        static.append(factor.solve(force)[rows])  # (directions, C, c)
        coupling.append(modes.T @ force)
    C = bent_blades.coupled(np.stack(coupling, axis=1))
    moves = modes[rows].transpose(1, 0, 2)  # (C, directions, a)
    carried = np.einsum("kda,abc->kdbc", moves / squares, C)
    tips = _symmetric(np.stack(static, axis=2).transpose(1, 0, 2, 3)) - carried
    missing = (0, 0), (0, 3 - len(rows)), (0, 0), (0, 0)  # of nodes that move in x and y alone
    return BentBlades(np.pad(tips, missing), C, np.pad(moves, missing[:3]))


def onto(model: NeutralModel, blade: NeutralModel, bent: BentBlades) -> NeutralModel:
    """A model whose blades all bend as that one does; its contact nodes are found by their places.

    blade, bent: the blade and the result of `of_blade`. Raises InputError: a contact node of the
    model is on no such blade.
    """
    N = model.n_blades
    places = blade.nodes[blade.contact_node]
    copies = np.stack([turned(places, 2 * np.pi * k / N) for k in range(N)])
    at = model.nodes[model.contact_node]
    apart = np.linalg.norm(copies[:, :, None] - at, axis=3).min(axis=0)  # (own, C)
    nearest, reach = apart.argmin(axis=0), float(np.hypot(at[:, 0], at[:, 1]).max())
    missed = apart.min(axis=0)
    worst = int(missed.argmax())
    if not missed[worst] <= PAIRING * reach:
        x, y, z = 1e3 * at[worst]
        raise InputError(
            f"--second-order: the contact node at {x:.6g}, {y:.6g}, {z:.6g} mm is on no blade "
            f"like that of it, turned by 360/{N} degrees about z: the nearest one is "
            f"{1e3 * missed[worst]:.3g} mm away"
        )
    return model._replace(bent=bent.at(nearest))


def _amplitude(alone: Any, moved: Any, mode: Any, number: int) -> float:
    """Amplitude of a mode (n,) in displacements x, y, z of all nodes; inner nodes have no place."""
    angle = node_angle(alone.nodes)
    c, s = np.cos(angle), np.sin(angle)
    parts = np.column_stack([c * moved[:, 0] + s * moved[:, 1],
                             c * moved[:, 1] - s * moved[:, 0], moved[:, 2]])  # fmt: skip
    node, direction = alone.dof.T
    placed = (direction >= 1) & (direction <= 3) & np.isfinite(angle[node])
    told, exact = parts[node[placed], direction[placed] - 1], mode[placed]
    size = float(np.linalg.norm(told) * np.linalg.norm(exact))
    cosine = float(told @ exact) / size if size > 0.0 else 0.0
    if not abs(cosine) >= LIKE:
        raise InputError(
            f"--second-order: bent shape {number + 1} is not mode {number + 1} of the blade "
            f"(cosine {cosine:.4f}, at least {LIKE} is expected); all nodes are displaced in "
            "proportion to the mode"
        )
    return float(told @ exact) / float(exact @ exact)


def _symmetric(static: Any) -> Any:
    """Shortening of the static displacements, made symmetric. Raises InputError."""
    across = np.swapaxes(static, 2, 3)
    apart = float(np.abs(static - across).max() / np.abs(static).max())
    if not apart <= UNEQUAL:
        raise InputError(
            f"--second-order: the stiffness of one bent shape in another and the other way round "
            f"differ by {100 * apart:.2g} %, at most {100 * UNEQUAL:g} % is allowed; are forwards "
            "and backwards about plus and minus the displacements of the table, in its units?"
        )
    return (static + across) / 2.0


def _change(alone: Any, shape: Any, number: int) -> Any:
    """K_T forwards less K_T backwards, on the rows of the blade."""
    out = []
    for one in (shape.forwards, shape.backwards):
        other = assemble(one)
        if other.dof.shape != alone.dof.shape or (other.dof != alone.dof).any():
            raise InputError(
                f"--second-order: a stiffness of bent shape {number + 1} has not the rows of the "
                "blade; write both by the same deck, with the same root held"
            )
        out.append(other.stiffness[0])
    return out[0] - out[1]
