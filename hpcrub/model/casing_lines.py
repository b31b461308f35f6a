"""Where the waves of a casing and the vibration of blades excite each other, without contact yet.

Tips that see the n waves of a casing pair move in n − kN waves of the disk, those of the folded
nodal diameter. Seen from the rotor the pair has the frequencies ω_c ± nΩ, and meets a family of
blade modes ω_b(Ω) where nΩ = |ω_c ± ω_b|: at the sum both may grow by each other (*modal
interaction*), at the difference they only exchange energy. A wave travels around the casing at
ω_c/n: contact feeds those that the rotor overtakes (Iwan and Moeller 1976; Legrand et al. 2009).
"""

from collections.abc import Callable

import numpy as np

from hpcrub.model.casing_modes import CasingModes
from hpcrub.model.crossings import folded
from hpcrub.model.reduction import ReducedModel

N_FAMILIES = 2  # of blade modes whose interactions are listed
N_SEARCHED = 401  # speeds between which the first meeting is looked for
KINDS = "sum", "difference"
SIGNS = 1.0, -1.0  # of ω_b in nΩ = |ω_c ± ω_b|


def family_frequency(
    reduced: ReducedModel, diameters: np.ndarray, diameter: int, family: int
) -> Callable[[float], float] | None:
    """Angular frequency [rad/s] of a family of the tuned disk over the speed of rotation [rad/s].

    diameters: (m,) nodal diameters of the tuned modes; diameter: of these modes; family: from 0.
    Returns None where the model has no such modes; NaN where rotation has taken all stiffness.
    """
    mine = diameters == diameter
    shapes, powers = reduced.tuned_modes[:, mine], reduced.speed ** np.array([2, 4])
    slopes = [shapes.T @ K @ shapes for K in reduced.stiffening]
    at_rest = np.diag(reduced.tuned_eigenvalues[mine])
    at_rest = at_rest - sum(K * p for K, p in zip(slopes, powers, strict=False))
    alone = 2 * diameter % reduced.interface.n_blades == 0  # other diameters come in two
    place = family if alone else 2 * family
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

    diameters: (m,) nodal diameters of the tuned modes; highest: speed looked at [rad/s].
    Returns (J, N_FAMILIES, 2), nΩ = ω_c + ω_b and nΩ = |ω_c − ω_b| of every pair and family
    [rad/s], the lowest of each; NaN where they do not meet up to the highest speed.
    """
    from scipy.optimize import brentq  # a fifth of the program's start, for one kind of casing

    found = np.full((len(casing.omega), N_FAMILIES, len(SIGNS)), np.nan)
    for j, (n, omega) in enumerate(zip(casing.n_waves, casing.omega, strict=True)):
        for family in range(N_FAMILIES if n else 0):
            diameter = folded(int(n), reduced.interface.n_blades)
            blades = family_frequency(reduced, diameters, diameter, family)
            for k, sign in enumerate(SIGNS if blades else ()):

                def off(speed, n=n, omega=omega, blades=blades, sign=sign):
                    return n * speed - abs(omega + sign * blades(speed))

                at = np.linspace(0.0, highest, N_SEARCHED)
                gaps = np.array([off(speed) for speed in at])
                meets = np.flatnonzero((gaps[:-1] < 0.0) & (gaps[1:] >= 0.0))
                if len(meets):
                    found[j, family, k] = brentq(off, at[meets[0]], at[meets[0] + 1])
    return found
