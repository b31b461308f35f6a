"""Which blade a contact node belongs to, for readers whose files do not say."""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from hpcrub.errors import InputError

SHARED = 1e-9  # of the largest entry: below, a stiffness joins no rows


def joined(K: sp.csr_array) -> tuple[np.ndarray, np.ndarray]:
    """Connected part (n,) int of every row of a sparse stiffness; whether it has any (n,) bool."""
    strong = abs(K) > SHARED * abs(K).max()
    _, part = connected_components(strong, directed=False)
    return part, np.asarray(strong.sum(axis=0)).ravel() > 0


def number(
    nodes: np.ndarray,
    dof: np.ndarray,
    contact_node: np.ndarray,
    blade_stiffness: sp.csr_array | None,
) -> np.ndarray:
    """Blade of every contact node of a whole disk (C,) int, counted by angle from that at x > 0.

    blade_stiffness: (n, n), of all blades, which are its connected parts; the others: as of a
        NeutralModel.
    Raises InputError: there is none, or a contact node is on no row.
    """
    if blade_stiffness is None:
        raise InputError(
            "contact_blade: a whole disk needs the blade of every contact node, or the stiffness "
            "of the blades (--blade, K_blade), which tells them apart"
        )
    part, _ = joined(blade_stiffness)
    row = {node: k for k, node in enumerate(dof[:, 0].tolist())}
    if lost := [node for node in contact_node.tolist() if node not in row]:
        raise InputError(f"contact_node: node {lost[0]} has no rows")
    _, group = np.unique(part[[row[node] for node in contact_node.tolist()]], return_inverse=True)
    x, y = (np.bincount(group, nodes[contact_node, axis]) for axis in (0, 1))
    pitch = 2 * np.pi / len(x)
    turn = np.mod(np.arctan2(y, x) + pitch / 2, 2 * np.pi)  # the first one may lie about 0
    order = np.empty(len(x), dtype=np.int64)
    order[np.argsort(turn)] = np.arange(len(x))
    return order[group]
