"""Nodes with directions of their own, as Ansys's NROTAT and Nastran's CD make them.

The rows of such nodes are turned into the axes of the model, or into its cylindrical directions. A
node that is held in one direction of its own lacks a row, and fits where that direction is one of
the new ones.
"""

from typing import Any

import numpy as np
import scipy.sparse as sp

from hpcrub.errors import InputError
from hpcrub.model.imported.arrays import held_rows, symmetric, without
from hpcrub.model.imported.neutral import FRAMES

ALIGNED = 1e-9  # below it the cosine between two directions counts as 0


def in_one_frame(mesh: Any, parts: dict[Any, Any]) -> tuple[str, dict[Any, Any]]:
    """Turn matrices into directions that are the same, or those of the cylinder, at all nodes.

    mesh: a `rows.Mesh`; parts: `rows.Rows` of the same rows, or of some of them, by name, the first
        one of a stiffness.
    Returns the frame of a model file and the matrices. Raises InputError for a node that is held
    in a direction of its own that no frame has.
    """
    if not mesh.axes:
        return FRAMES[0], parts
    first = next(iter(parts.values()))
    held = set(map(tuple, first.dof[held_rows(first.matrix)].tolist()))
    place = dict(zip(mesh.number.tolist(), mesh.place, strict=True))
    lost = 0
    for frame in FRAMES:
        axes: dict[int, np.ndarray] = mesh.axes
        if frame == "cylindrical":
            axes = {n: axes.get(n, np.eye(3)) @ cylindrical(x).T for n, x in place.items()}
        try:
            return frame, {name: _turned(part, axes, held) for name, part in parts.items()}
        except _NotAlongError as error:
            lost = error.args[0]
    raise InputError(
        f"{first.name}: node {lost} is held in a direction of its own; such directions must all "
        "be x, y or z, or all radial, tangential or axial; hold it in all three, or write the "
        "matrices without supports and name the held nodes (--fixed)"
    )


class _NotAlongError(Exception):
    """A node's rows cannot be turned, because another direction of it is held or has no row."""


def cylindrical(place: np.ndarray) -> np.ndarray:
    """Radial, tangential and axial unit vectors, the rows of (3, 3), at a place (3,) about z."""
    angle = np.arctan2(place[1], place[0])
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def _turned(part: Any, axes: dict[int, np.ndarray], held: set[tuple[int, int]]) -> Any:
    """Matrix with the rows of nodes turned; axes: {node: its directions in the new ones}.

    The rows of one node are turned together: displacements, rotations, and each of them apart
    where some are held by a huge entry, which must not mix with the others.
    """
    groups: dict[tuple[int, int, bool], list[int]] = {}
    kept = []
    for row, (node, direction) in enumerate(part.dof.tolist()):
        if node in axes and direction > 0:
            key = node, (direction - 1) // 3, (node, direction) in held
            groups.setdefault(key, []).append(row)
        else:
            kept.append(row)
    dof, entries = part.dof.copy(), [(np.array(kept), np.array(kept), np.ones(len(kept)))]
    for (node, triad, _), rows in groups.items():
        cosines = axes[node][(part.dof[rows, 1] - 1) % 3]
        cosines = np.where(np.abs(cosines) < ALIGNED, 0.0, cosines)
        new = np.flatnonzero(cosines.any(axis=0))
        if len(new) != len(rows):
            raise _NotAlongError(node)
        entries.append((np.repeat(rows, len(rows)), np.tile(rows, len(rows)), cosines[:, new]))
        dof[rows, 1] = 3 * triad + new + 1
    i, j, cosine = (
        np.concatenate([np.ravel(x) for x in column]) for column in zip(*entries, strict=True)
    )
    T = sp.csr_array((cosine, (i.astype(int), j.astype(int))), shape=(len(dof), len(dof)))
    whole = symmetric(part.name, part.matrix)
    rest = without(whole, held_rows(whole))  # rounding of huge entries would exceed all others
    return part._replace(matrix=sp.csr_array(T.T @ rest @ T + (whole - rest)), dof=dof)
