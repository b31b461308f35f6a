"""Forced response to an engine-order excitation of the blades, in the frequency domain.

The load of a blade is F cos(n_d (theta - Omega t)), radial [equation (5)], shared evenly by its
contact points, each at its own angle theta. In the rotating frame it is harmonic at w = n_d Omega,
and a displacement is Re(u exp(j w t)) with

    u = sum_k observed_k p_k / (omega_k^2 - w^2 + 2 j xi omega_k w),
    p_k = sum_i F/n_i normal_ik exp(-j n_d theta_i),    n_i contact points on the blade of point i.
"""

import numpy as np
import numpy.typing as npt

from hpcrub.model.interface import Interface
from hpcrub.model.reduction import Modes

_MESH_STEP = 0.25  # of the search mesh, in distances to the nearest pole
_WORTH_REFINING = 0.9  # mesh maxima below this share of the largest cannot overtake it
_MAX_ITERATIONS = 60


def engine_order_response(
    modes: Modes,
    damping_ratio: float,
    amplitude: float,
    engine_order: int,
    interface: Interface,
    speed_hz: npt.ArrayLike,
) -> np.ndarray:
    """Steady displacements under an engine-order excitation of the blades.

    Parameters
    ----------
    modes : Modes
    damping_ratio : float
        Of every mode [-].
    amplitude : float
        Of the radial load on a blade [N].
    engine_order : int
        Number n_d of periods of the load over the circumference.
    interface : Interface
        Contact points that carry the load.
    speed_hz : array_like (S,)
        Rotation [Hz].

    Returns
    -------
    ndarray (S, O)
        Complex amplitudes of the observed displacements [m].

    Notes
    -----
    Joachim, Nyssen, Batailly (2020), equation (5).
    """
    w = 2 * np.pi * engine_order * np.asarray(speed_hz, dtype=float)
    load = _modal_load(modes, amplitude, engine_order, interface)
    return (load / _dynamic_stiffness(modes.omega, damping_ratio, w)) @ modes.observed.T


def linear_peak(
    modes: Modes,
    damping_ratio: float,
    amplitude: float,
    engine_order: int,
    interface: Interface,
    n_family: int,
) -> tuple[float, float]:
    """Largest observed displacement over the speeds of the first family of modes.

    Parameters
    ----------
    modes, damping_ratio, amplitude, engine_order, interface
        As of `engine_order_response`.
    n_family : int
        Modes in the first family. Speeds run from 0.9 omega_1 to 1.1 omega_n_family, over n_d.

    Returns
    -------
    amplitude : float
        To 1e-6 of itself [m].
    speed_hz : float
        Where it is reached [Hz].

    Raises
    ------
    ValueError
        Without damping or with engine order zero: there is no peak then.

    Notes
    -----
    Joachim, Nyssen, Batailly (2020), section 2.3.2.
    """
    if not (damping_ratio > 0 and engine_order > 0):
        raise ValueError("a linear peak needs damping_ratio > 0 and engine_order > 0")
    load = _modal_load(modes, amplitude, engine_order, interface)
    w = _search_mesh(modes.omega, damping_ratio, n_family)
    u = np.abs((load / _dynamic_stiffness(modes.omega, damping_ratio, w)) @ modes.observed.T)

    speed, row = _mesh_maxima(u)
    residues = modes.observed[row] * load
    low, high = w[np.maximum(speed - 1, 0)], w[np.minimum(speed + 1, len(w) - 1)]
    w, u = _refine(residues, modes.omega, damping_ratio, w[speed], low, high)
    best = np.argmax(u)
    return float(u[best]), float(w[best] / (2 * np.pi * engine_order))


def _modal_load(modes, amplitude, engine_order, interface):
    share = 1.0 / interface.points_per_blade[interface.blade]
    return amplitude * ((share * np.exp(-1j * engine_order * interface.angle)) @ modes.normal)


def _dynamic_stiffness(omega, xi, w):
    """omega^2 - w^2 + 2 j xi omega w of every mode, (len(w), K)."""
    stiffness = np.empty((len(w), len(omega)), dtype=complex)
    np.subtract(omega**2, w[:, None] ** 2, out=stiffness.real)
    np.multiply(2 * xi * omega, w[:, None], out=stiffness.imag)
    return stiffness


def _search_mesh(omega, xi, n_family):
    """Excitation frequencies that leave no room for a peak between two of them [rad/s].

    The response is analytic in w but for a pole at about xi omega_k beside every resonance, so it
    can vary only on the scale of the distance to the nearest pole. The mesh has a constant step in
    s, where ds = dw / distance: w = omega_k + h sinh(s - s_k) around resonance k, h = xi omega_1.
    """
    first, last = 0.9 * omega[0], 1.1 * omega[n_family - 1]
    h = xi * omega[0]
    pole = omega[(omega >= first) & (omega <= last)]
    half_gap = np.arcsinh(np.diff(pole) / (2 * h))
    below, above = np.arcsinh((pole[0] - first) / h), np.arcsinh((last - pole[-1]) / h)
    s_pole = below + np.concatenate([[0], np.cumsum(2 * half_gap)])
    s_end = s_pole[-1] + above

    s = np.linspace(0, s_end, int(np.ceil(s_end / _MESH_STEP)) + 1)
    nearest = np.searchsorted(s_pole[:-1] + half_gap, s)
    return np.clip(pole[nearest] + h * np.sinh(s - s_pole[nearest]), first, last)


def _mesh_maxima(u):
    """Indices (speed, row) of the local maxima over speeds of u (S, O) that may be largest."""
    lowest = np.full((1, u.shape[1]), -np.inf)
    padded = np.concatenate([lowest, u, lowest])
    is_maximum = (u >= padded[:-2]) & (u >= padded[2:])
    return np.nonzero(is_maximum & (u >= _WORTH_REFINING * u.max()))


def _refine(residues, omega, xi, w, low, high):
    """Maximise |u|, u = sum_k residues_k / d_k(w), from w inside [low, high], several at once.

    Newton's method on the slope of |u|^2, halving the bracket where it fails.
    Returns the last w and |u|, shapes as w.
    """
    for _ in range(_MAX_ITERATIONS):
        inverse = 1 / _dynamic_stiffness(omega, xi, w)
        d1 = 2 * (1j * xi * omega - w[:, None])  # dd/dw; the second derivative is -2
        u, u1, u2 = _response_and_slopes(residues, inverse, d1)
        slope = (u1 * u.conj()).real
        bend = (u2 * u.conj()).real + np.abs(u1) ** 2
        low, high = np.where(slope > 0, w, low), np.where(slope > 0, high, w)
        with np.errstate(divide="ignore", invalid="ignore"):
            newton = w - slope / bend
        usable = (bend < 0) & (newton >= low) & (newton <= high)
        step = np.where(usable, newton, (low + high) / 2) - w
        if np.all(np.abs(step) <= 1e-5 * xi * omega[0]):
            break
        w = w + step
    return w, np.abs(u)


def _response_and_slopes(residues, inverse, d1):
    """Response u = sum r/d and its two derivatives by w, for d'' = -2."""
    term = residues * inverse
    term1 = -term * d1 * inverse
    term2 = 2 * (term - term1 * d1) * inverse
    return term.sum(axis=1), term1.sum(axis=1), term2.sum(axis=1)
