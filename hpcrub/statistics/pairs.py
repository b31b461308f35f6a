"""Statistics of pairs of numbers: rank correlation, density."""

from typing import Any

import numpy as np
from scipy.stats import gaussian_kde, norm, spearmanr

N_GRID = 80  # points of a density along each axis


def rank_correlation(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Spearman's correlation of n pairs, with both ends of its 95 % interval (3,) [-].

    NaN for fewer than four pairs. Source: Bonett and Wright (2000).
    """
    n = len(x)
    if n < 4:
        return np.full(3, np.nan)
    r = spearmanr(x, y).statistic
    half = norm.ppf(0.975) * np.sqrt((1 + r * r / 2) / (n - 3))
    at = np.arctanh(np.clip(r, -1 + 1e-12, 1 - 1e-12))
    return np.array([r, np.tanh(at - half), np.tanh(at + half)])


def density(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Density of pairs, estimated with a Gaussian kernel of Scott's width.

    Returns grids of x and y (G,), which reach three standard deviations of the kernel beyond the
    samples, and the density (G, G), whose maximum is 1; None if the pairs lie on a line.
    """
    grid_x, grid_y = map(_grid, (x, y))
    pairs = np.vstack([x, y])
    if np.linalg.matrix_rank(np.cov(pairs)) < 2:
        return grid_x, grid_y, None
    mesh = np.array(np.meshgrid(grid_x, grid_y, indexing="ij")).reshape(2, -1)
    values = gaussian_kde(pairs)(mesh).reshape(N_GRID, N_GRID)
    return grid_x, grid_y, values / values.max()


def _grid(values: Any) -> Any:
    margin = 3.0 * values.std() * len(values) ** (-1 / 6) + 1e-6
    return np.linspace(values.min() - margin, values.max() + margin, N_GRID)
