"""The rigid casing: bumps over the circumference and their ramp at the start of a run."""

import math

import numpy as np


def bump_height(phi, n_bumps, height):
    """Height of the casing's bumps at an angle.

    Args:
        phi: angle from any bump [rad], any shape.
        n_bumps: number n_d of evenly spaced bumps.
        height: bump height c_rd [m].

    Returns:
        Height above the undeformed casing [m], same shape as ``phi``.

    Source: Joachim, Nyssen, Batailly (2020), equation (1), inward counted positive.
    """
    pitch = 2.0 * np.pi / n_bumps
    nearest = phi - pitch * np.round(phi / pitch)
    return height * np.exp(-((nearest / (0.1 * pitch)) ** 2))


def bump_table(contact_angle, n_bumps, height, steps_per_revolution, n_steps):
    """Bump heights that every contact point meets in the first steps of a revolution.

    Args:
        contact_angle: angles of the contact points in the rotating frame (n_c,) [rad].
        n_bumps: number of bumps.
        height: bump height [m].
        steps_per_revolution: time steps in which the disk turns once.
        n_steps: rows of the table.

    Returns:
        Heights (n_steps, n_c) [m]; row j holds the heights after j + 1 steps.
    """
    rotation = (np.arange(n_steps) + 1.0) * (2.0 * np.pi / steps_per_revolution)
    return bump_height(rotation[:, None] + contact_angle[None, :], n_bumps, height)


def ramp(t, ramp_time):
    """Bump ramp s(t), the factor of the bump height: 0 until t = 0, 1 from ``ramp_time`` [s] on."""
    if t <= 0.0:
        return 0.0
    if t >= ramp_time:
        return 1.0
    return (1.0 - math.exp(-5.0 * t / ramp_time)) / (1.0 - math.exp(-5.0))
