"""The 12-blade disk without modal coordinates, by an implicit velocity-level scheme.

Same finite-element matrices, casing law and physics as the studies, everything else different:

- all 240 dof, no Craig–Bampton reduction and no modes; the modal damping is a full matrix
  C = M Φ diag(2ξω) Φᵀ M;
- a Moreau–Jean type scheme, the θ-method in displacement and velocity,
  (M + hθC + h²θ²K)(v_{k+1} − v_k) = −h C v_k − h K (u_k + hθ v_k) + Jᵀp,
  u_{k+1} = u_k + h [θ v_{k+1} + (1 − θ) v_k];
- contact on the level of velocities and impulses, as Stewart and Trinkle write it:
  0 ≤ g_k + (w_{k+1} − w_k) − h u̇_{r,k+1} ⊥ p ≥ 0, with w the place of the casing, and e = 0.
  The kernel corrects positions by forces that act one step earlier;
- friction −μp along +t; projected Gauss–Seidel on the impulses of all tips.

The clock is the time, not the angle, so all speeds share every step. θ = 1/2 would leave modes far
above 1/h undamped, which every impact excites: θ = 0.51 takes 4 % of them a step and adds
(θ − 1/2)ωh, 4·10⁻⁵ at 138 Hz and h = 5 µs, to the damping ratio.
"""

from typing import NamedTuple

import numba
import numpy as np
from scipy.linalg import cho_factor, cho_solve, eigh

from hpcrub.reduction import mistuned_modes
from hpcrub.steady import SteadyCriteria
from hpcrub.sweep import Scene, run_sweep
from validation import disk as reference_disk
from validation import report
from validation.motion import WIDTH

SWEEPS, TOLERANCE = 200, 1e-12


class Casing(NamedTuple):
    """Bumps, clearance and friction, written out once more."""

    n_bumps: int = 4
    height: float = 1.25e-3
    clearance: float = 0.25e-3
    growth_time: float = 0.01
    friction: float = 0.15

    def surface(self, angle, t):
        """Place of the casing over the tips at rest, at ``angle`` from bump 0 at time t [m]."""
        pitch = 2.0 * np.pi / self.n_bumps
        phi = (angle + pitch / 2.0) % pitch - pitch / 2.0
        bump = self.height * np.exp(-((phi / (0.1 * pitch)) ** 2))
        x = 5.0 * min(t / self.growth_time, 1.0)
        return self.clearance - (1.0 - np.exp(-x)) / (1.0 - np.exp(-5.0)) * bump


class _Operators(NamedTuple):
    move: np.ndarray  # (n, 2n) velocity change of a step without contact from (u, v)
    answer: np.ndarray  # (n, n_c) velocity change per unit impulse
    delassus: np.ndarray  # (n_c, n_c)


def _operators(disk, damping_ratio, friction, h, theta):
    M, K = disk.mass, disk.stiffness
    eigenvalues, Phi = eigh(K, M)
    MPhi = M @ Phi
    C = MPhi @ (2.0 * damping_ratio * np.sqrt(eigenvalues)[:, None] * MPhi.T)
    A = cho_factor(M + h * theta * C + (h * theta) ** 2 * K)
    move = -h * cho_solve(A, np.hstack([K, C + h * theta * K]))
    radial, tangential = disk.contact_dof.T
    J = np.zeros((len(M), len(radial)))
    J[radial, np.arange(len(radial))] = -1.0
    J[tangential, np.arange(len(radial))] = -friction
    answer = cho_solve(A, J)
    return _Operators(move, answer, np.ascontiguousarray(-answer[radial]))


@numba.njit
def _impulses(W, approach):
    """p ≥ 0, approach − W p ≤ 0, p·(approach − W p) = 0; NaN if that does not converge (n_c,)."""
    p = np.zeros(len(approach))
    for _ in range(SWEEPS):
        change = 0.0
        for i in range(len(p)):
            rest = approach[i]
            for j in range(len(p)):
                rest -= W[i, j] * p[j]
            new = max(0.0, p[i] + rest / W[i, i])
            change = max(change, abs(new - p[i]) * W[i, i])
            p[i] = new
        if change <= TOLERANCE * approach.max():
            return p
    return np.full(len(p), np.nan)


def amplitudes(disk, damping_ratio, casing, speeds_hz, h, duration, theta=0.51):
    """Largest |u_t| of any tip over three revolutions.

    disk: hpcrub.disk.Disk, mistuned or not; casing: Casing; speeds_hz (S,); h, duration [s].
    Returns amplitudes (2, S) [m] over the three revolutions before the last three and over the
    last three.
    """
    speeds_hz = np.asarray(speeds_hz, dtype=float)
    operators = _operators(disk, damping_ratio, casing.friction, h, theta)
    radial, tangential = disk.contact_dof.T
    angle = disk.contact_angle[:, None]
    n, n_speeds = len(disk.mass), len(speeds_hz)
    y = np.zeros((2 * n, n_speeds))
    u, v = y[:n], y[n:]
    peaks = np.zeros((2, n_speeds))
    for k in range(round(duration / h)):
        t = (k + 1) * h
        place = casing.surface(angle + 2.0 * np.pi * speeds_hz * t, t)
        new = v + operators.move @ y
        approach = new[radial] - (place - u[radial]) / h
        for s in np.flatnonzero((approach > 0.0).any(axis=0)):
            new[:, s] += operators.answer @ _impulses(operators.delassus, approach[:, s])
        u += h * (theta * new + (1.0 - theta) * v)
        v[:] = new
        left = (duration - t) * speeds_hz  # revolutions
        if left.min() < 6.0:
            size = np.abs(u[tangential]).max(axis=0)
            for window, inside in enumerate(((left >= 3.0) & (left < 6.0), left < 3.0)):
                peaks[window] = np.where(inside, np.maximum(peaks[window], size), peaks[window])
    return peaks


