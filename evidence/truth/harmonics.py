"""Periodic motion of one point before an elastic stop by harmonic balance; whether it stays."""

import numpy as np
from scipy.linalg import expm
from scipy.optimize import fsolve

N_TIMES = 4096  # times of a period at which the stop's force is known


def periodic(shape, omega, damping_ratio, load, stop, drive, guess):
    """Motion u = Σ shape_k q_k under a load cos(drive t) and a stop at one side.

    shape, omega: (K,) mass-normalised modes at the point, [rad/s]; stop: stiffness [N/m], gap [m];
    guess: (H + 1,) Fourier coefficients of a motion nearby, u = Re Σ c_n exp(i n drive t).
    Returns these coefficients of the motion, and u (N_TIMES,) [m]; NaN where none is found.
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
    return motion(parts if found == 1 else np.full_like(parts, np.nan))


def multipliers(shape, omega, damping_ratio, stop, drive, u):
    """Floquet multipliers (2K,) of a periodic motion u (N_TIMES,): it stays if all are below 1.

    A small change of the motion obeys the linear equations, with the stop's stiffness while u is
    beyond the gap. Other arguments as in `periodic`.
    """
    size, (stiffness, gap) = len(omega), stop
    touching = np.diag(omega**2) + stiffness * np.outer(shape, shape)
    damping = np.diag(2.0 * damping_ratio * omega)
    step = 2.0 * np.pi / drive / N_TIMES
    free, held = (
        expm(step * np.block([[np.zeros((size, size)), np.eye(size)], [-K, -damping]]))
        for K in (np.diag(omega**2), touching)
    )
    after_a_period = np.eye(2 * size)
    for is_beyond in u > gap:
        after_a_period = (held if is_beyond else free) @ after_a_period
    return np.linalg.eigvals(after_a_period)
