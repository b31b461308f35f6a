"""Reader of Nastran: matrices of an OP4 file, grid points of bulk data, node lists as CSV.

Needs the package pyNastran.
"""

import re
import tempfile
from typing import Any

import numpy as np
import scipy.sparse as sp

from hpcrub.errors import InputError, reading
from hpcrub.model.imported.readers.rows import File, Files, Lists, Mesh, Rows, arrays_of, whole
from hpcrub.model.imported.readers.text import existing, numbers, unpacked

STIFFNESS, MASS = "KGG", "MGG"
DIRECTIONS = 6
# pyNastran reads one way of writing text: formats as 1P,3E23.16, exponents with E
HEAD = re.compile(rb"^([ \d-]{32}.{8})\(?(?:1P)?,?(\d+)[ED](\d+\.\d+)\)?\s*$", re.MULTILINE)
IN_HEAD = rb"\g<1>1P,\g<2>E\g<3>"
EXPONENT = re.compile(rb"(\d)[Dd]([-+]\d)")
RECORD = b"\x18\0\0\0", b"\0\0\0\x18", b"\x30\0\0\0", b"\0\0\0\x30"  # a binary file begins so


def read(
    path: File, mesh: File, lists: Lists, blade: File | None = None, stiffness: Files | None = None
) -> dict:
    """Read the arrays of a model file from files of Nastran.

    path: OP4 file with KGG and MGG: six rows for every grid point and one for every scalar point,
        by increasing number; in the directions that each grid point has (CD).
    mesh: bulk data with the grid points; lists: names of CSV files with grid point numbers.
    blade: OP4 file with KGG of the blades alone, on all grid points.
    stiffness: OP4 files with KGG at two other speeds, {speed [Hz]: file}.
    Returns arrays without the rows that have neither mass nor stiffness.
    Raises InputError: the package or a file is missing or cannot be read.
    """
    try:
        from pyNastran.bdf.bdf import read_bdf
    except (ImportError, AttributeError):  # a version for another NumPy fails anyhow
        raise InputError(
            "reading Nastran's files needs the package pyNastran in a version for this NumPy: pip "
            'install "pyNastran>=1.3,<1.4"'
        ) from None
    with reading(mesh):
        grid = read_bdf(str(mesh), validate=False, xref=True, punch=None, debug=None)
    points = {k: grid.nodes[k] for k in sorted(grid.nodes)}
    place = np.array([point.get_position() for point in points.values()])
    axes = {
        k: _own_axes(p.cd_ref, x) for (k, p), x in zip(points.items(), place, strict=True) if p.Cd()
    }
    rows = _rows_of(points, [*grid.spoints, *grid.epoints])
    corners = [element.node_ids for element in grid.elements.values()]
    speeds = {0.0: path} | (stiffness or {})
    files = {name: op4_matrices(name) for name in (*speeds.values(), blade) if name}
    matrices = files[path]
    if lost := {STIFFNESS, MASS} - set(matrices):
        raise InputError(f"{path}: there is no matrix {min(lost)}; there are {', '.join(matrices)}")
    K = {speed: _rows(files, name, STIFFNESS, rows) for speed, name in speeds.items()}
    M = _rows(files, path, MASS, rows)
    K_blade = _rows(files, blade, STIFFNESS, rows) if blade else None
    entries = abs(K[0.0].matrix) + abs(M.matrix)
    used = np.flatnonzero(entries.sum(axis=0) + entries.sum(axis=1))
    K = {speed: part.of(used) for speed, part in K.items()}
    M, K_blade = M.of(used), K_blade and K_blade.of(used)
    mesh_of = Mesh(np.array(list(points)), place, _numbers, corners, axes)
    return arrays_of(mesh_of, lists, K, M, K_blade)


def _rows_of(points: Any, scalars: Any) -> np.ndarray:
    """Point and direction of every row (n, 2): six of a grid point, one, 0, of a scalar point."""
    directions = {k: range(1, DIRECTIONS + 1) for k in points} | {k: range(1) for k in scalars}
    return np.array([(k, d) for k in sorted(directions) for d in directions[k]], dtype=np.int64)


def _own_axes(system: Any, place: np.ndarray) -> np.ndarray:
    """Directions (3, 3), one in each row, that a coordinate system has at a place."""
    axes = system.beta()
    x, y, z = axes @ (place - system.origin)
    c, s = np.array([x, y]) / (np.hypot(x, y) or 1.0)
    if system.Type == "R" or not (c or s):  # on the axis of a cylinder the system's own count
        return axes
    axes = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) @ axes
    if system.Type == "C":
        return axes
    radial, tangential, axial = axes
    sine, cosine = np.array([np.hypot(x, y), z]) / np.hypot(np.hypot(x, y), z)
    return np.array([sine * radial + cosine * axial, cosine * radial - sine * axial, tangential])


def op4_matrices(path: File) -> dict:
    """Read the matrices of an OP4 file, text or binary, {name: sparse}. Raises InputError."""
    from pyNastran.op4.op4 import read_op4

    path = existing(path)
    with reading(path), tempfile.NamedTemporaryFile(suffix=".op4") as plain:
        data = unpacked(path)
        plain.write(
            data if data[:4] in RECORD else EXPONENT.sub(rb"\1E\2", HEAD.sub(IN_HEAD, data))
        )
        plain.flush()
        read = read_op4(plain.name, debug=None)  # older versions return pairs (form, matrix)
        matrices = {key: m[1] if isinstance(m, tuple) else m.data for key, m in read.items()}
        return {key.upper(): sp.csr_array(matrix) for key, matrix in matrices.items()}


def _rows(files: Any, path: Any, name: str, rows: Any) -> Any:
    matrix = files[path].get(name)
    if matrix is None or matrix.shape != (len(rows), len(rows)):
        there = "is not there" if matrix is None else f"has {matrix.shape[0]} rows"
        raise InputError(
            f"{path}: {name} {there}; {len(rows)} rows are expected, {DIRECTIONS} for each grid "
            "point of the bulk data and 1 for each scalar point"
        )
    return Rows(matrix, rows, str(path))


def _numbers(name: str) -> Any:
    return whole(numbers(name), name)
