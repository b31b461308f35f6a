"""Periodic motion of one point before an elastic stop, by harmonic balance with any series."""

import numpy as np
from scipy.optimize import fsolve

N_TIMES = 4096  # times of a period at which the stop's force is known


def largest(shape, omega, damping_ratio, load, stop, drive, guess):
    """Largest |u| of u = Σ shape_k q_k under a load cos(drive t) and a stop at one side [m].

    shape, omega: (K,) mass-normalised modes at the point, [rad/s]; stop: stiffness [N/m], gap [m];
    guess: (H + 1,) Fourier coefficients of a motion nearby, u = Re Σ c_n exp(i n drive t).
    """
    n, (stiffness, gap) = np.arange(len(guess)), stop
    wave = np.exp(2j * np.pi * np.outer(n, np.arange(N_TIMES) / N_TIMES))
    impedance = omega[:, None] ** 2 - (n * drive) ** 2
    impedance = impedance + 2j * damping_ratio * omega[:, None] * n * drive
    flexibility = (shape[:, None] ** 2 / impedance).sum(axis=0)

    def motion(parts):
        c = parts[: len(n)] + 1j * np.append(0.0, parts[len(n) :])
        return c, (c @ wave).real

    def unbalanced(parts):
        c, u = motion(parts)
        pushed = stiffness * np.maximum(u - gap, 0.0)
        force = load * (n == 1) - wave.conj() @ pushed * np.where(n, 2.0, 1.0) / N_TIMES
        off = (c - flexibility * force) / gap
        return np.append(off.real, off.imag[1:])

    start = np.append(guess.real, guess.imag[1:])
    parts, _, found, _ = fsolve(unbalanced, start, full_output=True, xtol=1e-12)
    return np.abs(motion(parts)[1]).max() if found == 1 else np.nan
