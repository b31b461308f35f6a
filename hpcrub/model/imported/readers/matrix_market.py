"""Reader of MatrixMarket files with CSV lists, as Abaqus, Code_Aster and scripts write them."""

from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from hpcrub.errors import InputError, reading
from hpcrub.model.imported.neutral import AT_SPEEDS, POLYNOMIAL
from hpcrub.model.imported.readers.rows import places, store, whole

MATRICES = "K", "M", *POLYNOMIAL, *AT_SPEEDS, "K_blade"


def read(folder: str | Path, n_sectors: int = 0) -> dict:
    """Read the arrays of a model file from a folder.

    folder: with NAME.mtx of M and K (or K0, K1, K2, or K_at_1 to K_at_3 and speeds_hz.csv), and
        optionally K_blade.mtx; nodes.csv (number, x, y, z), dof.csv (node number, direction of
        every row), contact.csv (node number[, blade from 0[, clearance]]); for a sector low.csv,
        high.csv (node numbers of the sides); optionally fixed.csv (node number[, direction]).
    n_sectors: number of sectors, 0 for a whole disk.
    Raises InputError: a file is missing or cannot be read.
    """
    folder = Path(folder)
    nodes = _table(folder / "nodes.csv", 4)
    nodes = nodes[np.argsort(nodes[:, 0])]
    number = whole(nodes[:, 0], "nodes.csv")
    if len(twice := number[1:][np.diff(number) == 0]):
        raise InputError(f"nodes.csv: node {twice[0]} stands there twice")
    dof = whole(_table(folder / "dof.csv", 2), "dof.csv")
    placed = dof[:, 1] > 0  # rows of direction 0 belong to no node
    place = places(np.where(placed, dof[:, 0], number[0]), number, "dof.csv")
    contact = _table(folder / "contact.csv")
    arrays = {
        "hpcrub_model": np.array(1),
        "kind": np.array("sector" if n_sectors else "disk"),
        "nodes": nodes[:, 1:],
        "dof": np.column_stack([np.where(placed, place, -1), dof[:, 1]]),
        "contact_node": places(contact[:, 0], number, "contact.csv"),
    }
    if contact.shape[1] > 1:
        arrays["contact_blade"] = whole(contact[:, 1], "contact.csv")
    if contact.shape[1] > 2:
        arrays["contact_clearance"] = contact[:, 2]
    for name in MATRICES:
        if (path := folder / f"{name}.mtx").exists() or name == "M":
            store(arrays, name, matrix(path, len(dof)))
    if n_sectors:
        arrays["n_sectors"] = np.array(n_sectors)
        for name in ("low", "high"):
            arrays[name] = places(_table(folder / f"{name}.csv")[:, 0], number, f"{name}.csv")
    if (folder / "fixed.csv").exists():
        arrays["fixed"] = _fixed(whole(_table(folder / "fixed.csv"), "fixed.csv"), dof)
    if (folder / "speeds_hz.csv").exists():
        arrays["speeds_hz"] = _table(folder / "speeds_hz.csv").ravel()
    return arrays


def _fixed(held: Any, dof: Any) -> Any:
    """Indices of held rows; held: (k, 1) nodes, or (k, 2) nodes and directions."""
    if held.shape[1] == 1:
        return np.flatnonzero(np.isin(dof[:, 0], held[:, 0]) & (dof[:, 1] > 0))
    return np.flatnonzero(np.isin(dof @ [1, 1j], held[:, :2] @ [1, 1j]))  # pairs, as one number


def matrix(path: Path, n: int) -> sp.csr_array:
    """Read a real matrix (n, n) from a MatrixMarket file, with exponents of C or Fortran (D).

    It replaces SciPy's reader, which crashes on a truncated file. Raises InputError.
    """
    with reading(path):
        text = path.read_text("ascii").upper()
        if not text.endswith("\n"):
            raise ValueError("it ends in the middle of a line; was it cut off?")
        head, *lines = text.splitlines()
        size, *lines = (line for line in lines if line.strip() and not line.startswith("%"))
        kind, field, symmetry = head.split()[2:]
        symmetric = symmetry == "SYMMETRIC"
        if field not in ("REAL", "INTEGER") or not (symmetric or symmetry == "GENERAL"):
            raise ValueError(f"{field} {symmetry} is no real matrix".lower())
        sparse, n_dense = kind == "COORDINATE", n * (n + 1) // 2 if symmetric else n**2
        wanted = (n, n, len(lines)) if sparse else (n, n)
        if tuple(map(int, size.split())) != wanted or not (sparse or len(lines) == n_dense):
            raise ValueError(f"{size} in its head, but {n} rows of dof.csv and {len(lines)} lines")
        values = np.loadtxt([line.replace("D", "E") for line in lines], ndmin=2)
        if sparse:
            i, j = whole(values[:, :2], str(path)).T - 1
        else:  # column after column
            j, i = np.triu_indices(n) if symmetric else np.divmod(np.arange(n**2), n)
        stored = sp.coo_array((values[:, -1], (i, j)), shape=(n, n)).tocsr()
        return stored + sp.triu(stored.T, 1) if symmetric else stored


def _table(path: Any, columns: Any = 0) -> Any:
    """Numbers of a CSV file (lines, columns); a first line of names is skipped."""
    with reading(path):
        lines = path.read_text("utf-8-sig").splitlines()
        has_names = bool(lines) and lines[0].lstrip()[:1].isalpha()
        table = np.loadtxt(lines[has_names:], delimiter=",", ndmin=2)
    if not len(table) or (columns and table.shape[1] != columns):
        raise InputError(f"{path}: {columns or 'some'} numbers per line are expected")
    return table
