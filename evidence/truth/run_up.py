"""A rotor that gains or loses speed: exact passages of linear modes.

The casing turns past the blades by θ(t) = ∫Ω dt, the exact integral of a table of speeds.

- `passage` and `passed`: closed form of one mode that a linear change of speed takes through a
  resonance. With s = −ξω + iω_d and u = q̇ − s̄ q a load Re(F e^{inθ}) gives
  u̇ = s u + (F e^{inθ} + c.c.)/2, so that, without any approximation,

      q = Im[F e^{inθ} z(n) + F̄ e^{−inθ} z(−n)]/(2 ω_d),   ż = (s − inΩ(t)) z + 1.

  Where nΩ passes ω, z(n) alone is large (rotating wave).
- `linear_run`: all modes under any harmonics and any table, by an ODE solver.

`evidence.truth.run_up_rubbing` has contact. Only NumPy and SciPy: nothing is shared with the
product.
"""

import itertools
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.special import wofz

Function = Callable[[np.ndarray], np.ndarray]
ACCURACY = 1e-12  # of the ODE solver, of the motion and of static displacements


class Turning(NamedTuple):
    """Rotation of the disk, functions of time [s] of any shape."""

    angle: Function  # θ [rad], 0 at the first time of the table
    speed: Function  # Ω [rad/s]
    acceleration: Function  # Ω̇ behind a time, where it jumps [rad/s²]
    time: Function  # at which θ [rad] is reached [s]; speeds must be positive for it
    corners: np.ndarray  # times of the table [s]


class Harmonic(NamedTuple):
    """A load Re(force e^{i order θ}) on the modes."""

    order: int
    force: np.ndarray  # (K,), complex [N/√kg]
    ramped: bool = True  # whether it grows with the bump ramp


def turned(times: Sequence[float], speeds: Sequence[float]) -> Turning:
    """The Turning of a table of increasing times [s] and speeds [rad/s], straight lines between.

    Before and behind the table the speed is that of its ends. Raises ValueError for other times.
    """
    t, omega = np.asarray(times, dtype=float), np.asarray(speeds, dtype=float)
    if not (np.diff(t) > 0.0).all():
        raise ValueError(f"times must increase: {times}")
    slope = np.append(np.diff(omega) / np.diff(t), 0.0)
    at = np.append(0.0, np.cumsum((omega[1:] + omega[:-1]) / 2.0 * np.diff(t)))

    def piece(table, values):
        k = np.maximum(np.searchsorted(table, values, side="right") - 1, 0)
        inside = np.asarray(values) >= table[0]
        return k, np.where(inside, slope[k], 0.0), values - table[k]

    def angle(time):
        k, a, since = piece(t, time)
        return at[k] + since * (omega[k] + a * since / 2.0)

    def speed(time):
        k, a, since = piece(t, time)
        return omega[k] + a * since

    def time(theta):
        k, a, more = piece(at, theta)
        root = np.sqrt(np.maximum(omega[k] ** 2 + 2.0 * a * more, 0.0))
        return t[k] + 2.0 * more / (omega[k] + root)

    return Turning(angle, speed, lambda time: piece(t, time)[1], time, t)


