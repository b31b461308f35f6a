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
from hpcrub.model.imported.assembly import PAIRING, assemble, turned
from hpcrub.model.imported.bent_blades import MOST, BentBlades
from hpcrub.model.imported.craig_bampton import factorised, lowest_modes
from hpcrub.model.imported.frames import node_angle
from hpcrub.model.imported.neutral import NeutralModel, contact_rows

LIKE = 0.99  # smallest cosine between a bent shape and the blade's mode


class Bent(NamedTuple):
    """One blade bent into one of its modes, forwards and backwards."""

    moved: np.ndarray  # (n_nodes, 3) displacements of all nodes, x, y, z [m]
    forwards: NeutralModel  # the blade's stiffness about these displacements
    backwards: NeutralModel  # the same about their negative


def of_blade(blade: NeutralModel, shapes: Sequence[Bent]) -> BentBlades:
    """Second order of the contact nodes of one blade alone, its root held.

    blade: of kind disk; shapes: its first modes, one after the other, of any amplitude.
    Raises InputError: a shape is not the mode, or a stiffness is that of another blade.
    """
    if not 1 <= len(shapes) <= MOST:
        raise InputError(f"--second-order: {len(shapes)} bent shapes, 1 to {MOST} are allowed")
    alone = assemble(blade)
    K, M = alone.stiffness[0].tocsc(), alone.mass.tocsc()
    fields = np.stack([_on_rows(alone, shape.moved) for shape in shapes], axis=1)
    size = np.sqrt(np.einsum("na,na->a", fields, M @ fields))
    modes = fields / np.where(size > 0.0, size, 1.0)
    _check_modes(modes, lowest_modes(K, M, len(shapes))[1], M)
    squares = np.einsum("na,na->a", modes, K @ modes)
    rows = contact_rows(alone)
    factor = factorised(K)
    static, coupling = [], []
    for number, (shape, eps) in enumerate(zip(shapes, size, strict=True)):
        force = _change(alone, shape, number) @ modes / (2.0 * eps)
        static.append(factor.solve(force)[rows])  # (directions, C, c)
        coupling.append(modes.T @ force)
    C = np.stack(coupling, axis=1)  # (a, b, c)
    moves = modes[rows].transpose(1, 0, 2)  # (C, directions, a)
    carried = np.einsum("kda,abc->kdbc", moves / squares, C)
    tips = np.stack(static, axis=2).transpose(1, 0, 2, 3) - carried
    missing = 3 - len(rows)  # nodes that move in x and y alone
    return BentBlades(
        tips=np.pad(tips, ((0, 0), (0, missing), (0, 0), (0, 0))),
        coupling=C,
        modes=np.pad(moves, ((0, 0), (0, missing), (0, 0))),
    )


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
    nearest, reach = apart.argmin(axis=0), np.hypot(at[:, 0], at[:, 1]).max()
    worst = int(apart.min(axis=0).argmax())
    if not apart.min(axis=0)[worst] <= PAIRING * reach:
        x, y, z = 1e3 * at[worst]
        raise InputError(
            f"--second-order: the contact node at {x:.6g}, {y:.6g}, {z:.6g} mm is on no blade "
            f"like that of it, turned by 360/{N} degrees about z: the nearest one is "
            f"{1e3 * apart.min(axis=0)[worst]:.3g} mm away"
        )
    return model._replace(bent=bent.at(nearest))


def _on_rows(model: Any, moved: Any) -> Any:
    """Displacements x, y, z of all nodes (n_nodes, 3) on the rows of a cylindrical model."""
    angle = node_angle(model.nodes)
    c, s = np.cos(angle), np.sin(angle)
    parts = np.column_stack([c * moved[:, 0] + s * moved[:, 1],
                             c * moved[:, 1] - s * moved[:, 0], moved[:, 2]])  # fmt: skip
    node, direction = model.dof.T
    placed = (direction >= 1) & (direction <= 3)
    if not placed.all():
        raise InputError("--second-order: the blade has rows that are no displacements of nodes")
    return parts[node, direction - 1]


def _check_modes(modes: Any, exact: Any, M: Any) -> None:
    cosine = np.abs(np.einsum("na,na->a", modes, M @ exact))
    lost = np.flatnonzero(~(cosine >= LIKE))
    if len(lost):
        raise InputError(
            f"--second-order: bent shape {lost[0] + 1} is not mode {lost[0] + 1} of the blade "
            f"(cosine {cosine[lost[0]]:.3f}, at least {LIKE} is expected); all nodes are displaced "
            "in proportion to the mode"
        )


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
