"""Reader of MatrixMarket files with CSV lists, as Abaqus, Code_Aster and scripts write them."""

from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from hpcrub.errors import InputError, reading
from hpcrub.model.imported.neutral import AT_SPEEDS, POLYNOMIAL
from hpcrub.model.imported.readers import harwell_boeing
from hpcrub.model.imported.readers.rows import places, store, whole
from hpcrub.model.imported.readers.text import content, existing, numbers, table

MATRICES = "K", "M", *POLYNOMIAL, *AT_SPEEDS, "K_blade"
ENDINGS = ".hb", ".mtx"  # the last one counts where both are there


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
    nodes = table(folder / "nodes.csv", 4)
    nodes = nodes[np.argsort(nodes[:, 0])]
    number = whole(nodes[:, 0], "nodes.csv")
    if len(twice := number[1:][np.diff(number) == 0]):
        raise InputError(f"nodes.csv: node {twice[0]} stands there twice")
    dof = whole(table(folder / "dof.csv", 2), "dof.csv")
    placed = dof[:, 1] > 0  # rows of direction 0 belong to no node
    place = places(np.where(placed, dof[:, 0], number[0]), number, "dof.csv")
    contact = _of_width(folder / "contact.csv", 3)
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
    for name, path in _matrices(folder).items():
        store(arrays, name, matrix(path, len(dof)))
    if n_sectors:
        arrays["n_sectors"] = np.array(n_sectors)
        for name in ("low", "high"):
            arrays[name] = places(numbers(folder / f"{name}.csv"), number, f"{name}.csv")
    if existing(folder / "fixed.csv").exists():
        held = whole(_of_width(folder / "fixed.csv", 2), "fixed.csv")
        places(held[:, 0], number, "fixed.csv")  # refuses unknown nodes
        arrays["fixed"] = _fixed(held, dof)
    if existing(folder / "speeds_hz.csv").exists():
        arrays["speeds_hz"] = numbers(folder / "speeds_hz.csv")
    return arrays


def _fixed(held: Any, dof: Any) -> Any:
    """Indices of held rows; held: (k, 1) nodes, or (k, 2) nodes and directions."""
    if held.shape[1] == 1:
        return np.flatnonzero(np.isin(dof[:, 0], held[:, 0]) & (dof[:, 1] > 0))
    return np.flatnonzero(np.isin(dof @ [1, 1j], held[:, :2] @ [1, 1j]))  # pairs, as one number


def _matrices(folder: Path) -> dict[str, Path]:
    """Files of the matrices in a folder. Raises InputError without a mass or a stiffness."""
    files = ((name, existing(folder / f"{name}{end}")) for name in MATRICES for end in ENDINGS)
    there = {name: path for name, path in files if path.exists()}
    for names in (("M",), ("K", POLYNOMIAL[0], AT_SPEEDS[0])):
        if not set(names) & set(there):
            wanted = " or ".join(f"{name}.mtx" for name in names)
            others = ", ".join(sorted(path.name for path in folder.iterdir()))
            raise InputError(
                f"{folder}: there is no {wanted}, a matrix of MatrixMarket (or .hb, of "
                f"Harwell-Boeing); there are {others}"
            )
    return there


def _of_width(path: Path, most: int) -> np.ndarray:
    values = table(path)
    if values.shape[1] > most:
        raise InputError(f"{path}: {values.shape[1]} numbers in a line, {most} at most expected")
    return values


def matrix(path: Path, n: int) -> sp.csr_array:
    """Read a real matrix (n, n) of MatrixMarket or Harwell-Boeing, with exponents of C or Fortran.

    It replaces SciPy's reader, which crashes on a truncated file. Raises InputError.
    """
    with reading(path):
        text = content(path).upper()
        if harwell_boeing.is_one(text):
            return _square(harwell_boeing.matrix(text), n)
        head, *lines = text.splitlines()
        if not head.startswith("%%MATRIXMARKET"):
            raise InputError(f"{path}: {_other_form(head)}")
        size, *lines = (line for line in lines if line.strip() and not line.startswith("%"))
        kind, field, symmetry = head.split()[2:]
        symmetric = symmetry == "SYMMETRIC"
        if field not in ("REAL", "INTEGER") or not (symmetric or symmetry == "GENERAL"):
            raise ValueError(f"{field} {symmetry} is no real matrix".lower())
        sparse, n_dense = kind == "COORDINATE", n * (n + 1) // 2 if symmetric else n**2
        wanted = (n, n, len(lines)) if sparse else (n, n)
        if tuple(map(int, size.split())) != wanted or not (sparse or len(lines) == n_dense):
            raise ValueError(f"{size} in its head, but {n} rows of dof.csv and {len(lines)} lines")
        if not text.endswith("\n"):
            _require_end(lines)
        values = np.loadtxt([line.replace("D", "E") for line in lines], ndmin=2)
        if sparse:
            i, j = whole(values[:, :2], str(path)).T - 1
        else:  # column after column
            j, i = np.triu_indices(n) if symmetric else np.divmod(np.arange(n**2), n)
        stored = sp.coo_array((values[:, -1], (i, j)), shape=(n, n)).tocsr()
        return stored + sp.triu(stored.T, 1) if symmetric else stored


def _square(found: sp.csr_array, n: int) -> sp.csr_array:
    if found.shape != (n, n):
        raise ValueError(f"{found.shape[0]} x {found.shape[1]}, but {n} rows of dof.csv")
    return found


def _require_end(lines: list[str]) -> None:
    """Refuse a last line that may have been cut off: its number is shorter than another one."""
    lengths = [len(line.split()[-1].lstrip("-+")) for line in lines]
    if lengths and lengths[-1] < max(lengths):
        raise ValueError(
            "it ends in the middle of a line; was it cut off? If not, add a line break at its end"
        )


def _other_form(head: str) -> str:
    """What to do with a matrix in another form than MatrixMarket's, by its first line."""
    if len(head.split(",")) == 5:
        return (
            'lines of node, direction, node, direction, value are those of Abaqus, which "hpcrub '
            'import abaqus" reads beside the deck of the job'
        )
    return "it begins neither with %%MatrixMarket nor with the four lines of Harwell-Boeing"
