"""The 12-blade disk without modal coordinates, by an implicit velocity-level scheme.

Same finite-element matrices, casing law and physics as the studies, everything else different:

- all 240 dof without Craig–Bampton reduction, or the reduced matrices, never modal coordinates; the
  modal damping is a full matrix C = M Φ diag(2ξω) Φᵀ M;
- a Moreau–Jean type scheme, the θ-method in displacement and velocity,
  (M + hθC + h²θ²K)(v_{k+1} − v_k) = −h C v_k − h K (u_k + hθ v_k) + Jᵀp,
  u_{k+1} = u_k + h [θ v_{k+1} + (1 − θ) v_k];
- contact on the level of velocities and impulses, with w the place of the casing and e = 0:
  0 ≤ max(g_k, 0) + (w_{k+1} − w_k) − h u̇_{r,k+1} ⊥ p ≥ 0, and then a projection of the positions on
  g_{k+1} ≥ 0 that leaves the velocities (Acary 2013). With g_k in place of max(g_k, 0) the velocity
  would take back what a tip has sunk in, which is restitution of up to 1/2 after each impact.
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

from evidence.truth.disk import earlier_disk, earlier_reduced, reference_scene
from evidence.truth.motion import WIDTH
from evidence.truth.ring import Wall
from evidence.validation import report
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.steady import SteadyCriteria
from hpcrub.response.sweep import Motion, run_sweep

SWEEPS, TOLERANCE, THETA = 200, 1e-12, 0.51


@numba.njit
def surface(casing, angle, t):
    """Place of a Wall over a tip at rest, at ``angle`` from bump 0 at time t [m]."""
    pitch = 2.0 * np.pi / casing.n_bumps
    phi = (angle + pitch / 2.0) % pitch - pitch / 2.0
    bump = casing.height * np.exp(-((phi / (0.1 * pitch)) ** 2))
    x = 5.0 * min(t / casing.ramp_time, 1.0)
    return casing.clearance - (1.0 - np.exp(-x)) / (1.0 - np.exp(-5.0)) * bump


class Model(NamedTuple):
    """What the scheme needs of a structure; a `hpcrub.disk.Disk` has the same members."""

    mass: np.ndarray  # (n, n)
    stiffness: np.ndarray  # (n, n)
    contact_dof: np.ndarray  # (n_c, 2) u_r, u_t of each tip
    contact_angle: np.ndarray  # (n_c,) [rad]


def of_reduced(reduced):
    """The reduced matrices as a Model, without modal coordinates."""
    interface = reduced.interface
    rows = np.stack([interface.normal, interface.tangential], axis=1)  # (n_c, 2, n)
    dof = rows.argmax(axis=2)
    return Model(reduced.mass, reduced.stiffness, dof, interface.angle)


class _Operators(NamedTuple):
    move: np.ndarray  # (n, 2n) velocity change of a step without contact from (u, v)
    answer: np.ndarray  # (n, n_c) velocity change per unit impulse
    delassus: np.ndarray  # (n_c, n_c)


def _operators(model, damping_ratio, friction, h, theta):
    M, K = model.mass, model.stiffness
    eigenvalues, Phi = eigh(K, M)
    MPhi = M @ Phi
    C = MPhi @ (2.0 * damping_ratio * np.sqrt(eigenvalues)[:, None] * MPhi.T)
    A = cho_factor(M + h * theta * C + (h * theta) ** 2 * K)
    move = -h * cho_solve(A, np.hstack([K, C + h * theta * K]))
    radial, tangential = model.contact_dof.T
    J = np.zeros((len(M), len(radial)))
    J[radial, np.arange(len(radial))] = -1.0
    J[tangential, np.arange(len(radial))] = -friction
    answer = cho_solve(A, J)
    return _Operators(*map(np.ascontiguousarray, (move, answer, -answer[radial])))


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


@numba.njit
def _integrate(operators, casing, dof, angle, speeds_hz, h, theta, n_steps, y, start, peaks):
    """Integrate from y = (u, v) (2n, S) at the times start (S,) (y, peaks are modified)."""
    n, n_tips = len(y) // 2, len(angle)
    approach = np.empty(n_tips)
    change = np.empty((n, y.shape[1]))
    for k in range(n_steps):
        np.dot(operators.move, y, change)
        for s in range(len(speeds_hz)):
            t = start[s] + (k + 1) * h
            turned = 2.0 * np.pi * speeds_hz[s] * t
            for i in range(n_tips):
                r = dof[i, 0]
                before = surface(casing, angle[i] + turned - 2.0 * np.pi * speeds_hz[s] * h, t - h)
                moved = surface(casing, angle[i] + turned, t) - before
                open_by = max(before - y[r, s], 0.0)
                approach[i] = y[n + r, s] + change[r, s] - (open_by + moved) / h
            if approach.max() > 0.0:
                change[:, s] += np.dot(operators.answer, _impulses(operators.delassus, approach))
            left = (n_steps - k - 1) * h * speeds_hz[s]  # revolutions
            for j in range(n):
                y[j, s] += h * (y[n + j, s] + theta * change[j, s])
                y[n + j, s] += change[j, s]
            for i in range(n_tips):
                approach[i] = y[dof[i, 0], s] - surface(casing, angle[i] + turned, t)
            if approach.max() > 0.0:
                y[:n, s] += np.dot(operators.answer, _impulses(operators.delassus, approach))
            if left < 6.0:
                for i in range(n_tips):
                    window = 0 if left >= 3.0 else 1
                    peaks[window, s] = max(peaks[window, s], abs(y[dof[i, 1], s]))


def amplitudes(model, damping_ratio, casing, speeds_hz, h, duration, theta=THETA, start=None):
    """Largest |u_t| of any tip over three revolutions.

    model: Model or hpcrub.disk.Disk, mistuned or not; casing: Wall; speeds_hz (S,);
    h, duration [s]; start: u, v (n, S) and the time (S,) that they belong to, rest by default.
    Returns amplitudes (2, S) [m] over the three revolutions before the last three and over the
    last three.
    """
    speeds_hz = np.asarray(speeds_hz, dtype=float)
    operators = _operators(model, damping_ratio, casing.friction, h, theta)
    n, n_speeds = len(model.mass), len(speeds_hz)
    u, v, since = start or (*np.zeros((2, n, n_speeds)), np.zeros(n_speeds))
    y = np.ascontiguousarray(np.concatenate([u, v]))
    peaks = np.zeros((2, n_speeds))
    tips = np.ascontiguousarray(model.contact_dof), np.ascontiguousarray(model.contact_angle)
    n_steps = round(duration / h)
    _integrate(operators, casing, *tips, speeds_hz, h, theta, n_steps, y, since, peaks)
    return peaks


SPEEDS = np.array([33.25, 33.5, 34.0])  # Hz
DAMPED, HALF, REFERENCE = 0.02, 0.01, 0.005  # damping ratios
ALL = 216  # fixed-interface modes: no reduction
KERNEL_STEP, STEPS = 2e-6, (2e-5, 1e-5, 5e-6)  # [s]
LONG_STEPS = {60: 5e-6, ALL: 1e-5}  # [s]
SETTLED, LONG = 0.8, 3.0  # [s]
NUDGE, UNCHANGED, AGREE = 1e-12, 1e-4, 0.01  # of the stiffness; of amplitudes: periodic, agreed
HALF_STEPS = 5e-6, 2.5e-6  # [s]


def kernel_run(n_modes, damping_ratio, speeds_hz, seconds, step=KERNEL_STEP, nudge=0.0):
    """Largest tip displacement by the program (S,) [m] and start for `amplitudes` from there."""
    reduced = earlier_reduced(n_modes)
    scene = reference_scene(
        interface=reduced.interface,
        damping_ratio=damping_ratio,
        scheme="exact_modal",
        step=step,
        steady=SteadyCriteria(first_check=seconds, max_time=seconds),
    )
    modes = mistuned_modes(reduced, nudge * np.linspace(-1.0, 1.0, reduced.interface.n_blades))
    motion = Motion.at_rest(len(speeds_hz), len(modes.omega))
    result = run_sweep(modes, scene, speeds_hz, width=WIDTH, motion=motion)
    u, v = (modes.shapes @ values.T for values in (motion.position, motion.velocity))
    return result.amplitude, (u, v, motion.time)


def _model(n_modes):
    return earlier_disk() if n_modes == ALL else of_reduced(earlier_reduced(n_modes))


def _pair(n_modes, damping_ratio, seconds):
    """Kernel's amplitudes at SPEEDS and their relative change by a nudge, (S,) each."""
    how = n_modes, damping_ratio, SPEEDS, seconds
    plain, nudged = (kernel_run(*how, nudge=nudge)[0] for nudge in (0.0, NUDGE))
    return plain, np.abs(nudged / plain - 1.0)


