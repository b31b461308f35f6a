"""A cantilever whose tip hits a rigid stop: modes, step and impacts against exact segments.

Steel beam of the project's elements, bent away from the stop by a force at its tip and released;
every mode has the same damping ratio. The reference, `validation.events`, moves each mode exactly
and locates impacts and releases to rounding. With a fixed number of modes the contact point has the
mass 1/(R·R): it is stopped inelastically (e = 0), stays while it is pressed, and leaves. More modes
mean less mass at the contact point and less energy lost: the beam's own limit is reached by adding
modes, the modal model's by reducing the step.
"""

import numpy as np
from scipy.linalg import eigh

from hpcrub.elements import frame_element, rectangular_beam
from validation import report
from validation.events import Reference, fixed_wall
from validation.motion import Structure, make_bank, start_free, trace

LENGTH, WIDTH, THICKNESS = 0.5, 0.02, 5e-3  # [m]
N_ELEMENTS = 24
DAMPING_RATIO = 0.005
GAP, PULLED = 1e-3, 10e-3  # stop from the beam at rest, tip when released [m]
DURATION = 0.15  # [s], two periods of the first mode: 16.7 Hz


def beam(n_modes):
    """The first modes of the cantilever: Structure, start q, q̇."""
    section = rectangular_beam(WIDTH, THICKNESS, 2.1e11, 7800.0)
    m, k = frame_element(section, LENGTH / N_ELEMENTS)
    bending = np.ix_([1, 2, 4, 5], [1, 2, 4, 5])
    n = 2 * N_ELEMENTS + 2
    M, K = np.zeros((n, n)), np.zeros((n, n))
    for e in range(N_ELEMENTS):
        dof = slice(2 * e, 2 * e + 4)
        M[dof, dof] += m[bending]
        K[dof, dof] += k[bending]
    M, K = M[2:, 2:], K[2:, 2:]
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


def computed(n_modes, scheme_name, divisions):
    """Tip displacements by the kernel, one array (n + 1,) for each number of steps.

    divisions: numbers of steps over DURATION, one lane each.
    """
    structure, q, v = beam(n_modes)
    steps = DURATION / np.array(divisions)
    bank = make_bank(structure, scheme_name, steps, GAP)
    start_free(bank, structure, q, v, steps)
    tip = trace(bank, max(divisions), structure.radial[None]).displacement[:, 0]
    return [tip[: n + 1, lane] for lane, n in enumerate(divisions)]


def step_errors(n_modes, scheme_name, divisions):
    """Root mean square error of the tip over DURATION relative to its start, for each division."""
    exact = reference(n_modes, max(divisions))
    tip = exact.position @ beam(n_modes)[0].radial
    return np.array(
        [
            np.sqrt(np.mean((u - tip[:: max(divisions) // n]) ** 2)) / PULLED
            for n, u in zip(divisions, computed(n_modes, scheme_name, divisions), strict=True)
        ]
    )


SIZES = {2: 400, 4: 6400, 8: 6400}  # modes: fewest steps
TEXT = """## Cantilever with a stop

A steel cantilever (500 × 20 × 5 mm, first frequency 16.8 Hz, damping 0.5 %) is bent by 10 mm,
released, and hits a rigid stop. The reference moves all modes exactly between impacts and releases.
On a modal model it needs an impact law: with K modes the contact point has the mass 1/ΣR², which
the kernel brings to the stop's velocity within two steps. So the limit of small steps is the
persistent contact with e = 0, in which the structure moves on the K − 1 modes that leave the tip
still, until λ turns negative. Errors of the tip over 0.15 s, root mean square over 10 mm."""
ORDER_TEXT = """Each impact is up to a step late, but contact that lasts puts the tip back on the
stop and forgets most of that error: the order lies between one and two. With 4 modes the tip leaves
the stop for just 37 µs after the first impact. Where that falls on the grid rules the error, which
falls steadily only below 3 µs; a fitted order means little there."""
MODES_TEXT = """Convergence in modes, by the reference alone: distance of the tip from the motion
of 16 modes. The energy lost in impacts falls with the mass of the contact point, as it must: the
continuous beam has none there."""


def section(folder):
    """Markdown of this case; figures go to ``folder``."""
    parts = [TEXT]
    for n_modes, fewest in SIZES.items():
        divisions = fewest * 2 ** np.arange(5)
        columns = {
            f"`{name}`": step_errors(n_modes, name, divisions)
            for name in ("central_difference", "exact_modal")
        }
        labels = "h", [f"{DURATION / n:.3g} s" for n in divisions]
        impacts = len(reference(n_modes, divisions[-1]).impacts)
        parts += [
            f"{n_modes} modes, {impacts} impacts:",
            report.order_table(labels, DURATION / divisions, columns),
        ]
    parts += [ORDER_TEXT, MODES_TEXT, _modes_table(), _figure(folder)]
    return "\n\n".join(parts)


def _tip(n_modes, n_steps):
    motion = reference(n_modes, n_steps)
    return motion, motion.position @ beam(n_modes)[0].radial


def _modes_table(n_steps=12800):
    finest = _tip(16, n_steps)[1]
    rows = []
    for n_modes in (1, 2, 4, 8, 12):
        motion, tip = _tip(n_modes, n_steps)
        R = beam(n_modes)[0].radial
        off = np.sqrt(np.mean((tip - finest) ** 2)) / PULLED
        rows.append([n_modes, 1e3 / (R @ R), len(motion.impacts), 1e3 * motion.lost, off])
    head = ["modes", "mass at the contact point [g]", "impacts", "lost [mJ]", "off 16 modes"]
    return report.table(head, rows)


def _figure(folder):
    figure, ax = report.axes()
    n = 12800
    t = 1e3 * np.linspace(0.0, DURATION, n + 1)
    ax.axhline(1e3 * GAP, color="0.6", lw=4, label="stop")
    for n_modes in (1, 2, 8):
        ax.plot(
            t,
            1e3 * computed(n_modes, "exact_modal", [n])[0],
            label=f"kernel, {n_modes} mode{'s' * (n_modes > 1)}",
        )
        ax.plot(t, 1e3 * _tip(n_modes, n)[1], "k:", lw=1.6)
    ax.plot([], [], "k:", label="event-driven")
    ax.set_xlabel("time [ms]")
    ax.set_ylabel("tip [mm]")
    ax.legend(ncols=2)
    return report.save(figure, folder, "cantilever")
