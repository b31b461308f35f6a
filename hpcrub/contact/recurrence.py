"""Recurrence coefficients of a time step: what each integration scheme makes of a mode."""

import numpy as np


def coefficients(
    scheme: str, omega: np.ndarray, damping_ratio: float, h: float
) -> tuple[np.ndarray, np.ndarray]:
    """Modal coefficients of a time step.

    Parameters
    ----------
    scheme : str
        ``central_difference`` or ``exact_modal``.
    omega : ndarray (K,)
        Angular eigenfrequencies [rad/s].
    damping_ratio : float
        Modal damping ratio ξ [-].
    h : float
        Time step [s].

    Returns
    -------
    keep : ndarray (K,)
        Factor of the last increment [-].
    push : ndarray (K,)
        Factor of a modal force [s²]: d ← keep·d − ω² push·q + push·(force).

    Notes
    -----
    Joachim, Nyssen, Batailly (2020), section 2.2.2; ``docs/theory.md`` for ``exact_modal``.
    """
    c = damping_ratio * omega * h
    if scheme == "central_difference":
        push = h * h / (1.0 + c)
        return (1.0 - c) / (1.0 + c), push
    theta = omega * h * np.emath.sqrt(1.0 - damping_ratio**2)
    keep = np.exp(-2.0 * c)
    # 1 − 2e^{−c}cos θ + e^{−2c} without the cancellation at small steps
    pull = np.real(np.expm1(-c) ** 2 + 4.0 * np.exp(-c) * np.sin(theta / 2.0) ** 2)
    rigid = omega * h < 1e-8
    push = np.where(rigid, h * h, pull / np.where(rigid, 1.0, omega) ** 2)
    return keep, push
