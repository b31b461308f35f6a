"""Where the energy of a contact run goes, whatever the tips meet: a balance to rounding.

Both schemes read  d_{n+1} = decay·d_n − ω² gain·q_n + gain·f,  f the force that acts at t_n. Times
(d_{n+1} + d_n)/(2 gain), where d_{n+1} + d_n = q_{n+1} − q_{n−1}, this is an exact balance,

    E_{n+1/2} − E_{n−1/2} = f·(d_{n+1} + d_n)/2 − D,
    E_{n+1/2} = (1 + decay)/(4 gain) d_{n+1}² + ω² q_n q_{n+1}/2,
    D = (1 − decay)/(4 gain) (d_{n+1} + d_n)² ≥ 0,

summed over the modes. A contact force N of a step, whose point goes from p_{n−1} over p_n to
p_{n+1} inside the new surface, takes N (p_{n+1} − p_{n−1})/2 from the disk and from the casing that
moves its bumps. On a rigid casing that is the impact loss λ (g_{n−1} − g_{n+1})/2 ≥ 0: an impact
can only take energy, and contact that lasts takes none. A casing that gives or wears has forces s
of its own law at the ends of steps, of which N is the mean a s_{n+1} + b s_n + c s_{n−1}. Of its
work, kept are the energy U = k₁ q²/2 of a bar, q = max(p − w, 0), the plastic work
e(w) = σ_Y w + H w²/2t of each area, and the like of the casing behind; k₁ q (w_n − w⁻) is the work
with which the turning casing brings the groove of former passages under the point, w_n the worn
depth under it after the step before and w⁻ at the begin of this. The rest is what a step loses, or
gains. N is found here anew: a kernel with another law does not close the balance. The pairs of a
casing that vibrates are taken in its own frame, where they are ordinary modes; the work with which
the casing moves its bumps is then the shaft's: it carries the blades along the wave, too. On a
basis that disks share the deviation δ of a blade is a spring on its modes y, whose force
−δ (y_n + s (y_n − y_{n−1})) acts at t_n: its energy is δ y_n y_{n+1}/2, and s adds to D.
"""

from typing import NamedTuple

import numpy as np

from evidence.truth.motion import recorded
from hpcrub.model import casing

TOLERANCE = 1e-9  # of the energy turned over: what may stay unexplained, of works and of signs


class Ledger(NamedTuple):
    """Energy of the disk, and works of n steps, L lanes."""

    energy: np.ndarray  # E (n + 1, L) before the first and after every step [J]
    casing: np.ndarray  # work of the casing's motion in every step (n, L) [J]
    friction: np.ndarray  # work of friction (n, L) [J]
    external: np.ndarray  # work of the external forces (n, L) [J]
    groove: np.ndarray  # work of the worn surface's motion (n, L) [J]
    damping: np.ndarray  # D, dissipated (n, L) [J]
    impact: np.ndarray  # loss in impacts, and by the length of a step (n, L) [J]
    elastic: np.ndarray  # into coating and casing, which they give back (n, L) [J]
    plastic: np.ndarray  # into the wear of the bars (n, L) [J]
    dashpot: np.ndarray  # into the damper of an elastic casing (n, L) [J]
    negative: np.ndarray  # of the losses of single tips before a rigid casing (n, L) [J]

    def residual(self):
        """What the balance of every step fails to explain (n, L) [J]: rounding, or a defect."""
        gained = self.casing + self.friction + self.external + self.groove
        spent = self.damping + self.impact + self.elastic + self.plastic + self.dashpot
        return np.diff(self.energy, axis=0) - (gained - spent)

    def turnover(self):
        """Energy at the start, and work done either way (L,) [J]: the scale of the residual."""
        return np.abs(self[1:-1]).sum(axis=(0, 1)) + np.abs(self.energy[0])

    def unexplained(self):
        """Sum of what is not explained, over the energy turned over (L,) [-]; idle lanes have 0."""
        turnover = self.turnover()
        return np.abs(self.residual()).sum(axis=0) / np.where(turnover > 0.0, turnover, 1.0)

    def is_balanced(self):
        """Whether all energy is explained and, on a rigid casing, no tip gave any (L,)."""
        given = -self.negative.sum(axis=0)
        return (self.unexplained() <= TOLERANCE) & (given <= TOLERANCE * self.turnover())


