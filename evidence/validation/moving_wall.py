"""A mass and a wall that moves: every impact, contact and release against exact segments.

A mass of 1 kg in the plane on two springs whose axes lean by 30° against the wall's normal, so that
friction, which pushes along the wall, also acts on the motion towards it. The wall moves along its
normal, as a sinusoid or with the program's own bump (a Gaussian in time). It is given to the
kernel as the table of bump heights. The reference is `evidence.truth.events`.
"""

import numpy as np

from evidence.truth.events import Reference, Wall
from evidence.truth.motion import Structure, free_motion, make_bank, start_free, trace
from evidence.truth.motion import wall as still
from evidence.validation import report
from hpcrub.model import casing

DURATION = 1.0  # [s]
OMEGA = 2.0 * np.pi * np.array([4.0, 7.0])
LEAN = np.radians(30.0)
DAMPING_RATIO = 0.02
START = np.zeros(2), np.array([1.0, -0.5])  # q [m √kg], q̇
SINUSOID = 0.10, 0.15, 2.0 * np.pi * 3.0  # mean distance, amplitude [m], [rad/s]
CLEARANCE, BUMP, N_BUMPS = 0.15, 0.25, 2  # two bumps pass in DURATION


def structure(friction):
    """The mass on its springs."""
    c, s = np.cos(LEAN), np.sin(LEAN)
    return Structure(OMEGA, np.array([c, s]), np.array([-s, c]), DAMPING_RATIO, friction)


def sinusoidal_wall():
    """w(t) = mean + amplitude cos νt."""
    mean, a, nu = SINUSOID
    return Wall(
        lambda t: mean + a * np.cos(nu * t),
        lambda t: -a * nu * np.sin(nu * t),
        lambda t: -a * nu**2 * np.cos(nu * t),
    )


def gaussian_wall():
    """The casing of `hpcrub.casing` that turns once in DURATION, and its derivatives."""
    pitch = 2.0 * np.pi / N_BUMPS
    width, rate = 0.1 * pitch, 2.0 * np.pi / DURATION

    def phi(t):
        turned = rate * t + pitch / 2.0
        return (turned - pitch * np.round(turned / pitch)) / width

    scale = rate / width

    def bump(t):
        return BUMP * np.exp(-(phi(t) ** 2))

    return Wall(
        lambda t: CLEARANCE - casing.bump_height(rate * t + pitch / 2.0, N_BUMPS, BUMP),
        lambda t: 2.0 * phi(t) * scale * bump(t),
        lambda t: (2.0 - 4.0 * phi(t) ** 2) * scale**2 * bump(t),
    )


WALLS = {"sinusoidal": sinusoidal_wall, "Gaussian": gaussian_wall}


def reference(wall, friction, n_steps):
    """Exact Motion, n_steps outputs over DURATION."""
    return Reference(structure(friction), WALLS[wall](), DURATION / n_steps).run(*START, n_steps)


def computed(wall, friction, scheme_name, n_steps):
    """Trace of q over DURATION by the kernel."""
    h, mass = DURATION / n_steps, structure(friction)
    bank = make_bank(mass, still(mass, CLEARANCE, scheme=scheme_name), [h], n_steps)
    t = h * (1.0 + np.arange(n_steps))
    bank.scheme.bump[:, 0] = CLEARANCE - WALLS[wall]().place(t)
    start_free(bank, mass, *START, [h])
    return trace(bank, n_steps, np.eye(2))


def errors(exact, wall, friction, scheme_name, n_steps):
    """Errors of the kernel, relative to the largest displacement and to the impulse.

    exact: Motion with a whole multiple of n_steps outputs. Returns the root mean square error of
    the motion towards the wall and along it and the error of the impulse over all contacts.
    """
    run = computed(wall, friction, scheme_name, n_steps)
    mass = structure(friction)
    u = np.array([mass.radial, mass.tangential])
    every = (len(exact.position) - 1) // n_steps
    u_exact = exact.position[::every] @ u.T
    off = run.displacement[:, :, 0] @ u.T - u_exact
    rms = np.sqrt(np.mean(off**2, axis=0)) / np.abs(u_exact).max(axis=0)
    impulse = run.force[:, 0].sum() * DURATION / n_steps
    return *rms, abs(impulse / exact.impulse[-1] - 1.0)


