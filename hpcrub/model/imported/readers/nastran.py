"""Reader of Nastran: matrices of a text OP4 file, grid points of bulk data, node lists as CSV.

Needs the package pyNastran.
"""

from typing import Any

import numpy as np
import scipy.sparse as sp

from hpcrub.errors import InputError, reading
from hpcrub.model.imported.readers.rows import File, Files, Lists, Mesh, Rows, arrays_of, whole
from hpcrub.model.imported.readers.text import numbers

STIFFNESS, MASS = "KGG", "MGG"
DIRECTIONS = 6


def read(
    path: File, mesh: File, lists: Lists, blade: File | None = None, stiffness: Files | None = None
) -> dict:
    """Read the arrays of a model file from files of Nastran.

    path: text OP4 file with KGG and MGG: six rows for every grid point, by increasing number.
    mesh: bulk data with the grid points; lists: names of CSV files with grid point numbers.
    blade: OP4 file with KGG of the blades alone, on all grid points.
    stiffness: OP4 files with KGG at two other speeds, {speed [Hz]: file}.
    Returns arrays without the rows that have neither mass nor stiffness.
    Raises InputError: the package or a file is missing or cannot be read.
    """
    try:
        from pyNastran.bdf.bdf import read_bdf
    except ImportError:
        raise InputError(
            "reading Nastran's files needs the package pyNastran: pip install pyNastran"
        ) from None
    with reading(mesh):
        grid = read_bdf(str(mesh), validate=False, xref=True, punch=None, debug=None)
    number = np.array(sorted(grid.nodes))
    place = np.array([grid.nodes[k].get_position() for k in number])
    corners = [element.node_ids for element in grid.elements.values()]
    speeds = {0.0: path} | (stiffness or {})
    files = {name: op4_matrices(name) for name in (*speeds.values(), blade) if name}
    matrices = files[path]
    if lost := {STIFFNESS, MASS} - set(matrices):
        raise InputError(f"{path}: there is no matrix {min(lost)}; there are {', '.join(matrices)}")
    entries = abs(matrices[STIFFNESS]), abs(matrices[MASS])
    used = np.flatnonzero(sum(matrix.sum(axis=0) for matrix in entries) != 0)
    K = {speed: _rows(files, name, STIFFNESS, number, used) for speed, name in speeds.items()}
    M = _rows(files, path, MASS, number, used)
    K_blade = _rows(files, blade, STIFFNESS, number, used) if blade else None
    return arrays_of(Mesh(number, place, _numbers, corners), lists, K, M, K_blade)


def op4_matrices(path: File) -> dict:
    """Read the matrices of an OP4 file, {name: sparse}. Raises InputError when it fails."""
    from pyNastran.op4.op4 import read_op4

    with reading(path):
        read = read_op4(str(path), debug=None)  # older versions return pairs (form, matrix)
        matrices = {key: m[1] if isinstance(m, tuple) else m.data for key, m in read.items()}
        return {key.upper(): sp.csr_array(matrix) for key, matrix in matrices.items()}


def _rows(files: Any, path: Any, name: str, number: Any, used: Any) -> Any:
    matrix = files[path].get(name)
    n = DIRECTIONS * len(number)
    if matrix is None or matrix.shape != (n, n):
        raise InputError(
            f"{path}: {name} is not there with {DIRECTIONS} rows for each of {len(number)} grid "
            "points"
        )
    node, direction = np.divmod(used, DIRECTIONS)
    return Rows(matrix[used][:, used], np.column_stack([number[node], direction + 1]), str(path))


def _numbers(name: str) -> Any:
    return whole(numbers(name), name)
