"""Rubbing to second order of the motion, in plain NumPy: the twin of the kernel.

With the modal coordinates q, the amplitudes s = P q of the bent modes of every blade and the rows
N, T, A of a contact point, it moves by

    u_n = N q − ½ sᵀG_n s,   u_t = T q − ½ sᵀG_t s,   u_a = A q − ½ sᵀG_a s,

to the penetration p = u_n + κ u_t²/2 + b(θ + Ωt + u_t/R, t) − clearance. A step takes the
recurrence without contact, with the forces −½ Σ C s s − ⅙ Σ D s s s − ½ Σ J s (s s)¨ of its begin,
the last by the acceleration that the others give; evaluates p and all directions there; and finds
multipliers that end all penetrations, as the gradients there tell. The wall leans by
m = κ u_t + b'/R: forces act along its normal (n + m t)/√(1 + m²), and friction along its tangent
(t − m n)/√(1 + m²), where n, t, a are the gradients of u_n, u_t and u_a. On a planar disk friction
always acts along the tangent; with axial rows it turns with the slip of the step before.

`first` order leaves out κ, G, C, D, J and what turns with u_t; `polar` all but κ and that.
"""

from typing import NamedTuple

import numpy as np

from evidence.truth.ring import bump, forces

ORDERS = "first", "polar", "second"
SMALL = 1e-6  # for the slope of a wall [rad]


class Structure(NamedTuple):
    """K modes of mass one, C contact points and N blades with p bent modes each."""

    omega: np.ndarray  # (K,) [rad/s]
    damping_ratio: np.ndarray  # (K,), or one for all
    normal: np.ndarray  # (C, K) [1/√kg]
    tangential: np.ndarray  # (C, K)
    axial: np.ndarray  # (C, K); (0, K) of a planar structure
    blade: np.ndarray  # (C,) int
    angle: np.ndarray  # (C,) [rad]
    radius: np.ndarray  # (C,) [m]
    bent: np.ndarray  # P (N, p, K)
    shortening: np.ndarray  # G (C, 3, p, p) of normal, tangential and axial motion [1/(m kg)]
    coupling: np.ndarray  # C (p, p, p) [1/(m √kg s²)]
    quartic: np.ndarray  # D (p, p, p, p) [1/(m² kg s²)]
    inertia: np.ndarray  # J (q, q, q, q) of the first q bent modes [1/(m² kg)]
    alone: np.ndarray  # ω of the bent modes (p,) [rad/s]
    curvature: np.ndarray  # κ (C,) [1/m]


class Run(NamedTuple):
    """Motion after every step."""

    position: np.ndarray  # q (n, K)
    place: np.ndarray  # u_n, u_t and u_a of the points (n, C, 3) [m]
    force: np.ndarray  # normal (n, C) [N]


def structure_of(modes, interface, model, damping_ratio):
    """The Structure of hpcrub's Modes of a disk, its Interface and its SecondOrder."""
    known = interface._asdict() | model._asdict() | modes._asdict()
    known |= {"damping_ratio": damping_ratio, "bent": model.participation @ modes.shapes}
    known["alone"] = model.omega
    if not model.quartic.size:
        known["quartic"] = np.zeros((len(model.omega),) * 4)
    return Structure(**{name: known[name] for name in Structure._fields})


def coefficients(scheme, omega, damping_ratio, h):
    """Factors (K,) of the last increment and of a modal force, by the name of a scheme."""
    c = damping_ratio * omega * h
    if scheme == "central_difference":
        return (1.0 - c) / (1.0 + c), h * h / (1.0 + c)
    e = np.exp(-c)
    cosine = np.cos(omega * np.sqrt(1.0 - damping_ratio**2) * h)
    stiff = 1.0 + c + (omega * h) ** 2 / 4.0  # modes that a step cannot follow: trapezoidal rule
    slow = omega * h <= 2.0
    decay = np.where(slow, e * e, (stiff - 2.0 * c) / stiff)
    return decay, np.where(slow, (1.0 - 2.0 * e * cosine + e * e) / omega**2, h * h / stiff)


