"""A cantilever whose tip hits a rigid stop: modes, step and impacts against exact segments.

Steel beam of the project's elements, bent away from the stop by a force at its tip and released;
every mode has the same damping ratio. The reference, `evidence.truth.events`, moves each mode
exactly and locates impacts and releases to rounding. With a fixed number of modes the contact point
has the mass 1/(R·R): it is stopped inelastically (e = 0), stays while it is pressed, and leaves.
More modes mean less mass at the contact point and less energy lost: the beam's own limit is reached
by adding modes, the modal model's by reducing the step.
"""

import numpy as np
from scipy.linalg import eigh

from evidence.truth.chain import assemble
from evidence.truth.events import Reference, fixed_wall
from evidence.truth.motion import Structure, make_bank, start_free, trace, wall
from evidence.validation import report
from hpcrub.model.elements import frame_element, rectangular_beam

LENGTH, WIDTH, THICKNESS = 0.5, 0.02, 5e-3  # [m]
N_ELEMENTS = 24
DAMPING_RATIO = 0.005
GAP, PULLED = 1e-3, 10e-3  # stop from the beam at rest, tip when released [m]
DURATION = 0.15  # [s], two periods of the first mode: 16.7 Hz


def beam(n_modes):
    """The first modes of the cantilever: Structure, start q, q̇."""
    section = rectangular_beam(WIDTH, THICKNESS, 2.1e11, 7800.0)
    bending = np.ix_([1, 2, 4, 5], [1, 2, 4, 5])
    element = [part[bending] for part in frame_element(section, LENGTH / N_ELEMENTS)]
    M, K = assemble(element, N_ELEMENTS)[:, 2:, 2:]
    eigenvalues, shapes = eigh(K, M, subset_by_index=[0, n_modes - 1])
    tip = shapes[-2]
    bent = np.linalg.solve(K, np.eye(len(K))[-2])
    q = shapes.T @ M @ bent * (-PULLED / bent[-2])
    structure = Structure(np.sqrt(eigenvalues), tip, tip, DAMPING_RATIO, 0.0)
    return structure, q, np.zeros(n_modes)


def reference(n_modes, n_steps):
    """Exact Motion of n_modes over DURATION."""
    structure, q, v = beam(n_modes)
    return Reference(structure, fixed_wall(GAP), DURATION / n_steps).run(q, v, n_steps)


def computed(n_modes, scheme_name, n_steps, n_records):
    """Tip displacement by the kernel at n_records + 1 even times (divides n_steps) of DURATION."""
    structure, q, v = beam(n_modes)
    step, every = DURATION / n_steps, n_steps // n_records
    bank = make_bank(structure, wall(structure, GAP, scheme=scheme_name), [step])
    start_free(bank, structure, q, v, [step])
    return trace(bank, n_steps, structure.radial[None]).displacement[::every, 0, 0]


def step_errors(n_modes, scheme_name, divisions):
    """Root mean square error of the tip over DURATION relative to its start, for each division."""
    n = min(divisions)
    tip = _tip(n_modes, n)[1]
    return np.array([_rms(computed(n_modes, scheme_name, d, n) - tip) for d in divisions])


def _rms(off):
    return np.sqrt(np.mean(off**2)) / PULLED


SIZES = {2: 400, 4: 51200, 8: 6400}  # modes: fewest steps
MODES, FINEST_MODES = np.array([1, 2, 4, 8, 12, 16]), 32
FINEST_ERROR = 1e-3  # allowed at the finest step
MODE_STEPS = 25600  # over DURATION, of the comparison in modes


def section(folder):
    """Parts of the page, and verdicts; figures go to ``folder``."""
    parts, verdicts = [], []
    for n_modes, fewest in SIZES.items():
        divisions = fewest * 2 ** np.arange(5)
        steps = DURATION / divisions
        columns = {f"`{name}`": step_errors(n_modes, name, divisions) for name in report.SCHEMES}
        labels = "h", [f"{h:.3g} s" for h in steps]
        impacts = len(reference(n_modes, fewest).impacts)
        parts += [
            f"{n_modes} modes, {impacts} impacts:",
            report.order_table(labels, steps, columns),
        ]
        for name, error in columns.items():
            what, finest = f"{n_modes} modes, {name}", ("finest step", FINEST_ERROR)
            verdicts += report.falling(what, steps, error, finest, 0.7)
    table, found = _modes_table()
    _figure(folder)
    return {"errors": "\n\n".join(parts), "modes": table}, verdicts + found


def _tip(n_modes, n_steps):
    motion = reference(n_modes, n_steps)
    return motion, motion.position @ beam(n_modes)[0].radial


def mode_errors(modes, finest, n_steps):
    """Distance of the tip with ``modes`` from the event-driven motion of ``finest`` modes.

    Returns that of the event-driven motions and that of the kernel, (n,) each.
    """
    exact = _tip(finest, n_steps)[1]
    by_events = [_rms(_tip(n, n_steps)[1] - exact) for n in modes]
    by_kernel = [_rms(computed(n, "exact_modal", n_steps, n_steps) - exact) for n in modes]
    return np.array(by_events), np.array(by_kernel)


def _modes_table():
    errors = np.array(mode_errors(MODES, FINEST_MODES, MODE_STEPS))
    names, rows = ("off, events", "off, kernel"), []
    for n, off in zip(MODES, errors.T, strict=True):
        motion, R = reference(n, MODE_STEPS), beam(n)[0].radial
        rows.append([n, 1e3 / (R @ R), len(motion.impacts), 1e3 * motion.lost, *off])
    verdicts = [report.order(f"modes, {what}", 1.0 / MODES, e, 1.0)
                for what, e in zip(names, errors, strict=True)]  # fmt: skip
    rows.append(["**fitted order**", "", "", "", *(f"**{v.value:.2f}**" for v in verdicts)])
    heads = ["modes", "mass at the contact point [g]", "impacts", "lost [mJ]", *names]
    return report.table(heads, rows), verdicts


def _figure(folder):
    figure, ax = report.axes()
    n = 12800
    t = 1e3 * np.linspace(0.0, DURATION, n + 1)
    ax.axhline(1e3 * GAP, color="0.6", lw=4, label="stop")
    for n_modes in (1, 2, 8):
        label = f"kernel, {n_modes} mode{'s' * (n_modes > 1)}"
        ax.plot(t, 1e3 * computed(n_modes, "exact_modal", n, n), label=label)
        ax.plot(t, 1e3 * _tip(n_modes, n)[1], "k:", lw=1.6)
    ax.plot([], [], "k:", label="event-driven")
    ax.set(xlabel="time [ms]", ylabel="tip [mm]")
    ax.legend(ncols=2)
    report.save(figure, folder, "cantilever")