def section(_folder):
    """Parts of the page, and verdicts."""
    parts, verdicts = {}, []
    for make in (_damped, _reference, _half):
        parts[make.__name__.strip("_")], found = make()
        verdicts += found
    return parts, verdicts


def _damped():
    head = ["matrices", "speed [Hz]", "kernel", "perturbed"]
    head += [*(f"{1e6 * h:g} µs" for h in STEPS), "difference"]
    rows, verdicts = [], []
    for n_modes in (60, ALL):
        kernel, change = _pair(n_modes, DAMPED, SETTLED)
        how = _model(n_modes), DAMPED, Wall(), SPEEDS
        other = np.array([amplitudes(*how, h, SETTLED)[1] for h in STEPS])
        every = other / kernel - 1.0
        off, rms = every[-1], np.sqrt(np.mean(every**2, axis=1))
        for s, speed in enumerate(SPEEDS):
            row = [f"η = {n_modes}", f"{speed:g}", f"{1e3 * kernel[s]:.3f}", f"{change[s]:.0e}"]
            rows.append([*row, *(f"{1e3 * a[s]:.3f}" for a in other), f"{100.0 * off[s]:+.2f} %"])
        order = f"**order {report.fitted_order(STEPS, rms):.2f}**"
        row = [f"η = {n_modes}", "rms difference", "", ""]
        rows.append([*row, *(f"{100.0 * x:.2f} %" for x in rms), order])
        what = f"damping 2 %, η = {n_modes}"
        verdicts += [
            report.at_most(f"{what}, change by the perturbation", change.max(), UNCHANGED),
            report.at_most(f"{what}, difference of the programs", np.abs(off).max(), AGREE),
        ]
    return report.table(head, rows), verdicts


