"""Types and functions that all readers share: mesh, skin, node lists, matrices with their rows."""

from collections.abc import Callable
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from hpcrub.errors import InputError
from hpcrub.model.imported.arrays import stored, symmetric
from hpcrub.model.imported.neutral import AT_SPEEDS
from hpcrub.model.imported.readers.nodal import in_one_frame

File = str | Path
Files = dict[float, File]  # {speed of rotation [Hz]: file}
TETRAHEDRON = ((0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3))
WEDGE = ((0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (0, 2, 5, 3))
HEXAHEDRON = (
    (0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (0, 3, 7, 4),
)  # fmt: skip
FACES = {4: TETRAHEDRON, 10: TETRAHEDRON, 6: WEDGE, 15: WEDGE, 8: HEXAHEDRON, 20: HEXAHEDRON}


class Rows(NamedTuple):
    """A matrix whose rows have the node numbers and directions of another program."""

    matrix: sp.csr_array  # (n, n) stiffness or mass
    dof: np.ndarray  # (n, 2) node number and direction
    name: str  # of its file, for messages

    def of(self, rows: np.ndarray) -> "Rows":
        """Return the matrix of some of the rows (any,) only."""
        return self._replace(matrix=self.matrix[rows][:, rows], dof=self.dof[rows])


class Mesh(NamedTuple):
    """Nodes of another program, by that program's numbers."""

    number: np.ndarray  # (n,) node numbers, increasing
    place: np.ndarray  # (n, 3) coordinates
    nodes_of: Callable[[str], np.ndarray]  # returns the node numbers of a list by name
    elements: list  # node numbers of each element, corners first; may be empty
    axes: dict[int, np.ndarray] = {}  # {node: (3, 3) own directions, the rows} of turned nodes


class Lists(NamedTuple):
    """Names of the lists of nodes that make a mesh a bladed disk."""

    contact: str  # nodes that may touch the casing
    low: str | None = None  # of one sector: its side at the smaller angle
    high: str | None = None  # its other side
    n_sectors: int = 0
    fixed: str | None = None  # held nodes, if the matrices still have rows for them


def arrays_of(
    mesh: Mesh, lists: Lists, stiffness: dict[float, Rows], mass: Rows, blade: Rows | None = None
) -> dict:
    """Arrays of a model file, without `units` and, for a whole disk, `contact_blade`.

    stiffness: {speed [Hz]: matrix} at one or three speeds; blade: stiffness of the blades alone.
    Raises InputError: a list or node is missing, or a matrix has rows that the mass matrix lacks.
    """
    if len(stiffness) not in (1, 3):
        raise InputError(f"--stiffness: {len(stiffness) - 1} other speeds given; two are needed")
    parts: dict[Any, Rows] = {**stiffness, "M": mass}
    if blade:
        parts["K_blade"] = blade
    frame, parts = in_one_frame(mesh, parts)
    dof = parts["M"].dof
    arrays = {"hpcrub_model": np.array(1), "frame": np.array(frame)}
    arrays |= _mesh_arrays(mesh, lists, dof, mass.name)
    names = ("K",) if len(stiffness) == 1 else AT_SPEEDS
    if len(stiffness) == 3:
        arrays["speeds_hz"] = np.array(list(stiffness), dtype=float)
    name_of = dict(zip(stiffness, names, strict=True))
    matrices = {key: spread(part, dof) for key, part in parts.items()}
    for one, other in combinations(stiffness, 2):
        if abs(matrices[one] - matrices[other]).max() == 0.0:
            raise InputError(
                f"--stiffness: {stiffness[one].name} and {stiffness[other].name} hold the same "
                f"matrix, though one is of {one:g} Hz and the other of {other:g} Hz"
            )
    for key, matrix in matrices.items():
        arrays |= stored(name_of.get(key, key), matrix)
    return arrays


def _mesh_arrays(mesh: Mesh, lists: Lists, dof: np.ndarray, name: str) -> dict:
    """Arrays of nodes, rows (any, 2) and lists of nodes; name: of the file of the rows."""
    number = np.union1d(mesh.number, dof[:, 0])  # inner nodes of elements have no place
    place = np.full((len(number), 3), np.nan)
    place[places(mesh.number, number, name)] = mesh.place

    def named(name: Any) -> Any:
        return places(mesh.nodes_of(name), number, name)

    arrays = {
        "kind": np.array("sector" if lists.low else "disk"),
        "nodes": place,
        "dof": np.column_stack([places(dof[:, 0], number, name), dof[:, 1]]),
        "contact_node": named(lists.contact),
        "surface": skin([places(corners, number, name) for corners in mesh.elements]),
    }
    if lists.low:
        arrays |= {"low": named(lists.low), "high": named(lists.high)}
        arrays["n_sectors"] = np.array(lists.n_sectors)
    if lists.fixed:
        arrays["fixed"] = np.flatnonzero(np.isin(arrays["dof"][:, 0], named(lists.fixed)))
    return arrays


def spread(part: Rows, dof: np.ndarray) -> sp.csr_array:
    """Spread a symmetric matrix onto the n rows `dof`. Raises InputError when dof lacks a row."""
    place = {tuple(pair): k for k, pair in enumerate(dof.tolist())}
    try:
        at = np.array([place[tuple(pair)] for pair in part.dof.tolist()])
    except KeyError as lost:
        node, direction = lost.args[0]
        raise InputError(
            f"{part.name}: node {node}, direction {direction} is no row of the mass matrix"
        ) from None
    entries = sp.coo_array(symmetric(part.name, part.matrix))  # rows may change their order
    shape = (len(dof), len(dof))
    return sp.coo_array((entries.data, (at[entries.row], at[entries.col])), shape=shape).tocsr()


def places(numbers: np.ndarray, nodes: np.ndarray, what: str) -> np.ndarray:
    """Indices of node numbers in the increasing `nodes`. Raises InputError for unknown ones."""
    numbers = np.asarray(numbers)
    at = np.minimum(np.searchsorted(nodes, numbers), len(nodes) - 1)
    wrong = nodes[at] != numbers
    if wrong.any():
        raise InputError(f"{what}: there is no node {numbers[wrong][0]:g}")
    return at


def whole(values: np.ndarray, what: str) -> np.ndarray:
    """Convert numbers of a table to integers. Raises InputError for a fraction."""
    integers = values.astype(np.int64)
    if (integers != values).any():
        raise InputError(f"{what}: {values[integers != values][0]:g} is no whole number")
    return integers


def skin(elements: list) -> np.ndarray:
    """Outer faces of a mesh: those that belong to one element only.

    elements: nodes of each, corners first; only tetrahedra, wedges and hexahedra have faces.
    Returns corners (F, 4) int of every outer face; a triangle repeats its last corner.
    """
    seen = {}
    for nodes in elements:
        for face in FACES.get(len(nodes), ()):
            corners = [int(nodes[k]) for k in face]
            key = tuple(sorted(corners))
            seen[key] = None if key in seen else corners
    faces = [face if len(face) == 4 else [*face, face[-1]] for face in seen.values() if face]
    return np.array(faces, dtype=np.int64).reshape(-1, 4)
