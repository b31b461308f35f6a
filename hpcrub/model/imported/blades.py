"""Which blade a contact node belongs to, for readers whose files do not say."""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from hpcrub.errors import InputError

SHARED = 1e-9  # of the largest entry: below, a stiffness joins no rows


def joined(K: sp.csr_array) -> tuple[np.ndarray, np.ndarray]:
    """Connected parts of a sparse stiffness.

    Returns part (n,) int, part that every row belongs to; touched (n,) bool, whether a row has any
    stiffness.
    """
    strong = abs(K) > SHARED * abs(K).max()
    _, part = connected_components(strong, directed=False)
    return part, np.asarray(strong.sum(axis=0)).ravel() > 0


def number(
    nodes: np.ndarray,
    dof: np.ndarray,
    contact_node: np.ndarray,
    blade_stiffness: sp.csr_array | None,
    n_blades: int = 0,
) -> np.ndarray:
    """Blade of every contact node of a whole disk, counted by angle from that at x > 0.

    nodes: (n_nodes, 3).
    dof: (n, 2).
    contact_node: (C,).
    blade_stiffness: (n, n), of all blades, or None, its connected parts are the blades.
    n_blades: without it: the number of clusters of nearby contact nodes that are blades.
    Returns (C,) int.
    Raises InputError: neither is known, or they differ.
    """
    if blade_stiffness is not None:
        part, _ = joined(blade_stiffness)
        row = {node: k for k, node in enumerate(dof[:, 0].tolist())}
        if lost := [node for node in contact_node.tolist() if node not in row]:
            raise InputError(f"contact_node: node {lost[0]} has no rows")
        group = part[[row[node] for node in contact_node.tolist()]]
        if n_blades and len(np.unique(group)) != n_blades:
            raise InputError(
                f"--blades: {n_blades} given, but the contact nodes lie on {len(np.unique(group))} "
                "separate parts of the blades' stiffness"
            )
    elif n_blades:
        from scipy.cluster.hierarchy import fcluster, linkage  # for such disks only

        group = fcluster(linkage(nodes[contact_node], "single"), n_blades, "maxclust")
    else:
        raise InputError(
            "--blades: a whole disk without the blades' stiffness needs the number of blades"
        )
    _, group = np.unique(group, return_inverse=True)
    x, y = (np.bincount(group, nodes[contact_node, axis]) for axis in (0, 1))
    pitch = 2 * np.pi / len(x)
    turn = np.mod(np.arctan2(y, x) + pitch / 2, 2 * np.pi)  # the first one may lie about 0
    order = np.empty(len(x), dtype=np.int64)
    order[np.argsort(turn)] = np.arange(len(x))
    return order[group]
