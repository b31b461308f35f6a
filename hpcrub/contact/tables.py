"""Tables for the arrays of a bank: padded columns, Delassus operators and their bounds."""

import math

import numpy as np

from hpcrub.contact.lanes import PLACES, TILE


def columns(rows: np.ndarray) -> np.ndarray:
    """Table (K, n_padded) with rows (n, K) as columns, padded with zeros to whole tiles."""
    return np.ascontiguousarray(np.pad(rows.T, ((0, 0), (0, -len(rows) % TILE))))


def vectors(rows: np.ndarray) -> np.ndarray:
    """Rows (n, K) as vectors (…, 8), a multiple of three for each mode; K is padded to even."""
    padded = np.pad(rows.T, ((0, rows.shape[1] % 2), (0, -len(rows) % (3 * len(PLACES)))))
    return padded.reshape(-1, len(PLACES))


def delassus(motion: np.ndarray, load: np.ndarray, gain: np.ndarray) -> np.ndarray:
    """Delassus operator (C, C) [m/N]: motion of each point in a step per unit force on each.

    motion: (K, C) displacement of the points per unit modal coordinate [1/√kg].
    load: (K, C) modal force of a unit force on each point [1/√kg].
    gain: (K,) factor of a modal force in the scheme [s²].
    """
    return (motion * gain[:, None]).T @ load


def spread(table: np.ndarray, lane: int, values: np.ndarray) -> None:
    """Write matrices (..., n, n) to a lane of a padded table (..., C·C, L) (modified)."""
    n_points = math.isqrt(table.shape[-2])
    n = values.shape[-1]
    rows = (np.arange(n)[:, None] * n_points + np.arange(n)[None, :]).ravel()
    table[..., rows, lane] = values.reshape(*values.shape[:-2], n * n)


def row_bound(coupling: np.ndarray) -> float:
    """Bound on the depth that other forces push a point in, over the deepest penetration.

    coupling: (n, n) W_ij/W_jj with zero diagonal [-].
    Returns ρ/(1 − ρ), ρ the largest row sum of |coupling|; infinite from ρ = 1 on [-].
    """
    rho = np.abs(coupling).sum(axis=1).max()
    return rho / (1.0 - rho) if rho < 1.0 else np.inf
