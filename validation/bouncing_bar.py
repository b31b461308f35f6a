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

from hpcrub import energy
from hpcrub.elements import Beam, frame_element
from validation import report
from validation.motion import Structure, make_bank, trace

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
HEAD = ("displacement", "velocity", "impulse", "displacement, ten bounces", "energy lost in ten")
TEXT = """## Bouncing bar

Benchmark of Doyen, Ern and Piperno (2011): an elastic bar of the project's axial elements, all its
modes and the rigid one, falls on a rigid floor. The exact motion is periodic and loses nothing
(`validation/bouncing_bar.py` derives it). Errors of the foot over the first period (fall and two
bounces) and over ten bounces, root mean square relative to that of the exact solution; impulse:
largest error of the contact impulse so far, relative to that of one bounce."""
ORDER_TEXT = """The exact velocity jumps, along the bar and in time. With a consistent mass the
elements disperse these fronts, which limits the order (2/3 in displacement and 1/3 in velocity, as
for free waves) and leaves vibrations that make the later impacts early and repeated. With a lumped
mass near its critical step central differences carry a front almost exactly, and the order in
displacement and impulse is one. What remains is the impact: the foot of the discrete bar has a
mass, 0.29 ρΔx (consistent) or 0.5 ρΔx (lumped), whose kinetic energy each impact takes (e = 0).
Less height makes shorter flights, so the bar gets out of phase; over ten bounces that adds up. The
pressure oscillates about the exact one on the mesh scale, as published for schemes that enforce the
contact condition exactly; the figure shows a running mean."""
STEP_TEXT = """The mesh makes the error, not the step (80 elements, consistent mass, displacement
over the first period):"""


def bar(n_elements, lumped=False):
    """Modes of the free bar: Structure with its foot as the contact point, and modal gravity.

    lumped: sum the rows of the elements' mass matrix on its diagonal.
    """
    m, k = frame_element(Beam(E, 1.0, RHO), LENGTH / n_elements)
    n = n_elements + 1
    M, K = np.zeros((n, n)), np.zeros((n, n))
    for e in range(n_elements):
        M[e : e + 2, e : e + 2] += m[np.ix_([0, 3], [0, 3])]
        K[e : e + 2, e : e + 2] += k[np.ix_([0, 3], [0, 3])]
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
    vib, vib_rate = _vibration(x, s_f)
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


def _vibration(x, s):
    """Free vibration of the bar that leaves the floor deformed, and its rate."""
    ahead, behind = np.mod(x / C + s, TAU), np.mod(x / C - s, TAU)
    u = GRAVITY / 2.0 * (ahead * (ahead - TAU) + behind * (behind - TAU))
    return u, GRAVITY / 2.0 * ((2.0 * ahead - TAU) - (2.0 * behind - TAU))


def critical_step(n_elements, lumped=False):
    """Largest stable step of central differences [s]."""
    crossing = LENGTH / n_elements / C
    return crossing if lumped else crossing / np.sqrt(3.0)


def falling_bank(n_elements, scheme_name, step, n_rows=1, lumped=False):
    """A bar at rest above the floor, and its Structure."""
    structure, weight = bar(n_elements, lumped)
    bank = make_bank(structure, scheme_name, [step], HEIGHT, n_rows)
    bank = bank._replace(scheme=bank.scheme._replace(external=np.tile(weight, (n_rows, 1))))
    # at rest at t = 0: u(−h) = u(h)
    bank.state.increment[:, 0] = -weight * step**2 / 2.0
    return bank, structure


def bounce(n_elements, scheme_name, step, until=TEN_BOUNCES, lumped=False):
    """Times, displacement, velocity (half a step earlier) and pressure of the foot."""
    bank, structure = falling_bank(n_elements, scheme_name, step, lumped=lumped)
    result = trace(bank, int(until / step), structure.tangential[None])
    t = step * np.arange(len(result.displacement))
    return t, HEIGHT + result.displacement[:, 0, 0], result.velocity[:, 0, 0], result.force[:, 0]


