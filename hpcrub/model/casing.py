"""The rigid casing: bumps over the circumference and their ramp at the start of a run."""

import math

import numpy as np


def bump_height(phi: np.ndarray, n_bumps: int, height: float) -> np.ndarray:
    """Height of the casing's bumps at an angle.

    Parameters
    ----------
    phi : ndarray
        Angle from any bump [rad], of any shape.
    n_bumps : int
        Number n_d of evenly spaced bumps.
    height : float
        Bump height c_rd [m].

    Returns
    -------
    ndarray
        Height above the undeformed casing [m], same shape as ``phi``.

    Notes
    -----
    Joachim, Nyssen, Batailly (2020), equation (1), inward counted positive.
    """
    pitch = 2.0 * np.pi / n_bumps
    nearest = phi - pitch * np.round(phi / pitch)
    return height * np.exp(-((nearest / (0.1 * pitch)) ** 2))


def bump_table(
    contact_angle: np.ndarray, n_bumps: int, height: float, steps_per_revolution: int, n_steps: int
) -> np.ndarray:
    """Bump heights that every contact point meets in the first steps of a revolution.

    Parameters
    ----------
    contact_angle : ndarray (C,)
        Angles of the contact points in the rotating frame [rad].
    n_bumps : int
        Number of bumps.
    height : float
        Bump height [m].
    steps_per_revolution : int
        Time steps in which the disk turns once.
    n_steps : int
        Rows of the table.

    Returns
    -------
    ndarray (n_steps, C)
        Heights [m]; row j holds the heights after j + 1 steps.
    """
    rotation = (np.arange(n_steps) + 1.0) * (2.0 * np.pi / steps_per_revolution)
    return bump_height(rotation[:, None] + contact_angle[None, :], n_bumps, height)


def ramp(t: float, ramp_time: float) -> float:
    """Bump ramp s(t), the factor of the bump height: 0 until t = 0, 1 from ``ramp_time`` [s] on."""
    if t <= 0.0:
        return 0.0
    if t >= ramp_time:
        return 1.0
    return (1.0 - math.exp(-5.0 * t / ramp_time)) / (1.0 - math.exp(-5.0))