def resistance(structure, s, d, bending, h):
    """Inertia ½ Σ J s (s s)¨ of blades (N, q).

    s, d, bending: of the bent modes (N, p), d their increments in the step h before.
    """
    n = len(structure.inertia)
    s = s[:, :n]
    a = -(structure.alone[:n] ** 2) * s - bending[:, :n]
    v = d[:, :n] / h + a * h / 2.0
    half = np.einsum("nc,nd->ncd", v, v) + np.einsum("nc,nd->ncd", a, s)
    return np.einsum("nb,abcd,ncd->na", s, structure.inertia, half)


def place(structure, q):
    """Motion of the points (C, 3)."""
    along = structure.normal @ q, structure.tangential @ q
    across = structure.axial @ q if len(structure.axial) else 0.0 * along[0]
    s = (structure.bent @ q)[structure.blade]
    shorter = np.einsum("cdab,ca,cb->cd", structure.shortening, s, s) / 2.0
    return np.stack([*along, across], axis=1) - shorter


def gradients(structure, q):
    """Change of the motion of the points (3, C, K) with q."""
    axial = structure.axial if len(structure.axial) else 0.0 * structure.normal
    first = np.stack([structure.normal, structure.tangential, axial])
    rows = structure.bent[structure.blade]  # (C, p, K)
    turned = np.einsum("cdab,cb->cda", structure.shortening, rows @ q)
    return first - np.einsum("cda,cak->dck", turned, rows)


def met(structure, moved, wall, rotation, t):
    """Penetration without the clearance, and the lean m of the wall (C,); order `first`: no κ."""
    along = moved[:, 1]
    per_motion = (structure.curvature > 0.0) / structure.radius
    theta = structure.angle + rotation + per_motion * along
    around = theta + SMALL * np.array([[-1.0], [0.0], [1.0]])
    below, height, above = bump.py_func(wall, around, t)
    lean = structure.curvature * along
    depth = moved[:, 0] + lean * along / 2.0 + height
    return depth, lean + (above - below) / (2.0 * SMALL) * per_motion


def of_order(structure, order):
    """The structure at one of ORDERS."""
    if order == "second":
        return structure
    still = ["shortening", "coupling", "quartic", "inertia"]
    still += ["curvature"] if order == "first" else []
    return structure._replace(**{name: 0.0 * getattr(structure, name) for name in still})


def directions(structure, gradient, lean, increment, friction, turn):
    """Rows (C, K) that the penetration follows, and those along which a force acts."""
    n, t, a = gradient
    size = np.sqrt(1.0 + lean**2)[:, None]
    normal, tangent = n + lean[:, None] * t, (t - lean[:, None] * n) / size
    if len(structure.axial):
        along, across = structure.radius * turn + tangent @ increment, a @ increment
        speed = np.hypot(along, across)
        tangent = (along / speed)[:, None] * tangent + (across / speed)[:, None] * a
    return normal, normal / size + friction * tangent


def integrate(
    structure, wall, speed_hz, h, n, order="second", scheme="central_difference", start=None
):
    """Run of n steps of h [s] before a `ring.Wall`; start: q and its increment (K,) in the step
    before; rest by default."""
    structure = of_order(structure, order)
    decay, gain = coefficients(scheme, structure.omega, structure.damping_ratio, h)
    K, n_points, turn = len(decay), len(structure.normal), 2.0 * np.pi * speed_hz * h
    q, d = start or np.zeros((2, K))
    n_slow = len(structure.inertia)
    found = Run(np.zeros((n, K)), np.zeros((n, n_points, 3)), np.zeros((n, n_points)))
    for k in range(n):
        s = structure.bent @ q
        softer = structure.coupling / 2.0 + np.einsum("abcd,nd->nabc", structure.quartic, s) / 6.0
        bending = np.einsum("nabc,nb,nc->na", softer, s, s)
        bending[:, :n_slow] += resistance(structure, s, structure.bent @ d, bending, h)
        pull = structure.omega**2 * q + np.einsum("nak,na->k", structure.bent, bending)
        before, d = d, decay * d - gain * pull
        q = q + d
        moved = place(structure, q)
        depth, lean = met(structure, moved, wall, turn * (k + 1), h * (k + 1))
        depth = depth - wall.clearance
        if depth.max() > 0.0:
            gradient = gradients(structure, q)
            rows, along = directions(structure, gradient, lean, before, wall.friction, turn)
            found.force[k] = forces((rows * gain) @ along.T, depth)
            change = -gain * (along.T @ found.force[k])
            q, d = q + change, d + change
            moved = place(structure, q)
        found.position[k], found.place[k] = q, moved
    return found
