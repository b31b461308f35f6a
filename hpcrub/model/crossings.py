"""Speeds at which an engine order meets natural frequencies: f(W) = n W with the stiffness K(W)."""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import eigh, eigvals

from hpcrub.model.reduction import ReducedModel

REAL = 1e-6  # largest imaginary part of a real root, relative to the root
SMALLEST = 1e-12  # root over the largest one: smaller ones are those of no speed


def speeds(stiffness: Sequence, mass: np.ndarray, order: int) -> np.ndarray:
    """Speeds of rotation at which an engine order is a natural frequency of a stiffened structure.

    They solve det(K0 + W^2 K1 + W^4 K2 - n^2 W^2 M) = 0, which is an eigenvalue problem in 1/W^2.

    stiffness: one to three matrices K0, K1, K2, each (k, k), K0 positive definite.
    mass: (k, k), positive definite; order: n, 1 or more.
    Returns (r,) increasing [rad/s]; the first is that of the lowest frequency; none where the order
    never meets one, as rotation stiffens the structure faster than the order rises.
    """
    zeros = [np.zeros_like(mass)] * (3 - len(stiffness))
    K0, K1, K2 = (list(stiffness) + zeros)[:3]
    squares, shapes = eigh(K0, mass)
    shapes = shapes / np.sqrt(squares)  # K0 becomes the identity
    size = len(mass)
    A, B = (shapes.conj().T @ matrix @ shapes for matrix in (order**2 * mass - K1, K2))
    scale = np.abs(squares).max()  # keeps both unknowns of the companion matrix of like size
    companion = np.block([[scale * A, -scale * B * scale], [np.eye(size), np.zeros((size, size))]])
    roots = eigvals(companion) / scale
    largest = np.abs(roots).max(initial=0.0)
    is_real = (np.abs(roots.imag) <= REAL * np.abs(roots)) & (roots.real > SMALLEST * largest)
    return np.sort(1.0 / np.sqrt(roots.real[is_real]))


def folded(order: int, n_blades: int) -> int:
    """Nodal diameters of the motion that an engine order excites on like blades."""
    return min(order % n_blades, -order % n_blades)


def of_disk(reduced: ReducedModel, diameters: np.ndarray, order: int) -> float:
    """Speed at which an engine order meets the first family of a tuned disk.

    diameters: (m,) nodal diameters of the tuned modes; order: 1 or more.
    Returns the speed of rotation [Hz]; NaN where the order never meets the family.
    """
    mine = diameters == folded(order, reduced.interface.n_blades)
    shapes, powers = reduced.tuned_modes[:, mine], reduced.speed ** np.array([2, 4])
    slopes = [shapes.T @ K @ shapes for K in reduced.stiffening]
    at_rest = np.diag(reduced.tuned_eigenvalues[mine])
    at_rest = at_rest - sum(K * p for K, p in zip(slopes, powers, strict=False))
    found = speeds([at_rest, *slopes], np.eye(len(at_rest)), order)
    return float(found[0] / (2 * np.pi)) if len(found) else np.nan
