"""Reader of Ansys: matrices of `.full` files, mesh and components of a `.cdb` archive.

Needs the package ansys-mapdl-reader.
"""

import contextlib
import io
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.spatial.transform import Rotation

from hpcrub.errors import InputError, reading
from hpcrub.model.imported.readers.deck import listed
from hpcrub.model.imported.readers.rows import File, Files, Lists, Mesh, Rows, arrays_of


def read(
    path: File, mesh: File, lists: Lists, blade: File | None = None, stiffness: Files | None = None
) -> dict:
    """Read the arrays of a model file from files of Ansys.

    path: NAME.full of the disk at rest (WRFULL, or a modal analysis).
    mesh: NAME.cdb (CDWRITE) with the nodes and their components, which `lists` names.
    blade: NAME.full of the element component that CYCFREQ,BLADE names, alone.
    stiffness: NAME.full of prestressed analyses at two other speeds [Hz].
    Raises InputError: the package, a file or a component is missing.
    """
    try:
        from ansys.mapdl.reader import Archive
    except ImportError:
        raise InputError(
            "reading Ansys's files needs the package ansys-mapdl-reader: "
            "pip install ansys-mapdl-reader"
        ) from None
    archive = _quietly(mesh, lambda: Archive(str(mesh), parse_vtk=False))
    components = {name.upper(): nodes for name, nodes in archive.node_components.items()}
    order = np.argsort(archive.nnum)
    number, place = np.asarray(archive.nnum)[order], np.asarray(archive.nodes)[order, :3]
    axes = own_axes(number, np.asarray(archive.node_angles)[order])
    # a degenerate hexahedron lists some corners twice
    corners = [dict.fromkeys(map(int, e[10:18])) for e in archive.elem if len(e) >= 18]
    elements = [[node for node in nodes if node] for nodes in corners]

    def nodes_of(name: str) -> Any:
        return listed(components, name, f"{mesh}: there is no node component")

    grid = Mesh(number, place, nodes_of, elements, axes)
    K, M = full_matrices(path)
    if M is None:
        raise InputError(
            f"{path}: there is no mass in it; write it in a modal analysis (ANTYPE,MODAL, then "
            "WRFULL,1 and SOLVE)"
        )
    others = {speed: full_matrices(name)[0] for speed, name in (stiffness or {}).items()}
    return arrays_of(grid, lists, {0.0: K} | others, M, full_matrices(blade)[0] if blade else None)


def own_axes(number: np.ndarray, angles: np.ndarray) -> dict[int, np.ndarray]:
    """Directions of turned nodes, {node: (3, 3), a direction in each row}.

    angles: THXY, THYZ, THZX of every node [degrees]: about its z, then its x, then its y.
    """
    turned = np.flatnonzero(angles.any(axis=1))
    axes = Rotation.from_euler("ZXY", angles[turned], degrees=True).as_matrix()
    return dict(zip(number[turned].tolist(), axes.transpose(0, 2, 1), strict=True))


def full_matrices(path: File) -> tuple[Rows, Rows | None]:
    """Stiffness and, if it is there, mass of a `.full` file, without the rows of held directions.

    Raises InputError.
    """
    from ansys.mapdl.reader import read_binary

    dof, K, M = _quietly(path, lambda: read_binary(str(path)).load_km(as_sparse=True, sort=True))
    if K is None:
        raise InputError(f"{path}: there is no stiffness in it")
    rows = np.column_stack([dof[:, 0], dof[:, 1] + 1]).astype(np.int64)
    matrices = [_upper(matrix) for matrix in (K, M) if matrix is not None]
    entries = sum(abs(matrix) for matrix in matrices)
    used = np.flatnonzero(entries.sum(axis=0) + entries.sum(axis=1))  # the others are held
    parts = [Rows(matrix, rows, str(path)).of(used) for matrix in matrices]
    return parts[0], parts[1] if len(parts) == 2 else None


def _upper(matrix: Any) -> Any:
    """Move all entries into the upper triangle: `sort` may have moved some below the diagonal."""
    upper, lower = sp.triu(matrix), sp.tril(matrix, -1)
    return sp.csr_array(upper + lower.T)


def _quietly(path: Any, work: Any) -> Any:
    """Call a reader, and keep its warnings off the screen."""
    with reading(path), contextlib.redirect_stdout(io.StringIO()):
        return work()