PERIODIC = np.array([33.25, 33.5, 34.0])  # Hz
DAMPED, REFERENCE = 0.02, 0.005  # damping ratios
TEXT = """## The 12-blade disk, full matrices

An independent program (`validation/full_disk.py`): all 240 dof, no Craig–Bampton reduction and no
modal coordinates, damping as a full matrix, an implicit Moreau–Jean scheme (θ = 0.51) with contact
in velocities and impulses, clock in time instead of angle. Common to both are the finite-element
matrices, the casing law and the physics of contact (rigid, e = 0, always sliding); the finite
elements have tests of their own. Tuned disk, four bumps, largest tip displacement [mm]."""
DAMPED_TEXT = """Damping 2 %, where the motion is periodic at all three speeds. Kernel with all
modes (η = 216) at 2 µs, `exact_modal`; the difference is that of the finest step:"""
WINDOWS = (0.8, 1.0, 1.2, 1.4)  # ends of the three revolutions that are looked at [s]
REFERENCE_TEXT = """Damping 0.5 %, the reference disk: least and largest amplitude of several
windows of three revolutions. With η = 60 the kernel finds periodic motions of 10.8 and 14.4 mm.
With more modes the motion does not settle: impacts excite modes that the reduction with η = 60
leaves out, and the amplitude wanders by some per cent from window to window and from step to
step. The full matrices do the same, within the same ranges. So where the columns differ it is by
the model, not by the integration: at these speeds the disk with η = 60 vibrates some 5 % less
than the full one, at times 14 % less."""


def kernel_amplitudes(n_modes, damping_ratio, speeds_hz, step, seconds):
    """Largest tip displacement by the program and the status of each speed, (S,) each."""
    reduced = reference_disk.reduced(n_modes)
    casing = Casing()
    scene = Scene(
        contact_angle=reduced.contact_angle,
        contact_radius=float(reduced.contact_radius[0]),
        damping_ratio=damping_ratio,
        n_bumps=casing.n_bumps,
        bump_height=casing.height,
        clearance=casing.clearance,
        growth_time=casing.growth_time,
        friction=casing.friction,
        scheme="exact_modal",
        step=step,
        steady=SteadyCriteria(first_check=seconds, max_time=seconds),
    )
    modes = mistuned_modes(reduced, np.zeros(len(reduced.contact_angle)))
    result = run_sweep(modes, scene, speeds_hz, width=WIDTH)
    return result.amplitude


def section(_folder):
    """Markdown of this case."""
    return "\n\n".join([TEXT, DAMPED_TEXT, _damped_table(), REFERENCE_TEXT, _reference_table()])


def _damped_table():
    kernel = kernel_amplitudes(216, DAMPED, PERIODIC, 2e-6, 0.5)
    steps = (2e-5, 1e-5, 5e-6)
    full = [amplitudes(reference_disk.full(), DAMPED, Casing(), PERIODIC, h, 0.5)[1] for h in steps]
    head = ["speed [Hz]", "kernel", *(f"full, {1e6 * h:g} µs" for h in steps), "difference"]
    rows = [
        [
            f"{speed:g}",
            *(f"{1e3 * a:.3f}" for a in (kernel[s], *(f[s] for f in full))),
            f"{100.0 * (full[-1][s] / kernel[s] - 1.0):+.2f} %",
        ]
        for s, speed in enumerate(PERIODIC)
    ]
    return report.table(head, rows)


def _reference_table():
    speeds = PERIODIC[:2]
    columns = {}
    for n_modes, step in ((60, 2e-6), (216, 2e-6), (216, 1e-6)):
        columns[f"kernel, η = {n_modes}, {1e6 * step:g} µs"] = [
            kernel_amplitudes(n_modes, REFERENCE, speeds, step, end) for end in WINDOWS
        ]
    columns["full, 5 µs, two windows"] = amplitudes(
        reference_disk.full(), REFERENCE, Casing(), speeds, 5e-6, 1.0
    )
    rows = [
        [f"{speed:g}", *(_range(1e3 * np.array(column)[:, s]) for column in columns.values())]
        for s, speed in enumerate(speeds)
    ]
    return report.table(["speed [Hz]", *columns], rows)


def _range(values):
    return f"{values.min():.2f} … {values.max():.2f}"
