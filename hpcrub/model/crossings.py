"""Speeds at which engine orders, and waves of a casing, meet natural frequencies of the blades.

An engine order n meets a natural frequency f where f(W) = n W, with the stiffness K(W). A pair of
casing modes with n waves moves the tips in n − kN waves of the disk, at the folded nodal diameter.
Seen from the rotor the pair has the frequencies ω_c ± nΩ, and meets a family of blade modes ω_b(Ω)
where nΩ = |ω_c ± ω_b|: at the sum blades and casing may make each other grow (*modal interaction*),
at the difference they only exchange energy. A wave travels around the casing at ω_c/n: contact
feeds the waves that the rotor overtakes (Iwan and Moeller 1976; Legrand et al. 2009).
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from scipy.linalg import eigh, eigvals

from hpcrub.model.casing_modes import CasingModes
from hpcrub.model.families import multiplicity
from hpcrub.model.reduction import ReducedModel, powers

N_FAMILIES = 2  # families of blade modes whose meetings with casing waves are listed
N_SEARCHED = 401  # speeds of the grid on which the first meeting is searched
MEETINGS = "sum", "difference"
SIGNS = 1.0, -1.0  # signs of ω_b in nΩ = |ω_c ± ω_b|
REAL = 1e-6  # largest imaginary part of a real root, relative to the root
SMALLEST = 1e-12  # root over the largest root, below which it is no speed but rounding


def speeds(stiffness: Sequence, mass: np.ndarray, order: int) -> np.ndarray:
    """Speeds of rotation at which an engine order is a natural frequency of a stiffened structure.

    They solve det(K0 + W^2 K1 + W^4 K2 - n^2 W^2 M) = 0, which is an eigenvalue problem in 1/W^2.

    stiffness: one to three matrices K0, K1, K2, each (k, k), K0 positive definite.
    mass: (k, k), positive definite; order: n, 1 or more.
    Returns (r,) increasing speeds [rad/s], the first for the lowest frequency; (0,) where rotation
    stiffens the structure faster than the order rises, so that they never meet.
    """
    zeros = [np.zeros_like(mass)] * (3 - len(stiffness))
    K0, K1, K2 = (list(stiffness) + zeros)[:3]
    squares, shapes = eigh(K0, mass)
    shapes = shapes / np.sqrt(squares)  # K0 becomes the identity
    size = len(mass)
    A, B = (shapes.conj().T @ matrix @ shapes for matrix in (order**2 * mass - K1, K2))
    scale = np.abs(squares).max()  # keeps the two unknowns of the companion matrix alike in size
    companion = np.block([[scale * A, -scale * B * scale], [np.eye(size), np.zeros((size, size))]])
    roots = eigvals(companion) / scale
    largest = np.abs(roots).max(initial=0.0)
    is_real = (np.abs(roots.imag) <= REAL * np.abs(roots)) & (roots.real > SMALLEST * largest)
    return np.sort(1.0 / np.sqrt(roots.real[is_real]))


def folded(order: int, n_blades: int) -> int:
    """Nodal diameters of the motion that an engine order excites on equal blades."""
    return min(order % n_blades, -order % n_blades)


def of_disk(reduced: ReducedModel, diameters: np.ndarray, order: int) -> float:
    """Speed [Hz] at which an engine order, 1 or more, meets the first family of a tuned disk.

    diameters: (m,) nodal diameters of the tuned modes. Returns NaN where they never meet. It does
    not depend on the speed of the reduced model.
    """
    mine = diameters == folded(order, reduced.interface.n_blades)
    met = speeds(_stiffness(reduced, mine), np.eye(mine.sum()), order)
    return float(met[0] / (2 * np.pi)) if len(met) else np.nan


def _stiffness(reduced: ReducedModel, mine: Any) -> list[Any]:
    """K0, and K1, K2 where stiffness depends on the speed, in some tuned modes (an index)."""
    slopes = [K[np.ix_(mine, mine)] for K in reduced.stiffening]
    faster = powers(reduced.speed, 0.0)
    at_rest = np.diag(reduced.tuned_eigenvalues[mine])
    return [at_rest - sum(K * p for K, p in zip(slopes, faster, strict=False)), *slopes]


def family_frequency(
    reduced: ReducedModel, diameters: np.ndarray, diameter: int, family: int
) -> Callable[[float], float] | None:
    """Angular frequency [rad/s] of a family of the tuned disk over the speed of rotation [rad/s].

    diameters: (m,) nodal diameters of the tuned modes; diameter, family (from 0): wanted modes.
    Returns None where the model lacks them; the frequency is NaN where no stiffness is left.
    """
    at_rest, *slopes = _stiffness(reduced, diameters == diameter)
    place = family * multiplicity(diameter, reduced.interface.n_blades)
    if place >= len(at_rest):
        return None

    def frequency(speed: float) -> float:
        stiffness = at_rest + sum(K * speed**p for K, p in zip(slopes, (2, 4), strict=False))
        squared = np.linalg.eigvalsh(stiffness)[place]
        return float(np.sqrt(squared)) if squared > 0.0 else np.nan

    return frequency


def interactions(
    reduced: ReducedModel, diameters: np.ndarray, casing: CasingModes, highest: float
) -> np.ndarray:
    """Speeds of rotation at which waves of the casing and families of blades meet.

    diameters: (m,) nodal diameters of the tuned modes; highest: end of the search [rad/s].
    Returns (J, N_FAMILIES, 2), the lowest speed with nΩ = ω_c + ω_b, and with nΩ = |ω_c − ω_b|, of
    every pair and family [rad/s]; NaN where they do not meet up to the highest speed.
    """
    from scipy.optimize import brentq  # a fifth of the program's start, for one kind of casing

    lowest = np.full((len(casing.omega), N_FAMILIES, len(SIGNS)), np.nan)
    for j, (n, omega) in enumerate(zip(casing.n_waves, casing.omega, strict=True)):
        for family in range(N_FAMILIES if n else 0):
            diameter = folded(int(n), reduced.interface.n_blades)
            blades = family_frequency(reduced, diameters, diameter, family)
            for k, sign in enumerate(SIGNS if blades else ()):
                pair, at = (n, omega, sign, blades), np.linspace(0.0, highest, N_SEARCHED)
                gaps = np.array([_apart(speed, *pair) for speed in at])
                meets = np.flatnonzero((gaps[:-1] < 0.0) & (gaps[1:] >= 0.0))
                if len(meets):
                    lowest[j, family, k] = brentq(_apart, *at[meets[0] : meets[0] + 2], args=pair)
    return lowest


def _apart(speed: float, n: int, omega: float, sign: float, blades: Any) -> float:
    """Frequency nΩ less that at which a pair of the casing meets a family of the blades."""
    return n * speed - abs(omega + sign * blades(speed))
