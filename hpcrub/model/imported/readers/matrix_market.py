"""Reader of MatrixMarket files with CSV lists, as Abaqus, Code_Aster and scripts write them."""

import io
import re
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.io import hb_read, mminfo, mmread

from hpcrub.errors import InputError, reading
from hpcrub.model.imported.arrays import stored
from hpcrub.model.imported.neutral import AT_SPEEDS, POLYNOMIAL
from hpcrub.model.imported.readers.rows import places, whole
from hpcrub.model.imported.readers.text import content, existing, numbers, table

MATRICES = "K", "M", *POLYNOMIAL, *AT_SPEEDS, "K_blade"
ENDINGS = ".hb", ".mtx"  # the last one counts where both are there
BANNER = "%%MatrixMarket"
HARWELL_BOEING = re.compile(r"[RCP][SUHZR][AE]\s")  # the third line of a file begins so


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
    nodes = table(folder / "nodes.csv", width=4)[1]
    nodes = nodes[np.argsort(nodes[:, 0])]
    number = whole(nodes[:, 0], "nodes.csv")
    if len(twice := number[1:][np.diff(number) == 0]):
        raise InputError(f"nodes.csv: node {twice[0]} stands there twice")
    dof = whole(table(folder / "dof.csv", width=2)[1], "dof.csv")
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
        arrays |= stored(name, matrix(path, len(dof)))
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
    values = table(path)[1]
    if values.shape[1] > most:
        raise InputError(f"{path}: {values.shape[1]} numbers in a line, {most} at most expected")
    return values


def matrix(path: Path, n: int) -> sp.csr_array:
    """Read a real matrix (n, n) of MatrixMarket or Harwell-Boeing, with exponents of C or Fortran.

    Raises InputError.
    """
    with reading(path):
        head, *lines = content(path).splitlines(keepends=True)
        body = "".join(lines).upper().replace("D", "E")
        if head.upper().startswith(BANNER.upper()):
            found = _matrix_market(head, body)
        elif HARWELL_BOEING.match(lines[1] if len(lines) > 1 else ""):
            found = _harwell_boeing(head, body)
        else:
            raise InputError(f"{path}: {_other_form(head)}")
        if found.shape != (n, n):
            raise ValueError(f"{found.shape[0]} x {found.shape[1]}, but {n} rows of dof.csv")
        return found


def _matrix_market(head: str, body: str) -> sp.csr_array:
    text = f"{BANNER}{head[len(BANNER) :].lower()}{body}".encode()
    _, _, n_entries, _, field, symmetry = mminfo(io.BytesIO(text))
    if field not in ("real", "integer") or symmetry not in ("general", "symmetric"):
        raise ValueError(f"{field} {symmetry} is no real matrix")
    lines = body.splitlines()
    if n_entries > 2 * len(lines):  # what would fill the memory; SciPy refuses other differences
        raise ValueError(f"{n_entries} entries in its head, but {len(lines)} lines")
    if not body.endswith("\n"):
        _require_end(lines)
    return sp.csr_array(mmread(io.BytesIO(text)))


def _harwell_boeing(head: str, body: str) -> sp.csr_array:
    """Matrix of a file, completed if it is symmetric; SciPy reads neither these nor right sides."""
    counts, kind, formats, *lines = body.splitlines()
    if kind[:3] not in ("RSA", "RUA"):
        raise ValueError(f"{kind[:3]} is no real, assembled matrix (RSA, RUA)")
    if "".join(counts.split()[4:]).strip("0"):
        lines = lines[1:]  # what tells of right sides
    formats = " ".join(formats.replace("1P,", "").split()[:3])
    plain = "\n".join([head.strip(), counts[:56], f"RUA{kind[3:]}", formats, *lines, ""])
    found = sp.csr_array(hb_read(io.StringIO(plain)))
    return found + found.T - sp.diags_array(found.diagonal()) if kind[1] == "S" else found


def _require_end(lines: list[str]) -> None:
    """Refuse a last line that may have been cut off: its number is shorter than another one."""
    lengths = [len(line.split()[-1].lstrip("-+")) for line in lines if line.split()]
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
