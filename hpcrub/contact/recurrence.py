"""Coefficients with which each integration scheme advances a mode by a time step.

All schemes are the same recurrence d ← decay·d − ω² gain·q + gain·f, q ← q + d, for the increment
d = q_n − q_{n−1} of a modal coordinate under the modal force f.
"""

from typing import Any

import numpy as np

LARGEST_PHASE = 2.0  # ωh up to which a mode is integrated exactly: about three steps per period
SOFT = 3.0  # stiffness times compliance in a step, about which a step begins to damp a rebound


def newmark(stiffness: Any) -> tuple[Any, Any, Any]:
    """Weights a, b, c of the contact forces at the ends of a step and of the two steps before.

    stiffness: stiffness of the surface times the compliance of a point in a step, any shape [-].
    A soft surface has 1/4, 1/2 and 1/4, the trapezoidal rule, and a hard one 1, 0 and 0. The
    weights follow Newmark's γ = 1/2 + δ, β = (1 + δ)²/4.
    """
    damped = (stiffness / (stiffness + SOFT)) ** 2
    return (1.0 + damped) ** 2 / 4.0, (1.0 - damped**2) / 2.0, (1.0 - damped) ** 2 / 4.0


def coefficients(
    scheme: str, omega: np.ndarray, damping_ratio: float | np.ndarray, h: float
) -> tuple[np.ndarray, np.ndarray]:
    """Modal coefficients of a time step.

    scheme: ``central_difference`` or ``exact_modal``.
    omega: (K,) angular eigenfrequencies [rad/s].
    damping_ratio: modal damping ratio ξ [-], one for all modes or one for each (K,).
    h: time step [s].
    Returns decay (K,), factor of the last increment [-]; gain (K,), factor of a modal force [s²].
    Source: Joachim, Nyssen, Batailly (2020), section 2.2.2, for central differences.
    ``exact_modal`` follows each mode without error between two steps, as long as ωh ≤ 2. A faster
    mode would be sampled too seldom: near ωh = 2πk its samples look like a slow mode that does not
    exist (aliasing). Such a mode takes the trapezoidal rule, whose phase per step never reaches π.
    ``docs/theory.md`` derives both.
    """
    if scheme == "central_difference":
        c = damping_ratio * omega * h
        gain = h * h / (1.0 + c)
        return (1.0 - c) / (1.0 + c), gain
    exact, stiff = _exact(omega, damping_ratio, h), _trapezoidal(omega, damping_ratio, h)
    slow = omega * h <= LARGEST_PHASE
    return np.where(slow, exact[0], stiff[0]), np.where(slow, exact[1], stiff[1])


def _exact(omega: Any, damping_ratio: Any, h: Any) -> tuple[Any, Any]:
    c = damping_ratio * omega * h
    theta = omega * h * np.emath.sqrt(1.0 - damping_ratio**2)
    decay = np.exp(-2.0 * c)
    # 1 − 2e^{−c}cos θ + e^{−2c} without the cancellation at small steps
    restoring = np.real(np.expm1(-c) ** 2 + 4.0 * np.exp(-c) * np.sin(theta / 2.0) ** 2)
    rigid = omega * h < 1e-8
    gain = np.where(rigid, h * h, restoring / np.where(rigid, 1.0, omega) ** 2)
    return decay, gain


def _trapezoidal(omega: Any, damping_ratio: Any, h: Any) -> tuple[Any, Any]:
    a, b = damping_ratio * omega * h, (omega * h) ** 2 / 4.0
    scale = 1.0 / (1.0 + a + b)
    return (1.0 - a + b) * scale, h * h * scale
