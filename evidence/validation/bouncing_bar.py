"""An elastic bar that bounces on a rigid floor under gravity: exact and periodic.

Benchmark of Doyen, Ern and Piperno (2011), SIAM J. Sci. Comput. 33, 223–249; here c = √(E/ρ) = 30,
dropped undeformed from h₀ = 5 at g = 10. The fall takes τ_f = 1, a wave runs up
and down the bar in τ = 2L/c = 2/3. u is the displacement from the undeformed bar on the floor, s
the time since the last event, v₀ = g τ_f. By d'Alembert's formula,

    contact 1   u = −v₀ min(s, τ − s, x/c) + a(x, s)    pressure E(v₀ + g s)/c, for 0 ≤ s ≤ τ,
                a = g/2 [(s − x/c)₊² + (s − τ + x/c)₊² − s²],
    flight 1    u = v₀ s − g s²/2 + [U(x − cs) + U(x + cs)]/2,  U = a(x, τ), even, of period cτ,
    contact 2   as contact 1 with a(x, τ − s)            pressure E(v₀ + g(τ − s))/c,
    flight 2    u = v₀ s − g s²/2.

Both flights last 2τ_f, and as this is 3τ the bar lands as it left, deformed after flight 1. The
pattern repeats after 2(τ + 2τ_f), without loss: whatever energy the computed bar loses is error.
"""

import numpy as np
from scipy.linalg import eigh

from evidence.truth.chain import assemble
from evidence.truth.energy import audit
from evidence.truth.motion import Structure, make_bank, trace, wall
from evidence.validation import report
from hpcrub.model.elements import Beam, frame_element

E, RHO, LENGTH, HEIGHT, GRAVITY = 900.0, 1.0, 10.0, 5.0, 10.0  # section area 1
C = np.sqrt(E / RHO)
TAU, FALL = 2.0 * LENGTH / C, np.sqrt(2.0 * HEIGHT / GRAVITY)
V0 = GRAVITY * FALL
CYCLE = 2.0 * (TAU + 2.0 * FALL)
PERIOD, TEN_BOUNCES = FALL + CYCLE, FALL + 5.0 * CYCLE  # until two and ten bounces are over
# scheme, lumped mass, step over the critical one, meshes
SERIES = (
    ("central_difference", False, 0.5, (20, 40, 80, 160)),
    ("exact_modal", False, 0.5, (20, 40, 80, 160)),
    ("central_difference", True, 0.98, (40, 80, 160, 320, 640)),
    ("exact_modal", True, 0.98, (40, 80, 160, 320)),
)
AFTER = {  # times at which that many exact bounces are over
    "one bounce": FALL + TAU + FALL, "two bounces": PERIOD, "five bounces": FALL + 2.5 * CYCLE,
    "ten bounces": TEN_BOUNCES,
}  # fmt: skip
SMOOTH = 0.05  # [s] of the running mean of the pressure, TAU / 13


def bar(n_elements, lumped=False):
    """Modes of the free bar: Structure with its foot as the contact point, and modal gravity.

    lumped: sum the rows of the elements' mass matrix on its diagonal.
    """
    element = frame_element(Beam(E, 1.0, RHO), LENGTH / n_elements)
    M, K = assemble([part[np.ix_([0, 3], [0, 3])] for part in element], n_elements)
    if lumped:
        M = np.diag(M.sum(axis=1))
    eigenvalues, shapes = eigh(K, M)
    eigenvalues[0] = 0.0  # the rigid mode; eigh leaves rounding
    foot = shapes[0]
    weight = -GRAVITY * shapes.T @ M.sum(axis=1)
    structure = Structure(np.sqrt(eigenvalues), -foot, foot, 0.0, 0.0)
    return structure, weight