def _reference():
    rows, verdicts = [], []
    for n_modes in (60, ALL):
        kernel, change = _pair(n_modes, REFERENCE, LONG)
        how = _model(n_modes), REFERENCE, Wall(), SPEEDS[:2]
        other = amplitudes(*how, LONG_STEPS[n_modes], LONG)
        for s, speed in enumerate(SPEEDS[:2]):
            off = other[1, s] / kernel[s] - 1.0
            cells = [f"{1e3 * kernel[s]:.2f}", f"{change[s]:.0e}"]
            cells += [" / ".join(f"{1e3 * a:.2f}" for a in other[:, s]), f"{100.0 * off:+.1f} %"]
            rows.append([f"η = {n_modes}", f"{speed:g}", *cells])
            if (n_modes, speed) == (60, 33.5):
                what = "damping 0.5 %, η = 60, 33.5 Hz, difference of the programs"
                verdicts.append(report.at_most(what, abs(off), AGREE))
    head = ["matrices", "speed [Hz]", "kernel", "perturbed", "independent", "difference"]
    return report.table(head, rows), verdicts


def _half():
    kernel, start = kernel_run(60, HALF, SPEEDS, LONG, 1e-6)
    coarse, fine = (amplitudes(_model(60), HALF, Wall(), SPEEDS, h, SETTLED, start=start)[1]
                    for h in HALF_STEPS)  # fmt: skip
    limit = 2.0 * fine - coarse
    off, found = limit / kernel - 1.0, 1e3 * np.transpose([kernel, coarse, fine, limit])
    rows = [[f"{speed:g}", *(f"{mm:.2f}" for mm in row), f"{100.0 * away:+.1f} %"]
            for speed, row, away in zip(SPEEDS, found, off, strict=True)]  # fmt: skip
    head = ["speed [Hz]", "kernel, 1 µs", *(f"{1e6 * h:g} µs" for h in HALF_STEPS)]
    head += ["extrapolated", "difference"]
    what = "damping 1 %, η = 60, difference of the programs, extrapolated"
    return report.table(head, rows), [report.at_most(what, np.abs(off).max(), AGREE)]
