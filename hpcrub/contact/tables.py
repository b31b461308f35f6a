"""Tables that a bank is filled with: padded columns, Delassus operators and their bounds."""

import math

import numpy as np

from hpcrub.contact.lanes import PLACES, TILE, aligned


def columns(rows: np.ndarray) -> np.ndarray:
    """Rows (n, K) as columns of a table, padded with zeros to whole tiles (K, n_padded)."""
    return np.pad(rows.T, ((0, 0), (0, -len(rows) % TILE)))


def vectors(rows: np.ndarray) -> np.ndarray:
    """Rows (n, K) as vectors of `lanes.PLACES` for each mode, three by three, of an even K."""
    padded = np.pad(rows.T, ((0, rows.shape[1] % 2), (0, -len(rows) % (3 * len(PLACES)))))
    return padded.reshape(-1, len(PLACES))


def by_columns(table: np.ndarray) -> np.ndarray:
    """A copy whose columns lie in memory one after the other: of many, a few are read."""
    return aligned(table.T).T


def delassus(motion: np.ndarray, load: np.ndarray, gain: np.ndarray) -> np.ndarray:
    """Displacement of every contact point per unit force on every other in one step.

    motion: (K, C) displacement of the points per unit modal coordinate [1/√kg].
    load: (K, C) modal force of a unit force on each point [1/√kg].
    gain: (K,) factor of a modal force in the scheme [s²].
    Returns (C, C); [m/N].
    """
    return (motion * gain[:, None]).T @ load


def spread(table: np.ndarray, lane: int, values: np.ndarray) -> None:
    """Write values (..., n, n) to the lane's padded rows of a table (..., C·C, L) (modified)."""
    n_points = math.isqrt(table.shape[-2])
    n = values.shape[-1]
    rows = (np.arange(n)[:, None] * n_points + np.arange(n)[None, :]).ravel()
    table[..., rows, lane] = values.reshape(*values.shape[:-2], n * n)


def row_bound(coupling: np.ndarray) -> float:
    """How far in others push a point at most, over the deepest penetration.

    coupling: (n, n) W_ij/W_jj of zero diagonal [-].
    Returns ρ/(1 − ρ), ρ the largest row sum of |coupling|; infinite from ρ = 1 on [-].
    """
    rho = np.abs(coupling).sum(axis=1).max()
    return rho / (1.0 - rho) if rho < 1.0 else np.inf