def exact(x, t):
    """Displacement and velocity at places x and times t, and the pressure on the floor at t.

    x, t broadcast against each other [m], [s]. Returns three arrays.
    """
    x, t = np.asarray(x, float), np.asarray(t, float)
    r = np.mod(t - FALL, CYCLE)
    fall = t < FALL
    second = r >= CYCLE / 2.0
    s = np.where(second, r - CYCLE / 2.0, r)
    contact = s < TAU
    u_c, v_c, p_c = _contact(x, s, second)
    s_f = s - TAU
    # free vibration of the bar that leaves the floor deformed
    ahead, behind = np.mod(x / C + s_f, TAU), np.mod(x / C - s_f, TAU)
    vib = GRAVITY / 2.0 * (ahead * (ahead - TAU) + behind * (behind - TAU))
    vib_rate = GRAVITY / 2.0 * ((2.0 * ahead - TAU) - (2.0 * behind - TAU))
    u_f = V0 * s_f - GRAVITY * s_f**2 / 2.0 + np.where(second, 0.0, vib)
    v_f = V0 - GRAVITY * s_f + np.where(second, 0.0, vib_rate)
    u = np.where(fall, HEIGHT - GRAVITY * t**2 / 2.0, np.where(contact, u_c, u_f))
    v = np.where(fall, -GRAVITY * t, np.where(contact, v_c, v_f))
    pressure = np.where(fall | ~contact, 0.0, p_c)
    return u, v, pressure


def _contact(x, s, second):
    """Displacement, velocity and pressure while the bar is on the floor."""
    up, down = np.minimum(s, x / C), TAU - s
    u = -V0 * np.minimum(up, down)
    v = np.where(s < np.minimum(down, x / C), -V0, np.where(down < up, V0, 0.0))
    r = np.where(second, TAU - s, s)
    rise, back = np.maximum(r - x / C, 0.0), np.maximum(r - TAU + x / C, 0.0)
    a = GRAVITY / 2.0 * (rise**2 + back**2 - r**2)
    rate = GRAVITY * (rise + back - r)
    return u + a, v + np.where(second, -rate, rate), E / C * (V0 + GRAVITY * r)


def critical_step(n_elements, lumped=False):
    """Largest stable step of central differences [s]."""
    crossing = LENGTH / n_elements / C
    return crossing if lumped else crossing / np.sqrt(3.0)


def falling_bank(n_elements, scheme_name, step, lumped=False):
    """A bar at rest above the floor, and its Structure."""
    structure, weight = bar(n_elements, lumped)
    bank = make_bank(structure, wall(structure, HEIGHT, scheme=scheme_name), [step])
    bank = bank._replace(scheme=bank.scheme._replace(external=weight[None]))
    # at rest at t = 0: u(−h) = u(h)
    bank.state.increment[:, 0] = -weight * step**2 / 2.0
    return bank, structure


def bounce(n_elements, scheme_name, step, until=TEN_BOUNCES, lumped=False):
    """Times, displacement, velocity (half a step earlier) and pressure of the foot."""
    bank, structure = falling_bank(n_elements, scheme_name, step, lumped)
    result = trace(bank, int(until / step), structure.tangential[None])
    t = step * np.arange(len(result.displacement))
    return t, HEIGHT + result.displacement[:, 0, 0], result.velocity[:, 0, 0], result.force[:, 0]


def errors(motion, until):
    """Relative errors of a `bounce` until some time, by what they are of.

    Displacement and velocity: root mean square; pressure: L1 norm of its running mean over SMOOTH
    seconds; impulse: largest error of the contact impulse so far over that of one bounce.
    """
    t, u, v, force = motion
    step, n = t[1], int(until / t[1])
    u_exact = exact(0.0, t[: n + 1])[0]
    v_exact = exact(0.0, t[1 : n + 1] - step / 2.0)[1]
    pressure = exact(0.0, t[:n])[2]
    impulse = np.cumsum(pressure - force[:n]) * step
    return {
        "displacement": np.sqrt(np.mean((u[: n + 1] - u_exact) ** 2) / np.mean(u_exact**2)),
        "velocity": np.sqrt(np.mean((v[:n] - v_exact) ** 2) / np.mean(v_exact**2)),
        "pressure": np.abs(_smooth(force[:n] - pressure, step)).sum() / pressure.sum(),
        "impulse": np.abs(impulse).max() / (2.0 * RHO * LENGTH * V0),
    }


def lost_energy(n_elements, scheme_name, step, until=TEN_BOUNCES, lumped=False):
    """Times and energy lost so far, as a share of what the drop has to give."""
    bank, _ = falling_bank(n_elements, scheme_name, step, lumped)
    lost = audit(bank, int(until / step)).impact[:, 0].cumsum()
    lost /= RHO * LENGTH * GRAVITY * HEIGHT
    return step * np.arange(1, len(lost) + 1), lost