def audit(bank, n_steps, scene=None, modes=None):
    """Integrate a Bank n_steps in time, from the start of its table (bank is modified).

    scene: of a casing that gives or wears. modes: of a disk on a basis that disks share.
    Returns a Ledger; idle lanes have zeros.
    """
    scheme, state, parts = bank.scheme, bank.state, []
    normal_of, load, springs = _normal(bank), scheme.load[:, : len(state.position)].T, None
    if modes:
        normal_of, load = modes.rows.normal, bank.law.loads(modes.rows, scene)
        springs = BladeSprings(bank, modes)
    inverse = np.divide(1.0, scheme.gain, out=np.zeros_like(scheme.gain), where=scheme.gain > 0.0)
    inertia, loss = (1.0 + scheme.decay) * inverse / 4.0, (1.0 - scheme.decay) * inverse / 4.0
    spring = np.reshape(scheme.omega2, (len(inverse), -1)) / 2.0
    surface = Surface(bank, scene) if scene and (scene.coating or scene.elastic_casing) else None
    q, d, start, done = state.position.copy(), state.increment.copy(), state.n_steps.copy(), 0
    first = np.sum(inertia * d**2 + spring * q * (q - d), axis=0)
    depth = _penetration(bank, normal_of, np.stack([q - d, q]), start, np.array([-1, 0]))
    # worn bars are seen only as they are after a step
    for steps in recorded(bank, n_steps, *([1] if surface else [])):
        force, rows = steps.force[:, : depth.shape[1]], done + np.arange(len(steps.force))
        now = _penetration(bank, normal_of, steps.position, start, rows + 1)
        depth = np.concatenate([depth[-2:], now])
        at_rest = [_at_rest(scheme, part, rows + 1) for part in steps[:2]]
        moved = at_rest[1] + np.concatenate([d[None], at_rest[1][:-1]])
        by_normal = _at_rest(scheme, -(normal_of.T @ force), rows)
        normal = np.sum(by_normal * moved, axis=1) / 2.0
        by_all = _at_rest(scheme, load @ steps.force[:, : load.shape[1]], rows)
        all_forces = np.sum(by_all * moved, axis=1) / 2.0
        taken = force * (depth[2:] - depth[:-2]) / 2.0
        tips, external = taken.sum(axis=1), np.zeros_like(normal)
        if scheme.external is not None:
            modal = scheme.external[rows % len(scheme.bump), :, None]
            external = np.sum(modal * moved, axis=1) / 2.0
        impact, *given = tips, *np.zeros((4, *tips.shape))
        if surface:
            bar = surface.works(force[0], *depth)
            impact, *given = (part[None] for part in bar)
        q, d = at_rest
        energy = np.sum(inertia * d**2 + spring * q * (q - d), axis=1)
        damped = np.sum(loss * moved**2, axis=1)
        if springs:
            kept, lost = springs.work(steps.position)
            energy, damped = energy + kept, damped + lost
        parts.append((energy, normal + tips, all_forces - normal, external, given[0],
                      damped, impact, *given[1:],
                      np.minimum(taken, 0.0).sum(axis=1)))  # fmt: skip
        q, d, done = q[-1], d[-1], done + len(q)
    energy, *works = map(np.concatenate, zip(*parts, strict=True))
    return Ledger(np.concatenate([first[None], energy]), *works)


class BladeSprings:
    """Deviations of blades from the modes that disks share, as springs on the blades' modes."""

    def __init__(self, bank, modes):
        """Of a bank at rest; modes: of one of its disks."""
        n_blades, n_modes = modes.blades.modes.shape[:2]
        self.modes = modes.rows.blade.reshape(n_blades, n_modes, -1).swapaxes(0, 1)
        shape = n_modes, n_blades, bank.width
        self.deviation = -bank.basis.deviation.reshape(shape)
        self.lag = bank.basis.lag.reshape(shape)
        self.last = np.zeros((2, *shape))  # motion of the blades' modes after the last two steps

    def work(self, position):
        """Energy of the springs after each of some steps, and what their lag takes (n, L) [J].

        position: q after each step (n, K, L) [m·√kg], in the rotating frame.
        """
        y = np.concatenate([self.last, np.einsum("jbk,nkl->njbl", self.modes, position)])
        self.last = y[-2:]
        kept = self.deviation * y[1:-1] * y[2:] / 2.0
        slip = self.deviation * self.lag * (y[1:-1] - y[:-2]) * (y[2:] - y[:-2]) / 2.0
        return kept.sum(axis=(1, 2)), slip.sum(axis=(1, 2))