def flight_error(wall, name):
    """Largest error of q before the first impact over the largest |q|: the kernel in free motion.

    The reference there is the closed form of `motion.free_motion`.
    """
    h, mass = DURATION / 1000, structure(0.4)
    hit = reference(wall, 0.4, 1000).impacts[0]
    n = int(hit / h)  # the last level before the impact
    exact = np.array([free_motion(mass, *START, h * k) for k in range(n + 1)])
    run = computed(wall, 0.4, name, 1000).displacement[: n + 1, :, 0]
    return np.abs(run - exact).max() / np.abs(exact).max()


def segment_error(wall):
    """Largest difference of the reference at two steps of its own, relative to the largest |q|."""
    coarse, fine = (reference(wall, 0.4, n).position for n in (500, 2000))
    return np.abs(coarse - fine[::4]).max() / np.abs(fine).max()


DIVISIONS = np.array([500, 1000, 2000, 4000, 8000, 16000])
SEGMENT = 1e-12  # largest error allowed of a closed-form segment between events, relative
ORDERS, FINEST = (0.7, 1.3), 1e-3  # of the fitted orders, and the error at the finest step


def section(folder):
    """Parts of the page, and verdicts; figures go to ``folder``."""
    parts, verdicts = [], []
    for wall in WALLS:
        exact_motions = {
            "reference at two of its own steps": segment_error(wall),
            "`exact_modal` until the first impact": flight_error(wall, "exact_modal"),
        }
        verdicts += [report.at_most(f"{wall} wall, {what}", error, SEGMENT)
                     for what, error in exact_motions.items()]  # fmt: skip
        for friction in (0.0, 0.4):
            exact = reference(wall, friction, DIVISIONS[-1])
            columns = {}
            for name in report.SCHEMES:
                rows = np.array([errors(exact, wall, friction, name, n) for n in DIVISIONS])
                for what, error in zip(("normal", "tangential", "impulse"), rows.T, strict=True):
                    columns[f"`{name.partition('_')[0]}` {what}"] = error
            labels = "h", [f"{DURATION / n:.3g} s" for n in DIVISIONS]
            title = f"{wall} wall, friction {friction}; {len(exact.impacts)} impacts:"
            parts += [title, report.order_table(labels, DURATION / DIVISIONS, columns)]
            verdicts += _verdicts(f"{wall} wall, friction {friction}", columns)
    _figure(folder)
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


def _figure(folder):
    figure, axes = report.axes(n_columns=2, figsize=(10, 4.8), sharey=True)
    t = np.linspace(0.0, DURATION, 1001)
    for ax, wall in zip(axes, WALLS, strict=True):
        exact = reference(wall, 0.4, 1000)
        mass = structure(0.4)
        run = computed(wall, 0.4, "central_difference", 1000).displacement[:, :, 0]
        ax.plot(t, WALLS[wall]().place(t), color="0.6", lw=4, label="wall")
        for direction, name in ((mass.radial, "normal"), (mass.tangential, "tangential")):
            ax.plot(t, run @ direction, lw=1.8, label=f"{name}, h = 1 ms")
            ax.plot(t, exact.position @ direction, "k:", lw=1.6)
        ax.plot([], [], "k:", label="exact")
        ax.set(title=f"{wall} wall, friction 0.4", xlabel="time [s]")
    axes[0].set_ylabel("displacement [m]")
    figure.legend(*axes[1].get_legend_handles_labels(), ncols=4, loc="outside upper center")
    report.save(figure, folder, "moving_wall")
