"""Damping ratios of modes: one number for all, or a list by mode, family or frequency."""

from typing import NamedTuple

import numpy as np


class Damping(NamedTuple):
    """Damping ratios that differ from mode to mode; all higher modes take the last ratio."""

    ratios: tuple[float, ...]  # [-]
    family: int = 1  # number of modes, by frequency, that share a ratio
    # upper ends of frequency bands [rad/s], increasing, one fewer than ratios; () for families
    bands: tuple[float, ...] = ()


def state_matrix(damping: np.ndarray, stiffness: np.ndarray, scale: float = 1.0) -> np.ndarray:
    """State matrix (2n, 2n) of x'' + D x' + S x = 0 in x and x'/scale; D and S are (n, n).

    scale: a frequency that balances the blocks [1/s]; the eigenvalues are divided by it.
    """
    zero, one = np.zeros_like(stiffness), np.eye(len(stiffness))
    return np.block([[zero, one], [-stiffness / scale**2, -damping / scale]])


def ratios_of(damping: float | Damping, omega: np.ndarray) -> np.ndarray:
    """Damping ratios (K,) of all modes of a disk, in any order; omega: theirs (K,) [rad/s]."""
    if not isinstance(damping, Damping):
        return np.full(len(omega), damping, dtype=float)
    place = np.argsort(np.argsort(omega, kind="stable"), kind="stable") // damping.family
    if damping.bands:
        place = np.searchsorted(damping.bands, omega)
    return np.array(damping.ratios)[np.minimum(place, len(damping.ratios) - 1)]