def errors(motion, until):
    """Relative errors of a `bounce` until some time.

    Displacement and velocity: root mean square over that of the exact one. Impulse: largest error
    of the contact impulse so far over that of one bounce.
    """
    t, u, v, force = motion
    step, n = t[1], int(until / t[1])
    u_exact = exact(0.0, t[: n + 1])[0]
    v_exact = exact(0.0, t[1 : n + 1] - step / 2.0)[1]
    impulse = np.cumsum(exact(0.0, t[:n])[2] - force[:n]) * step
    return (
        np.sqrt(np.mean((u[: n + 1] - u_exact) ** 2) / np.mean(u_exact**2)),
        np.sqrt(np.mean((v[:n] - v_exact) ** 2) / np.mean(v_exact**2)),
        np.abs(impulse).max() / (2.0 * RHO * LENGTH * V0),
    )


def lost_energy(n_elements, scheme_name, step, until=TEN_BOUNCES, lumped=False):
    """Times and energy lost so far, as a share of what the drop has to give."""
    bank, _ = falling_bank(n_elements, scheme_name, step, lumped=lumped)
    books = energy.audit(bank, int(until / step))
    lost = np.cumsum(books.work[:, energy.IMPACT, 0]) / (RHO * LENGTH * GRAVITY * HEIGHT)
    return step * np.arange(1, len(lost) + 1), lost


def section(folder):
    """Markdown of this case; figures go to ``folder``."""
    parts = [TEXT]
    for name, lumped, ratio, meshes in SERIES:
        rows = []
        for n in meshes:
            step = ratio * critical_step(n, lumped)
            motion = bounce(n, name, step, lumped=lumped)
            lost = lost_energy(n, name, step, lumped=lumped)[1][-1]
            rows.append((*errors(motion, PERIOD), errors(motion, TEN_BOUNCES)[0], lost))
        size = 1.0 / np.array(meshes)
        columns = dict(zip(HEAD, np.array(rows).T, strict=True))
        mass = "lumped" if lumped else "consistent"
        parts.append(f"`{name}`, {mass} mass, h = {ratio} of the critical step of its mass matrix:")
        parts.append(report.order_table(("elements", meshes), size, columns))
    parts += [ORDER_TEXT, STEP_TEXT, _step_table(), _figure(folder)]
    return "\n\n".join(parts)


def _step_table():
    names = ("central_difference", "exact_modal")
    rows = []
    for ratio in (0.9, 0.5, 0.25, 0.1):
        step = ratio * critical_step(80)
        off = [errors(bounce(80, name, step, PERIOD), PERIOD)[0] for name in names]
        rows.append([f"{ratio}", *map(float, off)])
    return report.table(["h / critical step", *(f"`{name}`" for name in names)], rows)


def _figure(folder):
    figure, (above, middle, below) = report.axes(n_rows=3, sharex=True, figsize=(9, 8.5))
    for n in (80, 320, 640):
        step = 0.98 * critical_step(n, lumped=True)
        t, u, _, force = bounce(n, "central_difference", step, lumped=True)
        above.plot(t, u, lw=1.2, label=f"{n} elements")
        middle.plot(t[1:], _smooth(force, step), lw=1.0)
        t, lost = lost_energy(n, "central_difference", step, lumped=True)
        below.plot(t, 100.0 * (1.0 - lost), lw=1.5)
    t = np.linspace(0.0, TEN_BOUNCES, 4000)
    u, _, pressure = exact(0.0, t)
    above.plot(t, u, "k--", lw=1.0, label="exact")
    middle.plot(t, pressure, "k--", lw=1.0)
    below.axhline(100.0, color="k", ls="--", lw=1.0)
    above.set_ylabel("height of the foot [m]")
    middle.set_ylabel("pressure [Pa],\nmean over 0.05 s")
    below.set_ylabel("energy [%]")
    below.set_xlabel("time [s]")
    above.legend(ncols=4, loc="upper center", bbox_to_anchor=(0.5, 1.25), frameon=False)
    return report.save(figure, folder, "bouncing_bar")


def _smooth(force, step):
    n = max(1, round(0.05 / step))
    return np.convolve(force, np.full(n, 1.0 / n), "same")
