"""Reader of Ansys: matrices of `.full` files, mesh and components of a `.cdb` archive.

Needs the package ansys-mapdl-reader.
"""

import contextlib
import io
from typing import Any

import numpy as np
import scipy.sparse as sp

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
    # a degenerate hexahedron lists some corners twice
    corners = [dict.fromkeys(map(int, e[10:18])) for e in archive.elem if len(e) >= 18]
    elements = [[node for node in nodes if node] for nodes in corners]

    def nodes_of(name: str) -> Any:
        return listed(components, name, f"{mesh}: there is no node component")

    grid = Mesh(number, place, nodes_of, elements)
    K, M = full_matrices(path)
    others = {speed: full_matrices(name)[0] for speed, name in (stiffness or {}).items()}
    return arrays_of(grid, lists, {0.0: K} | others, M, full_matrices(blade)[0] if blade else None)


def full_matrices(path: File) -> tuple[Rows, Rows]:
    """Stiffness and mass of a `.full` file, which has no held rows. Raises InputError."""
    from ansys.mapdl.reader import read_binary

    dof, K, M = _quietly(path, lambda: read_binary(str(path)).load_km(as_sparse=True, sort=True))
    rows = np.column_stack([dof[:, 0], dof[:, 1] + 1]).astype(np.int64)
    return Rows(_upper(K), rows, str(path)), Rows(_upper(M), rows, str(path))


def _upper(matrix: Any) -> Any:
    """Move all entries into the upper triangle: `sort` may have moved some below the diagonal."""
    upper, lower = sp.triu(matrix), sp.tril(matrix, -1)
    return sp.csr_array(upper + lower.T)


def _quietly(path: Any, work: Any) -> Any:
    """Call a reader, and keep its warnings off the screen."""
    with reading(path), contextlib.redirect_stdout(io.StringIO()):
        return work()
