"""Statistics of pairs of numbers: rank correlation, density.

`scipy.stats` has both, but its import would take a second of every study with figures.
"""

from typing import Any

import numpy as np

from hpcrub.statistics.percentiles import Z_95

N_GRID = 80  # points of a density along each axis


def rank_correlation(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Spearman's correlation of n pairs, with both ends of its 95 % interval (3,) [-].

    NaN for fewer than four pairs. Source: Bonett and Wright (2000).
    """
    n = len(x)
    if n < 4:
        return np.full(3, np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):  # values that are all alike: NaN
        r = np.corrcoef(_ranks(x), _ranks(y))[0, 1]
    half = Z_95 * np.sqrt((1 + r * r / 2) / (n - 3))
    at = np.arctanh(np.clip(r, -1 + 1e-12, 1 - 1e-12))
    return np.array([r, np.tanh(at - half), np.tanh(at + half)])


def density(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Density of pairs, estimated with a Gaussian kernel of Scott's width.

    Returns grids of x and y (G,), which reach three standard deviations of the kernel beyond the
    samples, and the density (G, G), whose maximum is 1; None if the pairs lie on a line.
    """
    grid_x, grid_y = map(_grid, (x, y))
    pairs = np.vstack([x, y])
    covariance = np.cov(pairs)
    if np.linalg.matrix_rank(covariance) < 2:
        return grid_x, grid_y, None
    mesh = np.array(np.meshgrid(grid_x, grid_y, indexing="ij")).reshape(2, -1)
    kernel = np.linalg.cholesky(covariance) * len(x) ** (-1 / 6)
    mesh, pairs = np.linalg.solve(kernel, mesh), np.linalg.solve(kernel, pairs)
    values = sum(np.exp(-((mesh - pair[:, None]) ** 2).sum(axis=0) / 2.0) for pair in pairs.T)
    return grid_x, grid_y, values.reshape(N_GRID, N_GRID) / values.max()


def _ranks(values: np.ndarray) -> np.ndarray:
    """Rank of each value (n,); values that are equal share the mean of their ranks."""
    _, place, count = np.unique(values, return_inverse=True, return_counts=True)
    return (np.cumsum(count) - (count - 1) / 2.0)[place]


def _grid(values: Any) -> Any:
    margin = 3.0 * values.std() * len(values) ** (-1 / 6) + 1e-6
    return np.linspace(values.min() - margin, values.max() + margin, N_GRID)
