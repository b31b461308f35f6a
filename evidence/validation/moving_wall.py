"""A mass and a wall that moves: every impact, contact and release against exact segments.

A mass of 1 kg in the plane on two springs whose axes lean by 30° against the wall's normal, so that
friction, which pushes along the wall, also acts on the motion towards it. The wall moves along its
normal as a sinusoid. It is given to the kernel as the table of bump heights. The reference is
`evidence.truth.events`.
"""

import numpy as np

from evidence.truth.events import Reference, Wall
from evidence.truth.motion import Structure, make_bank, start_free, trace
from evidence.truth.motion import wall as still
from evidence.validation import report

DURATION = 1.0  # [s]
OMEGA = 2.0 * np.pi * np.array([4.0, 7.0])
LEAN = np.radians(30.0)
DAMPING_RATIO = 0.02
START = np.zeros(2), np.array([1.0, -0.5])  # q [m √kg], q̇
WALL = Wall(mean=0.10, amplitude=0.15, nu=2.0 * np.pi * 3.0)


def structure(friction):
    """The mass on its springs."""
    c, s = np.cos(LEAN), np.sin(LEAN)
    return Structure(OMEGA, np.array([c, s]), np.array([-s, c]), DAMPING_RATIO, friction)


def reference(friction, n_steps):
    """Exact Motion, n_steps outputs over DURATION."""
    return Reference(structure(friction), WALL).run(*START, DURATION / n_steps, n_steps)


def computed(friction, scheme_name, n_steps):
    """Trace of q over DURATION by the kernel."""
    h, mass = DURATION / n_steps, structure(friction)
    bank = make_bank(mass, still(mass, WALL.mean, scheme=scheme_name), [h], n_steps)
    bank.scheme.bump[:, 0] = WALL.mean - WALL.place(h * (1.0 + np.arange(n_steps)))
    start_free(bank, mass, *START, [h])
    return trace(bank, n_steps, np.eye(2))


def errors(exact, friction, scheme_name, n_steps):
    """Errors of the kernel, relative to the largest displacement and to the impulse.

    exact: Motion with a whole multiple of n_steps outputs. Returns the root mean square error of
    the motion towards the wall and along it and the error of the impulse over all contacts.
    """
    run = computed(friction, scheme_name, n_steps)
    mass = structure(friction)
    u = np.array([mass.radial, mass.tangential])
    every = (len(exact.position) - 1) // n_steps
    u_exact = exact.position[::every] @ u.T
    off = run.displacement[:, :, 0] @ u.T - u_exact
    rms = np.sqrt(np.mean(off**2, axis=0)) / np.abs(u_exact).max(axis=0)
    impulse = run.force[:, 0].sum() * DURATION / n_steps
    return *rms, abs(impulse / exact.impulse[-1] - 1.0)


DIVISIONS = np.array([500, 1000, 2000, 4000, 8000, 16000])
SEGMENT = 1e-12  # largest error allowed of a closed-form segment between events, relative
ORDERS, FINEST = (0.7, 1.3), 1e-3  # of the fitted orders, and the error at the finest step


def section():
    """Parts of the page, verdicts and the figure."""
    coarse, fine = (reference(0.4, n).position for n in (500, 2000))
    apart = np.abs(coarse - fine[::4]).max() / np.abs(fine).max()
    parts = []
    verdicts = [
        report.at_most("reference at two of its own steps", apart, SEGMENT),
    ]
    for friction in (0.0, 0.4):
        exact = reference(friction, DIVISIONS[-1])
        columns = {}
        for name in report.SCHEMES:
            rows = np.array([errors(exact, friction, name, n) for n in DIVISIONS])
            for what, error in zip(("normal", "tangential", "impulse"), rows.T, strict=True):
                columns[f"`{name.partition('_')[0]}` {what}"] = error
        labels = "h", [f"{DURATION / n:.3g} s" for n in DIVISIONS]
        parts += [f"friction {friction}; {len(exact.impacts)} impacts:",
                  report.order_table(labels, DURATION / DIVISIONS, columns)]  # fmt: skip
        verdicts += _verdicts(f"friction {friction}", columns)
    _figure()
    return {"errors": "\n\n".join(parts)}, verdicts


def _verdicts(case, columns):
    """The worst of the columns: order one, as theory has it, and the error at the finest step."""
    orders = {what: report.fitted_order(DURATION / DIVISIONS, e) for what, e in columns.items()}
    worst = max(orders, key=lambda what: abs(orders[what] - 1.0))
    finest = max(error[-1] for error in columns.values())
    return [
        report.Verdict(f"{case}, order farthest from 1 ({worst})", orders[worst], *ORDERS),
        report.at_most(f"{case}, largest error at the finest step", finest, FINEST),
    ]


def _figure():
    figure, ax = report.axes()
    t, mass = np.linspace(0.0, DURATION, 1001), structure(0.4)
    exact = reference(0.4, 1000).position
    run = computed(0.4, "central_difference", 1000).displacement[:, :, 0]
    ax.plot(t, WALL.place(t), color="0.6", lw=4, label="wall")
    for direction, name in ((mass.radial, "normal"), (mass.tangential, "tangential")):
        ax.plot(t, run @ direction, lw=1.8, label=f"{name}, h = 1 ms")
        ax.plot(t, exact @ direction, "k:", lw=1.6)
    ax.plot([], [], "k:", label="exact")
    ax.set(title="friction 0.4", xlabel="time [s]", ylabel="displacement [m]")
    figure.legend(*ax.get_legend_handles_labels(), ncols=4, loc="outside upper center")
    report.save(figure, "validation_moving_wall")
