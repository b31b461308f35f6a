"""Conversion of displacements between Cartesian axes and the cylindrical frame of each node."""

from typing import Any

import numpy as np
import scipy.sparse as sp

from hpcrub.errors import InputError
from hpcrub.model.imported.neutral import NONE, NeutralModel, row_table

PARTNER = np.array([0, 2, 1, 0, 5, 4, 0])  # direction that turns with each about z; 0: none


def node_angle(nodes: np.ndarray) -> np.ndarray:
    """Angle of every node about z (n_nodes,) [rad]; NaN for nodes without a place."""
    return np.arctan2(nodes[:, 1], nodes[:, 0])


def to_cartesian(nodes: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Convert radial, tangential and axial displacements of nodes to x, y, z.

    nodes: (n, 3) [m]; parts: (n, 3, ...). Returns (n, 3, ...).
    """
    angle = node_angle(nodes).reshape(-1, *(1,) * (parts.ndim - 2))
    c, s = np.cos(angle), np.sin(angle)
    radial, tangential, axial = np.moveaxis(parts, 1, 0)
    return np.stack([c * radial - s * tangential, s * radial + c * tangential, axial], axis=1)


def to_cylindrical(model: NeutralModel) -> NeutralModel:
    """Turn the rows of a NeutralModel into the cylindrical frames of their nodes.

    Rows stay as they are where a node has no place, or lacks or holds one direction of a pair only.
    Raises InputError for such a node on a side of a sector, whose directions must turn with it.
    """
    if model.frame == "cylindrical":
        return model
    T = turn(model.dof, model.nodes, model.fixed)
    _check_sides(model)

    def turned(matrix: Any) -> Any:
        if matrix is None or matrix.ndim == 2:
            return matrix if matrix is None else T.T @ matrix @ T
        return np.stack([turned(one) for one in matrix])

    part = model.participation
    return model._replace(
        participation=None if part is None else np.stack([one @ T for one in part]),
        stress=model.stress @ T,
        frame="cylindrical",
        mass=turned(model.mass),
        stiffness=tuple(map(turned, model.stiffness)),
        blade_stiffness=turned(model.blade_stiffness),
    )


def turn(dof: np.ndarray, nodes: np.ndarray, fixed: np.ndarray = NONE) -> sp.csr_array:
    """Matrix from cylindrical to Cartesian displacements of all rows, (n, n) sparse.

    fixed: held rows; a pair of which one only is held is not turned.
    """
    node, direction = dof.T
    partner = _partners(dof, len(nodes), fixed)
    angle, every = node_angle(nodes)[node], np.arange(len(dof))
    turns = (partner >= 0) & np.isfinite(angle)
    along = np.where(turns, np.cos(angle), 1.0)
    across = np.where(direction < PARTNER[direction], -np.sin(angle), np.sin(angle))
    rows = np.concatenate([every, every[turns]])
    columns = np.concatenate([every, partner[turns]])
    return sp.csr_array((np.concatenate([along, across[turns]]), (rows, columns)))


def _partners(dof: Any, n_nodes: int, fixed: Any) -> Any:
    """Row that turns with each about z (n,); -1 for none, and where one only of both is held."""
    partner = row_table(dof, n_nodes)[dof[:, 0], PARTNER[dof[:, 1]]]
    held = np.isin(np.arange(len(dof)), fixed)
    return np.where(held == held[partner], partner, -1)


def _check_sides(model: Any) -> None:
    alone = (PARTNER[model.dof[:, 1]] > 0) & (
        _partners(model.dof, len(model.nodes), model.fixed) < 0
    )
    for node in set(model.dof[alone, 0].tolist()) & {*model.low.tolist(), *model.high.tolist()}:
        x, y, z = 1e3 * model.nodes[node]
        raise InputError(
            f"low, high: the node at {x:.6g}, {y:.6g}, {z:.6g} mm is held in one of x and y only, "
            "which is another direction on the other side; hold both, or neither"
        )


def about_z(arrays: dict, axis: str) -> None:
    """Rename the axes in the arrays of a model file (modified) so that the disk turns about z."""
    shift = {"z": 0, "x": 1, "y": 2}[axis]  # x, y, z become y, z, x for a rotation about x
    if not shift:
        return
    arrays["nodes"] = np.roll(arrays["nodes"], -shift, axis=1)
    node, direction = np.asarray(arrays["dof"]).T
    turned = (direction - 1) // 3 * 3 + (direction - 1 - shift) % 3 + 1
    arrays["dof"] = np.column_stack([node, np.where(direction > 0, turned, 0)])
