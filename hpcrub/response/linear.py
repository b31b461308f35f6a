"""Forced response to an engine-order excitation of the blades, in the frequency domain.

The load of a blade is F cos(n_d (theta - Omega t)), radial [equation (5)], shared evenly by its
contact points at the angles theta of the rotating frame. The load travels forward over the disk;
with a negative n_d it travels backward, and is at rest in space, as a casing is. It is harmonic at
w = |n_d| Omega, and a displacement is Re(u exp(j w t)) with

    u = sum_k observed_k p_k / (omega_k^2 - w^2 + 2 j xi omega_k w),
    p_k = sum_i F/n_i normal_ik exp(-j n_d theta_i),    n_i contact points on the blade of point i.

Where the stiffness depends on the speed, omega_k is taken at the speed Omega = w / |n_d|, and the
peak with the shapes of its own speed. A complex mode z' = lambda z + l f of a disk in air, with
displacement Re(r z), adds r l p / 2(jw - lambda) and the term with the conjugates of r, l and
lambda; lambda grows with omega over the speed, and l falls.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from hpcrub.model.damping import Damping, ratios_of
from hpcrub.model.interface import Interface
from hpcrub.model.reduction import Modes, powers

_MESH_STEP = 0.25  # step of the search mesh, in distances to the nearest pole
_WORTH_REFINING = 0.9  # mesh maxima below this share of the largest cannot overtake it
_PARABOLAS, _CLOSER = 4, 4.0  # through mesh points, then through points so much closer
_SETTLED, _MAX_PASSES = 1e-4, 5  # relative change of the peak's speed that needs no other shapes


def engine_order_response(
    modes: Modes,
    damping_ratio: float | Damping,
    amplitude: float,
    engine_order: int,
    interface: Interface,
    speed_hz: npt.ArrayLike,
) -> np.ndarray:
    """Steady displacements under an engine-order excitation of the blades.

    - damping_ratio: one for all modes, or one for each [-].
    - amplitude: amplitude of the radial load on a blade [N].
    - engine_order: number n_d of periods of the load over the circumference; negative: at rest in
      space.
    - interface: contact points that carry the load.
    - speed_hz: (S,) speeds of rotation [Hz].

    Returns complex amplitudes of the observed displacements (S, O) [m].
    Source: Joachim, Nyssen, Batailly (2020), equation (5).
    """
    w = 2 * np.pi * abs(engine_order) * np.asarray(speed_hz, dtype=float)
    oscillators = _Oscillators(modes, damping_ratio, abs(engine_order))
    load = oscillators.load(_modal_load(modes, amplitude, engine_order, interface))
    return (load / oscillators.stiffness(w)) @ oscillators.observed.T


def linear_peak(
    modes: Modes,
    damping_ratio: float | Damping,
    amplitude: float,
    engine_order: int,
    interface: Interface,
    n_family: int,
    modes_at: Callable[[float], Modes] | None = None,
) -> tuple[float, float]:
    """Largest observed displacement over the speeds of the first family of modes.

    - modes, damping_ratio, amplitude, engine_order, interface: as in `engine_order_response`; there
      is no peak without damping, and none of engine order zero.
    - n_family: modes in the first family. Speeds run from 0.9 omega_1 to 1.1 omega_n_family, over
      n_d, with each omega at the speed where the load meets the mode. Where the load meets none,
      because the stiffness grows faster with the speed, frequencies are those at `Modes.speed`.
    - modes_at: gives the modes of this disk with the shapes at a speed [rad/s]; with it the peak
      has the shapes of its own speed, to about 1e-4; None: it has those of `modes`.

    Returns amplitude [m], to a relative 1e-6, infinite where a mode flutters in air; speed_hz, its
    speed [Hz].
    Source: Joachim, Nyssen, Batailly (2020), section 2.3.2.
    """
    load = damping_ratio, amplitude, engine_order, interface
    size, speed_hz = _peak(modes, *load, n_family)
    for _ in range(_MAX_PASSES):
        if modes_at is None or not len(modes.stiffening):
            break
        moved = abs(2 * np.pi * speed_hz / modes.speed - 1.0) if modes.speed else np.inf
        meets = np.isfinite(_resonances(modes, abs(engine_order))[:n_family]).all()
        if not (moved > _SETTLED and meets):
            break
        modes = modes_at(2 * np.pi * speed_hz)
        size, speed_hz = _peak(modes, *load, n_family)
    return size, speed_hz


def _peak(
    modes: Modes,
    damping_ratio: Any,
    amplitude: Any,
    engine_order: int,
    interface: Interface,
    n_family: int,
) -> Any:
    """Peak with the shapes of given modes, as of `linear_peak`."""
    if modes.waves and not (modes.waves.damping_ratio > 0.0).all():
        return np.inf, np.nan
    load = _modal_load(modes, amplitude, engine_order, interface)
    engine_order = abs(engine_order)
    if not np.isfinite(_resonances(modes, engine_order)[:n_family]).all():
        modes = modes.fixed
    oscillators = _Oscillators(modes, damping_ratio, engine_order)
    load = oscillators.load(load)
    w = _search_mesh(_resonances(modes, engine_order), oscillators.xi, n_family)
    u = np.abs((load / oscillators.stiffness(w)) @ oscillators.observed.T)

    speed, row = _mesh_maxima(u)
    residues = oscillators.observed[row] * load
    low, high = w[np.maximum(speed - 1, 0)], w[np.minimum(speed + 1, len(w) - 1)]
    w, u = _refine(residues, oscillators, w[speed], low, high)
    best = np.argmax(u)
    return float(u[best]), float(w[best] / (2 * np.pi * engine_order))


class _Oscillators:
    """Terms of the response at a frequency w: real modes, complex modes, their conjugates."""

    def __init__(self, modes: Modes, damping_ratio: float | Damping, engine_order: int) -> None:
        self.modes, self.engine_order = modes, engine_order
        self.xi = ratios_of(damping_ratio, modes.omega)
        self.real, self.observed, waves = modes.real, modes.observed, modes.waves
        if waves:
            self.xi = self.xi.copy()
            self.xi[waves.rows] = waves.damping_ratio
            seen = self.observed[:, waves.rows] @ waves.right
            self.observed = np.hstack([self.observed[:, self.real], seen, seen.conj()])

    def load(self, modal: np.ndarray) -> np.ndarray:
        """Force on every term (T,) from the modal forces (K,)."""
        waves = self.modes.waves
        if waves is None:
            return modal
        part = waves.pushed @ modal[waves.rows]
        return np.concatenate([modal[self.real], part, (waves.pushed.conj() @ modal[waves.rows])])

    def stiffness(self, w: np.ndarray) -> np.ndarray:
        """Denominators (n, T) of all terms.

        They are omega^2 - w^2 + 2 j xi omega w of real modes, 2(jw - lambda) Im lambda of complex
        modes.
        """
        omega = self.modes.omega_at(w / self.engine_order)
        stiffness = np.empty((len(w), omega.shape[-1]), dtype=complex)
        np.subtract(omega**2, w[:, None] ** 2, out=stiffness.real)
        np.multiply(2 * self.xi * omega, w[:, None], out=stiffness.imag)
        waves = self.modes.waves
        if waves is None:
            return stiffness
        growth = waves.growth(powers(w / self.engine_order, self.modes.speed))
        poles, sizes = growth * waves.eigenvalue, growth * waves.eigenvalue.imag
        both = np.hstack([poles, poles.conj()])
        scale = 2.0 * np.hstack([sizes, sizes])
        return np.hstack([stiffness[:, self.real], scale * (1j * w[:, None] - both)])


def _resonances(modes: Modes, engine_order: int) -> Any:
    """Frequencies w = omega(w / n_d) at which the load meets every mode (K,); NaN where never.

    omega^2 = a + b w^2 + c w^4, so that c w^4 - (1 - b) w^2 + a = 0, whose smaller root counts.
    """
    squared, stiffening, waves = modes.omega**2, modes.stiffening, modes.waves
    if waves:
        squared[waves.rows], stiffening = waves.eigenvalue.imag**2, stiffening.copy()
        stiffening[:, waves.rows] = squared[waves.rows] * waves.slopes
    if not len(stiffening):
        return np.sqrt(squared)
    by_square, by_fourth = stiffening
    a = squared - by_square * modes.speed**2 - by_fourth * modes.speed**4
    left = 1 - by_square / engine_order**2
    c = by_fourth / engine_order**4
    with np.errstate(all="ignore"):
        square = 2 * a / (left + np.sqrt(left**2 - 4 * a * c))
        return np.sqrt(np.where(square > 0, square, np.nan))


def _modal_load(modes: Modes, amplitude: Any, engine_order: int, interface: Interface) -> Any:
    force = interface.share * np.exp(-1j * engine_order * interface.angle)
    return amplitude * (force @ modes.normal)


def _search_mesh(omega: Any, xi: Any, n_family: int) -> Any:
    """Excitation frequencies [rad/s] so close that no peak fits between two of them.

    The response is analytic in w except for a pole at about xi omega_k beside every resonance, so
    it varies only on the scale of the distance to the nearest pole. The mesh has a constant step in
    s, where ds = dw / distance: w = omega_k + h sinh(s - s_k) around resonance k, with h the
    smallest xi omega of all modes.
    """
    first, last = 0.9 * omega[:n_family].min(), 1.1 * omega[:n_family].max()
    near = (omega >= first) & (omega <= last)
    h, pole = (xi * omega)[near].min(), np.sort(omega[near])
    half_gap = np.arcsinh(np.diff(pole) / (2 * h))
    below, above = np.arcsinh((pole[0] - first) / h), np.arcsinh((last - pole[-1]) / h)
    s_pole = below + np.concatenate([[0], np.cumsum(2 * half_gap)])
    s_end = s_pole[-1] + above

    s = np.linspace(0, s_end, int(np.ceil(s_end / _MESH_STEP)) + 1)
    nearest = np.searchsorted(s_pole[:-1] + half_gap, s)
    return np.clip(pole[nearest] + h * np.sinh(s - s_pole[nearest]), first, last)


def _mesh_maxima(u: Any) -> Any:
    """Indices (speed, row) of local maxima of u (S, O) over the speeds that may be the largest."""
    lowest = np.full((1, u.shape[1]), -np.inf)
    padded = np.concatenate([lowest, u, lowest])
    is_maximum = (u >= padded[:-2]) & (u >= padded[2:])
    return np.nonzero(is_maximum & (u >= _WORTH_REFINING * u.max()))


def _refine(residues: Any, oscillators: Any, w: Any, low: Any, high: Any) -> tuple[Any, Any]:
    """Maximise |u|, u = sum_k residues_k / d_k(w), from w inside [low, high], several at once.

    Parabolas through three values of 1/|u|^2, which has the shape of one about a pole, closer and
    closer. Returns w and |u|.
    """

    def size(w: Any) -> Any:
        return np.abs((residues / oscillators.stiffness(w)).sum(axis=1))

    apart = (high - low) / 2.0
    for _ in range(_PARABOLAS):
        with np.errstate(divide="ignore", invalid="ignore"):  # of tips that do not move
            before, here, after = (size(w + k * apart) ** -2.0 for k in (-1.0, 0.0, 1.0))
            bend = before - 2.0 * here + after
            to_vertex = np.where(bend > 0.0, (before - after) / (2.0 * bend), 0.0)
        w = np.clip(w + apart * np.clip(to_vertex, -1.0, 1.0), low, high)
        apart = apart / _CLOSER
    return w, size(w)
