"""Supports that a program writes into the stiffness: a huge diagonal, 1e36 of Abaqus."""

from typing import Any

import numpy as np
import scipy.sparse as sp

HUGE = 1e12  # times the usual (median) diagonal, above which an entry is no stiffness of a part
ALONE = 1e-6  # of such a diagonal, below which the rest of its row says that it holds this row only


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