def section():
    """Parts of the page, verdicts and the figure."""
    parts, verdicts, curves = [], [], {}
    for name, lumped, ratio, meshes in SERIES:
        case = f"`{name}`, {'lumped' if lumped else 'consistent'} mass"
        size, two, ten, losses = 1.0 / np.array(meshes), [], [], []
        for n in meshes:
            step = ratio * critical_step(n, lumped)
            motion = bounce(n, name, step, lumped=lumped)
            energy_lost = lost_energy(n, name, step, lumped=lumped)
            two.append(errors(motion, PERIOD))
            ten.append(errors(motion, TEN_BOUNCES))
            losses.append({after: np.interp(t, *energy_lost) for after, t in AFTER.items()})
            curves[name, lumped, n] = motion, energy_lost
        tables = (
            ("over two bounces", _columns(two)),
            ("over ten bounces", _columns(ten)),
            ("share of the energy lost", _columns(losses)),
        )
        parts.append(f"{case}, h = {ratio} of the critical step of its mass matrix;")
        for what, columns in tables:
            parts += [f"{what}:", report.order_table(("elements", meshes), size, columns)]
        verdicts += _verdicts(case, lumped, size, *(columns for _, columns in tables))
    _figure(curves)
    return {"errors": "\n\n".join(parts)}, verdicts


def _columns(rows):
    return {what: np.array([row[what] for row in rows]) for what in rows[0]}


def _verdicts(case, lumped, size, two, ten, losses):
    carried = lumped and "central" in case  # fronts, without dispersion
    displacement, velocity = (1.0, 0.5) if carried else (2.0 / 3.0, 1.0 / 3.0)
    verdicts = [
        report.order(f"{case}, {what}", size, two[what], order - 0.15, order + 0.15)
        for what, order in (("displacement", displacement), ("velocity", velocity))
    ]
    verdicts += [
        report.order(f"{case}, impulse", size, two["impulse"], displacement - 0.15),
        report.order(f"{case}, pressure", size, two["pressure"], velocity - 0.15),
        report.order(f"{case}, lost in ten bounces", size, losses["ten bounces"], 0.8),
    ]
    if carried:
        last = ten["displacement"][-1]
        verdicts.append(report.at_most(f"{case}, displacement over ten bounces", last, 0.1))
    return verdicts


def _figure(curves):
    """One column for each scheme; rows: displacement, velocity, pressure, energy."""
    figure, axes = report.axes(n_rows=4, n_columns=2, sharex=True, sharey="row", figsize=(13, 10))
    t_exact = np.linspace(0.0, TEN_BOUNCES, 4000)
    u_exact, v_exact, p_exact = exact(0.0, t_exact)
    for column, name in zip(axes.T, report.SCHEMES, strict=True):
        for lumped, n in ((False, 160), (True, 80), (True, 320)):
            (t, u, v, force), (t_lost, lost) = curves[name, lumped, n]
            mass = "lumped" if lumped else "consistent"
            column[0].plot(t, u, lw=1.2, label=f"{n} elements, {mass} mass")
            column[1].plot(t[1:], v, lw=0.5)
            column[2].plot(t[1:], _smooth(force, t[1]), lw=0.8)
            column[3].plot(t_lost, 100.0 * (1.0 - lost), lw=1.5)
        for ax, values in zip(column, (u_exact, v_exact, p_exact, 100.0), strict=True):
            ax.plot(t_exact, values + 0.0 * t_exact, "k--", lw=1.0, label="exact")
        column[0].set_title(name)
        column[3].set_xlabel("time [s]")
    labels = ("height of the foot [m]", "its velocity [m/s]", "pressure [Pa],\nmean over 0.05 s",
              "energy [%]")  # fmt: skip
    for ax, label in zip(axes[:, 0], labels, strict=True):
        ax.set_ylabel(label)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), ncols=4, loc="outside upper center")
    report.save(figure, "validation_bouncing_bar")


def _smooth(force, step):
    n = max(1, round(SMOOTH / step))
    return np.convolve(force, np.full(n, 1.0 / n), "same")