def passage(
    omega: float, damping: float, order: int, from_hz: float, hz_per_s: float, times: np.ndarray
) -> np.ndarray:
    """Complex amplitudes z of ż = (−ξω + i(ω_d − nΩ(t))) z + 1, z(0) = 0 [s].

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
        return (free - 1.0) / (1j * start - decay)
    if rate < 0.0:  # the conjugate passes the other way
        return _falling(decay, -start, -rate, t, free.conj()).conj()
    return _falling(decay, start, rate, t, free)


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


def steady(omega: float, damping: float, order: int, hz: np.ndarray) -> np.ndarray:
    """Complex amplitude z [s] at constant speeds [Hz]; its largest size is 1/(ξω)."""
    away = omega * np.sqrt(1.0 - damping**2) - order * 2.0 * np.pi * np.asarray(hz)
    return 1.0 / (damping * omega - 1j * away)


def passed(
    omega: float, damping: float, order: int, force: complex, from_hz: float, hz_per_s: float,
    times: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """Exact q of q̈ + 2ξω q̇ + ω² q = Re(force e^{i order θ}) from rest, in a linear change of speed.

    Arguments as in `passage`; force [N/√kg]. Returns modal displacements [m √kg] at the times.
    """
    t = np.asarray(times, dtype=float)
    wave = force * np.exp(1j * order * 2.0 * np.pi * t * (from_hz + hz_per_s * t / 2.0))
    forward, backward = (passage(omega, damping, n, from_hz, hz_per_s, t) for n in (order, -order))
    total = wave * forward + wave.conj() * backward
    return total.imag / (2.0 * omega * np.sqrt(1.0 - damping**2))


def ramp(t: np.ndarray, ramp_time: float) -> np.ndarray:
    """Growth of the casing's heights from 0 to 1 at times [s]; 1 without a ramp."""
    if ramp_time == 0.0:
        return np.ones_like(t)
    return np.expm1(-5.0 * np.clip(t / ramp_time, 0.0, 1.0)) / np.expm1(-5.0)


def load_of(forces: Sequence[Harmonic]) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """Modal load (..., K) [N/√kg] as a function of θ [rad] and of how far the ramp is [-]."""
    order, ramped = (np.array([f[k] for f in forces]) for k in (0, 2))
    size = np.array([f.force for f in forces])

    def load(theta, grown):
        parts = np.where(ramped, grown[..., None], 1.0)
        return ((np.exp(1j * theta[..., None] * order) * parts) @ size).real

    return load


def linear_run(
    omega: np.ndarray, damping: np.ndarray, forces: Sequence[Harmonic], turning: Turning,
    times: np.ndarray, coupling: np.ndarray | None = None, euler: np.ndarray | None = None,
    ramp_time: float = 0.0,
) -> np.ndarray:  # fmt: skip
    """Modal displacements (T, K) [m √kg] at increasing times (T,) [s] from rest at the time 0.

    q̈ + 2ξω q̇ + ω² q + coupling q = Σ Re(F e^{inθ}) − Ω̇ euler, by DOP853 from corner to corner.
    omega (K,) [rad/s]; damping ξ (K,); forces: at least one; coupling (K, K) [1/s²]; euler (K,):
    Φᵀ M r, r the displacement of a turn by one radian [m √kg]; ramp_time: of the ramped loads [s].
    """
    K, end, load = len(omega), float(times[-1]), load_of(forces)
    stiffness = np.diag(omega**2) + (0.0 if coupling is None else coupling)
    loss, inertia = 2.0 * damping * omega, np.zeros(K) if euler is None else euler
    scale = sum(np.abs(f.force) for f in forces).max() + np.abs(inertia).max()
    small = ACCURACY * scale / np.concatenate([omega**2, omega])
    corners = sorted({t for t in (*turning.corners, ramp_time) if 0.0 < t < end})
    y, found = np.zeros(2 * K), np.zeros((len(times), K))
    for first, last in itertools.pairwise([0.0, *corners, end]):
        begin = turning.angle(first), turning.speed(first)
        slope = turning.acceleration((first + last) / 2.0)

        def rates(t, y, first=first, begin=begin, slope=slope):
            since = t - first
            theta = begin[0] + since * (begin[1] + slope * since / 2.0)
            f = load(theta, ramp(t, ramp_time)) - slope * inertia
            return np.concatenate([y[K:], f - stiffness @ y[:K] - loss * y[K:]])

        here = (times >= first) & (times <= last)
        asked = np.unique(np.append(times[here], last))
        solved = solve_ivp(rates, (first, last), y, "DOP853", asked, rtol=ACCURACY, atol=small)
        found[here] = solved.y.T[np.searchsorted(asked, times[here]), :K]
        y = solved.y[:, -1]
    return found
