"""A disk that rubs while its rotor gains or loses speed: a second program with its own time steps.

The step is constant in time and θ(t) that of `run_up.turned`, or of any other functions. Both
schemes read q⁺ = q + d⁺, d⁺ = keep d − pull q + gain f, f the force at the begin of the step.
Forces that hold tips before a rigid casing are those at the end of a step, as forward increments,
so that the error is of first order; those of springs are the mean (N⁺ + 2N + N⁻)/4 of three levels
(trapezoidal rule), second order. A casing that is always met with a force k times the penetration
is a linear load, for which `run_up.linear_run` has the exact motion.

Only NumPy; nothing is shared with the product.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from evidence.truth.run_up import Function, Harmonic, Turning, load_of, ramp

BLOCK = 4096  # steps whose casing is computed together


class Structure(NamedTuple):
    """K modes of mass one, and C tips."""

    omega: np.ndarray  # (K,) [rad/s]
    damping: np.ndarray  # ξ (K,)
    normal: np.ndarray  # outward motion of the tips (C, K) [1/√kg]
    tangential: np.ndarray  # towards +θ (C, K) [1/√kg]
    angle: np.ndarray  # of the tips (C,) [rad]


class Wall(NamedTuple):
    """What the tips meet; they slide towards +θ."""

    height: Function  # inward, of the angles around the casing (any shape) [rad] → [m]
    clearance: float | Callable[[np.ndarray, np.ndarray], np.ndarray]  # [m], or of t [s], Ω [rad/s]
    friction: float = 0.0
    ramp_time: float = 0.0  # of the heights [s]
    stiffness: float = np.inf  # k of a spring at each tip [N/m]; infinite: rigid
    always: bool = False  # springs also pull: k times the penetration of either sign


class Run(NamedTuple):
    """Motion at the times 0, h, ... n h."""

    times: np.ndarray  # (n + 1,) [s]
    position: np.ndarray  # q (n + 1, K) [m √kg], or the observed displacements (n + 1, O) [m]
    before: np.ndarray  # the same a step before the first time, (K,) or (O,)
    force: np.ndarray  # normal forces of the n steps, half of that of the first (n, C) [N]


class Balance(NamedTuple):
    """Energy of the modes, and works of every step on them [J]."""

    energy: np.ndarray  # in the middle of the steps that end at 0, h, ... n h (n + 1,)
    wall: np.ndarray  # of the normal forces (n,)
    friction: np.ndarray  # (n,)
    damping: np.ndarray  # 0 or less (n,)
    kept: np.ndarray  # of the moving casing's work: by springs, or lost in rigid impacts (n,)

    def unexplained(self) -> np.ndarray:
        """What a step fails to explain (n,) [J]: rounding, or a defect."""
        return np.diff(self.energy) - (self.wall + self.friction + self.damping)

    def casing(self) -> np.ndarray:
        """Work with which the casing moves its heights and its clearance (n,) [J]."""
        return self.wall + self.kept


def bumps(number: int, height: float, width: float = 0.1) -> Function:
    """Heights of even Gaussian bumps; height [m]; width: from a crest to 1/e of it [pitches]."""
    pitch = 2.0 * np.pi / number

    def at(phi):
        off = (np.asarray(phi) + pitch / 2.0) % pitch - pitch / 2.0
        return height * np.exp(-((off / (width * pitch)) ** 2))

    return at


def bump_waves(number: int, height: float, width: float = 0.1, terms: int = 16) -> list:
    """Fourier series of `bumps`: (order, amplitude [m], angle of a crest [rad]) of each term."""
    mean = height * width * np.sqrt(np.pi)
    size = 2.0 * mean * np.exp(-((np.pi * width * np.arange(1, terms)) ** 2))
    return [(0, mean, 0.0), *((number * (m + 1), a, 0.0) for m, a in enumerate(size))]


def waves(terms: Sequence[tuple[int, float, float]]) -> Function:
    """Heights Σ a cos n(φ − β) of terms (n, a [m], β [rad])."""
    order, size, crest = np.array(terms, dtype=float).T
    return lambda phi: np.cos(order * (np.asarray(phi)[..., None] - crest)) @ size


def spring_loads(
    structure: Structure, stiffness: float, clearance: float, friction: float, terms: Sequence
) -> tuple[np.ndarray, list[Harmonic]]:
    """What a casing Σ a cos n(φ − β) is to a structure that its springs always push or pull.

    stiffness k of each tip [N/m]; clearance [m]; terms as of `waves`. Returns the coupling (K, K)
    and the loads that `linear_run` takes.
    """
    push = stiffness * (structure.normal + friction * structure.tangential).T
    loads = [Harmonic(0, clearance * push.sum(axis=1), ramped=False)]
    for n, a, beta in terms:
        loads.append(Harmonic(n, -a * (push @ np.exp(1j * n * (structure.angle - beta)))))
    return push @ structure.normal, loads


def pressing(W: np.ndarray, p: np.ndarray) -> np.ndarray:
    """λ ≥ 0 (C,) with p − Wλ ≤ 0 and λ·(p − Wλ) = 0, by principal pivoting to rounding.

    All wrong points change sides at once, and the first alone when that goes on (Murty), which
    ends for every W whose principal minors are positive. Raises RuntimeError where it does not.
    """
    on, noise = p > 0.0, 1e-14 * np.abs(p).max()
    for attempt in range(200):
        found = np.zeros(len(p))
        found[on] = np.linalg.solve(W[np.ix_(on, on)], p[on])
        wrong = np.where(on, found < 0.0, p - W @ found > noise)
        if not wrong.any():
            return found
        change = wrong if attempt < 10 else np.arange(len(p)) == wrong.argmax()
        on = on ^ change
    raise RuntimeError("no forces found")


def recurrence(scheme: str, omega: np.ndarray, damping: np.ndarray, h: float) -> tuple:
    """Factors of an increment, of a displacement and of a force (K,) in a step of h [s]."""
    c = damping * omega * h
    if scheme == "central_difference":
        gain = h * h / (1.0 + c)
        return (1.0 - c) / (1.0 + c), omega**2 * gain, gain
    decay, half = np.exp(-c), omega * np.sqrt(1.0 - damping**2) * h / 2.0
    pull = np.expm1(-c) ** 2 + 4.0 * decay * np.sin(half) ** 2  # 1 − 2 e^{−c} cos + e^{−2c}
    return decay**2, pull, pull / omega**2


def earlier(structure: Structure, q: np.ndarray, v: np.ndarray, h: float) -> np.ndarray:
    """Modal displacements (K,) of the free motion h [s] before it is q, v (K,)."""
    c, turn = structure.damping * structure.omega, np.sqrt(1.0 - structure.damping**2)
    turn = turn * structure.omega
    return np.exp(c * h) * (q * np.cos(turn * h) - (v + c * q) * np.sin(turn * h) / turn)


def depths(structure: Structure, wall: Wall, turning: Turning, t: np.ndarray) -> np.ndarray:
    """Penetrations (T, C) [m] of tips that do not move, at times (T,) [s]."""
    heights = wall.height(turning.angle(t)[:, None] + structure.angle)
    given = wall.clearance
    room = given(t, turning.speed(t)) if callable(given) else np.full(len(t), given)
    return ramp(t, wall.ramp_time)[:, None] * heights - room[:, None]


class _Contact:
    """Normal forces of steps."""

    def __init__(self, wall: Wall, W: np.ndarray, depth: np.ndarray):
        """W (C, C): what forces of a step undo [m/N]; depth: penetrations at the start (C,) [m]."""
        self.wall, self.W, self.elastic = wall, W, np.isfinite(wall.stiffness)
        self.soft = np.eye(len(W)) / wall.stiffness
        spring = depth if wall.always else np.maximum(depth, 0.0)
        self.now = self.last = wall.stiffness * spring if self.elastic else 0.0 * depth

    def forces(self, depth: np.ndarray, part: float) -> np.ndarray | None:
        """Forces (C,) [N] in a step that ends at depth (C,) [m] without them; part: of W."""
        if not self.elastic:
            return pressing(part * self.W, depth) if depth.max() > 0.0 else None
        past = self.now / 2.0 + self.last / 4.0
        left, M = depth - part * (self.W @ past), part / 4.0 * self.W + self.soft
        new = np.linalg.solve(M, left) if self.wall.always else pressing(M, left)
        self.now, self.last = new, self.now
        return new / 4.0 + past


def rubbing_run(
    structure: Structure, wall: Wall, turning: Turning, h: float, n: int,
    forces: Sequence[Harmonic] = (), euler: np.ndarray | None = None, scheme: str = "exact_modal",
    start: tuple[np.ndarray, np.ndarray] | None = None, observed: np.ndarray | None = None,
) -> Run:  # fmt: skip
    """n steps of h [s] of a disk before a casing, from the time 0.

    forces, euler: as of `linear_run`, they act besides; scheme: "exact_modal" (ωh below 2 of all
    modes) or "central_difference"; start: q [m √kg] and q̇ (K,), rest by default; observed:
    (O, K) [1/√kg], what is kept in place of the modal displacements. The first step takes half of
    all forces, as the other half belongs to the time before.
    """
    keep, pull, gain = recurrence(scheme, structure.omega, structure.damping, h)
    K, along = len(gain), structure.normal + wall.friction * structure.tangential
    answer, rows = gain[:, None] * along.T, np.eye(K) if observed is None else observed
    q, v = start or np.zeros((2, K))
    d = q - earlier(structure, q, v, h)
    position, pushed = np.zeros((n + 1, len(rows))), np.zeros((n, len(along)))
    position[0], before = rows @ q, rows @ (q - d)
    begin = depths(structure, wall, turning, np.zeros(1))[0] + structure.normal @ q
    contact = _Contact(wall, structure.normal @ answer, begin)
    for k in range(n):
        if k % BLOCK == 0:
            t = h * np.arange(k, min(k + BLOCK, n) + 1)
            rest = depths(structure, wall, turning, t[1:])
            load = _impulses(turning, wall, t[:-1], h, forces, euler) * gain
        part = 0.5 if k == 0 else 1.0
        d = keep * d - pull * q + part * load[k % BLOCK]
        q = q + d
        force = contact.forces(rest[k % BLOCK] + structure.normal @ q, part)
        if force is not None:
            pushed[k] = part * force
            change = answer @ pushed[k]
            q, d = q - change, d - change
        position[k + 1] = rows @ q
    return Run(h * np.arange(n + 1), position, before, pushed)


def _impulses(
    turning: Turning, wall: Wall, t: np.ndarray, h: float, forces: Sequence[Harmonic],
    euler: np.ndarray | None,
) -> np.ndarray:  # fmt: skip
    """Modal loads (T, K) [N/√kg] at times (T,) [s]; of Ω̇ the mean from half a step before on."""
    load = load_of(forces)(turning.angle(t), ramp(t, wall.ramp_time)) if forces else 0.0
    since = np.maximum(t - h / 2.0, 0.0)
    gained = turning.speed(t + h / 2.0) - turning.speed(since)
    inertia = np.zeros(1) if euler is None else euler
    return load - np.outer(gained / (t + h / 2.0 - since), inertia)


def work_and_energy(
    structure: Structure, wall: Wall, turning: Turning, run: Run, scheme: str = "exact_modal"
) -> Balance:
    """The Balance of a `rubbing_run` whose modal displacements were kept, without other loads.

    From level to level the energy (1 + keep)/(4 gain) d² + ω² q q⁻/2, summed over the modes, gains
    what forces f do on (d⁺ + d)/2 and loses (1 − keep)/(4 gain) (d⁺ + d)²: exactly, in any step.
    """
    keep, pull, gain = recurrence(scheme, structure.omega, structure.damping, run.times[1])
    q = np.concatenate([run.before[None], run.position])
    d, moved = np.diff(q, axis=0), (q[2:] - q[:-2]) / 2.0
    kinetic = d**2 @ ((1.0 + keep) / (4.0 * gain))
    energy = kinetic + (q[1:] * q[:-1]) @ (pull / gain) / 2.0
    t = np.append(run.times[0] - run.times[1], run.times)
    p = depths(structure, wall, turning, t) + q @ structure.normal.T
    normal, along = moved @ structure.normal.T, moved @ structure.tangential.T
    return Balance(
        energy,
        wall=-np.sum(run.force * normal, axis=1),
        friction=-wall.friction * np.sum(run.force * along, axis=1),
        damping=-(4.0 * moved**2) @ ((1.0 - keep) / (4.0 * gain)),
        kept=np.sum(run.force * (p[2:] - p[:-2]), axis=1) / 2.0,
    )
