"""A rotor that gains or loses speed: exact passages of linear modes.

The casing turns past the blades by θ(t) = ∫Ω dt, the exact integral of a table of speeds. With
s = −ξω + iω_d and u = q̇ − s̄ q a load Re(F e^{inθ}) on a mode gives u̇ = s u + (F e^{inθ} + c.c.)/2,
so that, without any approximation,

    q = Im[F e^{inθ} z(n) + F̄ e^{−inθ} z(−n)]/(2 ω_d),   ż = (s − inΩ(t)) z + 1.

Where nΩ passes ω, z(n) alone is large (rotating wave). `evidence.truth.run_up_rubbing` has contact.
Only NumPy and SciPy: nothing is shared with the product.
"""

from collections.abc import Sequence

import numpy as np
from scipy.special import wofz


def passage(
    omega: float, damping: float, order: int, from_hz: float, hz_per_s: float, times: np.ndarray,
    begun: complex = 0.0,
) -> np.ndarray:  # fmt: skip
    """Complex amplitudes z of ż = (−ξω + i(ω_d − nΩ(t))) z + 1, z(0) = begun [s].

    omega [rad/s], damping ξ: of the mode; order n: waves of the casing, also negative or 0;
    from_hz: speed at the time 0 [Hz]; hz_per_s: its change, also negative or 0; times [s], any
    shape. With δ = ω_d − nΩ, which falls by r in a second, c² = −ir/2, d = (ξω − iδ)/2c and the
    Faddeeva function w, √π w(id)/2c is a solution of the equation, and so is −√π w(−id)/2c. One is
    bounded wherever a passage begins before the resonance, the other where it begins behind:
    e^{d²} is never formed, whatever its size.
    """
    t, decay = np.asarray(times, dtype=float), damping * omega
    start = omega * np.sqrt(1.0 - damping**2) - order * 2.0 * np.pi * from_hz
    rate = order * 2.0 * np.pi * hz_per_s  # δ falls by it
    free = np.exp(-decay * t + 1j * (start - rate * t / 2.0) * t)
    if rate == 0.0:
        return begun * free + (free - 1.0) / (1j * start - decay)
    if rate < 0.0:  # the conjugate passes the other way
        return begun * free + _falling(decay, -start, -rate, t, free.conj()).conj()
    return begun * free + _falling(decay, start, rate, t, free)


def _falling(
    decay: float, start: float, rate: float, t: np.ndarray, free: np.ndarray
) -> np.ndarray:
    """The `passage` of a detuning δ = start − rate·t [rad/s], rate > 0; free: motion from z = 1."""
    c = np.sqrt(rate / 2.0) * np.exp(-0.25j * np.pi)
    first, now = ((decay - 1j * delta) / (2.0 * c) for delta in (start, start - rate * t))
    side = 1.0 if first.real >= 0.0 else -1.0
    return (
        side * np.sqrt(np.pi) / (2.0 * c) * (wofz(side * 1j * now) - free * wofz(side * 1j * first))
    )


def passed(
    omega: float, damping: float, order: int, force: complex, at: Sequence[float],
    hz: Sequence[float], times: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """Exact q (T,) [m √kg] of q̈ + 2ξω q̇ + ω² q = Re(force e^{i order θ}) from rest, at times (T,).

    at (S,) [s], hz (S,): a table of speeds from the time 0 to the last one, straight lines between;
    force [N/√kg]; omega, damping, order: as in `passage`.
    """
    slopes = np.diff(hz) / np.diff(at)
    turns = np.append(0.0, np.cumsum((np.add(hz[1:], hz[:-1])) / 2.0 * np.diff(at)))
    found = np.zeros((2, len(times)), dtype=complex)
    for way, n, F in ((0, order, force), (1, -order, np.conj(force))):
        z = np.zeros(1)
        for k, slope in enumerate(slopes):
            here = (times >= at[k]) & (times <= at[k + 1])
            since = np.append(times[here], at[k + 1]) - at[k]
            z = passage(omega, damping, n, hz[k], slope, since, z[-1])
            theta = 2.0 * np.pi * (turns[k] + since * (hz[k] + slope * since / 2.0))
            found[way, here] = (F * np.exp(1j * n * theta) * z)[:-1]
    return found.sum(axis=0).imag / (2.0 * omega * np.sqrt(1.0 - damping**2))
