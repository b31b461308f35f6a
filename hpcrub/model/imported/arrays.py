"""Access to the arrays of a model file, with checks of their types and shapes.

Programs may write supports into a stiffness: a huge diagonal, 1e36 of Abaqus.
"""

from typing import Any

import numpy as np
import scipy.sparse as sp

from hpcrub.errors import InputError

PARTS = "data", "indices", "indptr"  # arrays of a sparse matrix in compressed rows (CSR)
SYMMETRY = 1e-8  # largest allowed difference from the transpose, as a share of its rows' entries
HUGE = 1e12  # times the usual (median) diagonal, above which an entry is no stiffness of a part
ALONE = 1e-6  # of such a diagonal, below which the rest of its row says that it holds this row only


def finite(name: str, matrix: Any) -> Any:
    """Return the matrix, dense or sparse. Raises InputError when a number is not finite."""
    if not np.isfinite(matrix.data if sp.issparse(matrix) else matrix).all():
        raise InputError(f"{name}: holds numbers that are not finite")
    return matrix


def symmetric(name: str, matrix: Any) -> Any:
    """Complete a symmetric matrix that is given whole or as a triangle. Raises InputError."""
    sparse = sp.issparse(matrix)
    lower, upper = (sp.tril, sp.triu) if sparse else (np.tril, np.triu)
    finite(name, matrix)
    strict = [abs(lower(matrix, -1)).max(), abs(upper(matrix, 1)).max()]
    if min(strict) == 0.0 < max(strict):
        diagonal = matrix.diagonal()
        return matrix + matrix.T - (sp.diags_array(diagonal) if sparse else np.diag(diagonal))
    worst = _asymmetry(matrix)
    if worst > SYMMETRY:
        raise InputError(
            f"{name}: not symmetric, it differs from its transpose by {worst:.1e} of the largest "
            "entries of its rows"
        )
    return (matrix + matrix.T) / 2


def _asymmetry(matrix: Any) -> float:
    """Largest difference from the transpose, as a share of the rows' largest entries.

    Not of the matrix's: a row that is held by 1e36 would hide all others. Rows below the median
    count as it: they may be what rounding leaves of a difference.
    """
    size = abs(matrix).max(axis=1)
    size = np.asarray(size.toarray() if sp.issparse(size) else size).ravel()
    if not size.any():
        return 0.0
    root = np.sqrt(np.maximum(size, np.median(size[size > 0.0])))
    difference = sp.coo_array(abs(matrix - matrix.T))
    return float((difference.data / (root[difference.row] * root[difference.col])).max(initial=0.0))


def stored(name: str, matrix: Any) -> dict:
    """Return the arrays that store a matrix: itself, or the three parts of a sparse matrix."""
    if not sp.issparse(matrix):
        return {name: matrix}
    rows = sp.csr_array(matrix)
    rows.sum_duplicates()
    return {f"{name}/{part}": getattr(rows, part) for part in PARTS}


def held_rows(stiffness: Any) -> np.ndarray:
    """Rows of a sparse stiffness (n, n) that a huge entry on the diagonal holds, (any,) int."""
    diagonal = np.abs(stiffness.diagonal())
    if not diagonal.any():
        return np.zeros(0, dtype=np.int64)
    rows = np.flatnonzero(diagonal > HUGE * np.median(diagonal[diagonal > 0.0]))
    part = abs(sp.csr_array(stiffness)[rows])
    part[np.arange(len(rows)), rows] = 0.0
    return rows[part.max(axis=1).toarray().ravel() < ALONE * diagonal[rows]]


def without(stiffness: Any, rows: np.ndarray) -> Any:
    """Stiffness (n, n) with zeros on the diagonal of these rows (any,)."""
    removed = np.zeros(stiffness.shape[0])
    removed[rows] = stiffness.diagonal()[rows]
    return sp.csr_array(stiffness - sp.diags_array(removed))


class Arrays:
    """The arrays of a file; each method removes one and raises InputError if it is wrong."""

    def __init__(self, arrays: Any) -> None:
        self.left = dict(arrays)

    def has(self, name: str) -> bool:
        """Whether there is an array or a sparse matrix of this name."""
        return name in self.left or f"{name}/{PARTS[0]}" in self.left

    def finish(self) -> None:
        """Raise InputError when unknown arrays are left."""
        if self.left:
            raise InputError(f"{min(self.left)}: no array of a model file has this name")

    def _take(self, name: str, default: Any = None) -> Any:
        if name not in self.left and default is None:
            raise InputError(f"{name}: this array is missing")
        return np.asarray(self.left.pop(name, default))

    def word(self, name: str, allowed: tuple[str, ...] = (), default: str | None = None) -> str:
        """Take one word, of the allowed ones if any are given."""
        value = self._take(name, default)
        if value.size != 1:
            raise InputError(f"{name}: one word is expected")
        text = str(value.item())
        if allowed and text not in allowed:
            raise InputError(f'{name}: "{text}" is none of {", ".join(allowed)}')
        return text

    def number(self, name: str, default: int | None = None) -> int:
        """Take one whole number."""
        value = self._take(name, default)
        if value.size != 1 or value.dtype.kind not in "iu":
            raise InputError(f"{name}: one whole number is expected")
        return int(value.item())

    def _checked(self, name: str, value: Any, kinds: Any, what: Any, shape: Any) -> Any:
        """Return the values if their kind and shape are right; None stands for any length."""
        fits = value.ndim == len(shape) and all(
            wanted in (None, length) for wanted, length in zip(shape, value.shape, strict=True)
        )
        if not fits or value.dtype.kind not in kinds:
            lengths = " x ".join("any" if n is None else str(n) for n in shape)
            given = f"shape {value.shape}, {value.dtype}"
            raise InputError(f"{name}: {given}; {what}, {lengths}, are expected")
        return value

    def integers(self, name: str, *shape: int, default: np.ndarray | None = None) -> np.ndarray:
        """Take whole numbers of the shape (any, *shape)."""
        value = self._take(name, default)
        return self._checked(name, value, "iu", "whole numbers", (None, *shape)).astype(np.int64)

    def floats(self, name: str, *shape: int | None, default: Any = None) -> np.ndarray:
        """Take numbers of the shape (any, *shape)."""
        value = self._take(name, default)
        value = self._checked(name, value, "fiu", "numbers", (None, *shape)).astype(float)
        finite(name, value[~np.isnan(value)] if name == "nodes" else value)  # NaN: without a place
        return value

    def matrix(self, name: str, n_rows: int, n: int) -> Any:
        """Take a dense or sparse matrix (n_rows, n); n is the number of rows of dof."""
        return finite(name, self._matrix(name, n_rows, n))

    def _matrix(self, name: str, n_rows: int, n: Any) -> Any:
        if f"{name}/{PARTS[0]}" in self.left:
            parts = tuple(self._take(f"{name}/{part}") for part in PARTS)
            try:
                matrix = sp.csr_array(parts, shape=(n_rows, n))
                matrix.check_format(full_check=True)
            except ValueError as error:
                text = f"{name}: not {n_rows} x {n} in compressed rows ({error})"
                raise InputError(text) from None
        else:
            matrix = self._take(name)
        what = f"real numbers for the {n} rows of dof"
        return self._checked(name, matrix, "fiu", what, (n_rows, n)).astype(float)

    def symmetric(self, name: str, n: int) -> Any:
        """Take a symmetric matrix (n, n) that is given whole or as a triangle."""
        return symmetric(name, self._matrix(name, n, n))
