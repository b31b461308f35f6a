"""The 12-blade disk without modal coordinates, by an implicit velocity-level scheme.

`evidence.truth.moreau_jean` takes the same finite-element matrices, all 240 dof without
Craig–Bampton reduction, or the reduced ones.
"""

import numpy as np

from evidence.truth.disk import earlier_disk, earlier_reduced, reference_scene
from evidence.truth.moreau_jean import amplitudes, unreduced
from evidence.truth.motion import WIDTH
from evidence.truth.ring import Wall
from evidence.validation import report
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.steady import SteadyCriteria
from hpcrub.response.sweep import Motion, run_sweep

SPEEDS = np.array([33.25, 33.5, 34.0])  # Hz
DAMPED, HALF = 0.02, 0.01  # damping ratios
ALL = 216  # fixed-interface modes: no reduction
KERNEL_STEP, STEPS = 2e-6, (2e-5, 1e-5, 5e-6)  # [s]
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
    return unreduced(earlier_disk()) if n_modes == ALL else earlier_reduced(n_modes)


def _pair(n_modes):
    """Kernel's amplitudes at SPEEDS and their relative change by a nudge, (S,) each."""
    how = n_modes, DAMPED, SPEEDS, SETTLED
    plain, nudged = (kernel_run(*how, nudge=nudge)[0] for nudge in (0.0, NUDGE))
    return plain, np.abs(nudged / plain - 1.0)


def section(_folder):
    """Parts of the page, and verdicts."""
    parts, verdicts = {}, []
    for make in (_damped, _half):
        parts[make.__name__.strip("_")], found = make()
        verdicts += found
    return parts, verdicts


def _damped():
    head = ["matrices", "speed [Hz]", "kernel", "perturbed"]
    head += [*(f"{1e6 * h:g} µs" for h in STEPS), "difference"]
    rows, verdicts = [], []
    for n_modes in (60, ALL):
        kernel, change = _pair(n_modes)
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