class Surface:
    """What the contact points of a bank meet, from its Scene and the worn depths of the bank."""

    def __init__(self, bank, scene):
        """At the start of a table."""
        face, coating, spring = scene.interface, scene.coating, scene.elastic_casing
        self.worn, n = bank.law.surface.worn, len(face.angle)
        weights = bank.law.surface.weights[: 3 * n].reshape(n, 3, -1)
        self.weights = np.moveaxis(weights, 1, 0)  # a, b and c
        self.n_bars = bank.law.surface.n_steps
        self.first = np.round(face.angle * self.n_bars / (2.0 * np.pi)).astype(int)
        self.strip, self.n_steps = face.strip * self.n_bars, 0
        self.coating, self.area = coating, coating.area * face.share[:, None] if coating else 0.0
        self.k = spring.stiffness if spring else 0.0
        h = np.where(bank.scheme.step > 0.0, bank.scheme.step, np.inf)
        self.d = spring.damping / h if spring else 0.0
        self.thickness = coating.thickness if coating else 0.0
        self.under = np.zeros((n, bank.width))  # worn depth under every point after the last step
        self.fresh = self._worn(1)  # and before the coming one
        self.forces = np.zeros((2, n, bank.width))  # of the law at the ends of two steps

    def _worn(self, step):
        """Worn depths now of the bars on which the points stand at a step."""
        bars = self.strip + (self.first + step) % self.n_bars
        return self.worn[bars] if self.coating else np.zeros_like(self.under)

    def works(self, force, before, p, new):
        """Loss, groove, elastic, plastic and dashpot (L,) [J] of a step.

        force: (C, L) [N]; before, p, new: penetrations after the step before the last, the last and
        this one (C, L) [m].
        """
        self.n_steps += 1
        old, fresh = self.under, self.fresh
        worn = fresh
        if self.coating:  # of the point: another one on this bar may wear it deeper
            strained = np.minimum(new, self.thickness) - self.coating.depth_at_yield
            worn = np.maximum(fresh, self.coating.kept * strained)
        self.under, self.fresh = worn, self._worn(self.n_steps + 1)
        k1 = plastic = 0.0
        if self.coating:
            k1 = self.coating.young * self.area / self.thickness
            plastic = self.area * (self.coating.energy(worn) - self.coating.energy(fresh))
        x0, x = np.maximum(p - self.thickness, 0.0), np.maximum(new - self.thickness, 0.0)
        q0, q = np.maximum(p - x0 - old, 0.0), np.maximum(new - x - worn, 0.0)
        bar, pushes = k1 * q, self.k * x + self.d * (x - x0) > 0.0
        law = bar + np.where(pushes, self.k * x + self.d * (x - x0), 0.0)
        a, b, c = self.weights
        mean = a * law + b * self.forces[0] + c * self.forces[1]
        self.forces = np.array([law, self.forces[0]])
        if not self.k:  # the reaction of a rigid casing, which only pushes
            mean = np.where(new > self.thickness * (1.0 - 1e-9), np.maximum(force, mean), mean)
        dashpot = np.where(pushes, self.d * (x - x0), -self.k * x) * (x - x0)
        elastic = k1 * (q**2 - q0**2) / 2.0 + self.k * (x**2 - x0**2) / 2.0
        elastic += k1 * (q * x - q0 * x0)  # of bars that are used up, and keep their force
        groove = bar * (old - fresh)
        loss = mean * (new - before) / 2.0 + groove - elastic - plastic - dashpot
        return [np.sum(part + 0.0 * force, 0) for part in (loss, groove, elastic, plastic, dashpot)]


def _at_rest(scheme, values, n):
    """Modal quantities (m, K, L) after n (m,) steps, those of the casing's pairs in its frame."""
    disk, pairs = np.split(values, [values.shape[1] - scheme.casing], axis=1)
    cosine, sine = scheme.turn[::2, 0], scheme.turn[1::2, 0]
    turned = (cosine - 1j * sine) ** n[:, None]
    y = (pairs[:, ::2] - 1j * pairs[:, 1::2]) * turned[:, :, None]
    pairs = np.stack([y.real, -y.imag], axis=2).reshape(pairs.shape)
    return np.concatenate([disk, pairs], axis=1)


def _normal(bank):
    """Normal displacement of the contact points per modal coordinate, without the padding."""
    return bank.scheme.normal[:, np.isfinite(bank.scheme.point_clearance[0])].T


def _penetration(bank, normal_of, q, start, n):
    """Penetrations of the new surface by q (m, K, L) after n (m,) steps from step ``start`` (L,).

    normal_of: normal displacement of the points per modal coordinate (C, K). Returns (m, C, L) [m].
    """
    scheme, n_points = bank.scheme, np.count_nonzero(np.isfinite(bank.scheme.point_clearance))
    t = np.maximum(start + n[:, None], 0) * scheme.step
    grown = np.vectorize(casing.ramp, otypes=[float])(t, scheme.ramp_time)[:, None]
    bump = scheme.bump[(n - 1) % len(scheme.bump), :n_points, None]
    clearance = scheme.clearance + scheme.point_clearance[0, :n_points, None]
    return grown * bump + normal_of @ q - clearance
