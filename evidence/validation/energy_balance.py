"""Where the energy of a contact run goes: a balance that closes to rounding.

Both schemes read  d_{n+1} = decay·d_n − ω² gain·q_n + gain·f,  f the force that acts at t_n. Times
(d_{n+1} + d_n)/(2 gain), where d_{n+1} + d_n = q_{n+1} − q_{n−1}, this is an exact balance,

    E_{n+1/2} − E_{n−1/2} = f·(d_{n+1} + d_n)/2 − D,
    E_{n+1/2} = (1 + decay)/(4 gain) d_{n+1}² + ω² q_n q_{n+1}/2,
    D = (1 − decay)/(4 gain) (d_{n+1} + d_n)² ≥ 0,

summed over the modes. Of the work of a contact force λ > 0, whose gap goes from g_{n−1} to g_{n+1},

    impact loss = λ (g_{n−1} − g_{n+1})/2,     work of the casing = work of the normal force + loss.

For small kinematics g_{n+1} = 0 and g_{n−1} ≥ 0: an impact can only take energy, contact that lasts
takes none, and the work of the casing is −λ times the half of the way that its surface makes from
t_{n−1} to t_{n+1}. For polar kinematics the radius is linearised along the normal n of the last
position, over the way m of the predictor and the correction δ by the contact forces; the bump b is
that of the predicted position. This leaves, by Taylor's theorem with e_t ⊥ n,

    |g_{n+1}| ≤ r_{n+1} = |m + δ|²/(2ρ) + max|b'| (|e_t·δ|/ρ + |m||δ|/ρ²)
                          + (max|b'| + max|b''|) |δ|²/(2ρ²),

so that a loss may be negative, but never below −λ (r_{n−1} + r_{n+1})/2, r = 0 without contact.

An audited integration takes the same steps, bit for bit, and several times as long.
"""

from typing import NamedTuple

import numpy as np

from hpcrub.contact.jit import compiled
from hpcrub.contact.kernel import advance, bump_ramp, correct, observe, raise_bumps
from hpcrub.model import casing

NEGATIVE, BOUND, BEYOND = range(3)  # rows of `Books.negative`
CASING, FRICTION, EXTERNAL, DAMPING, IMPACT = range(5)  # rows of `Books.work`
ACCOUNTS = ("casing", "friction", "damping", "impact", "stored", "unexplained")
TOLERANCE = 1e-9  # of the energy turned over: what may stay unexplained, of works and of signs

bump_height = compiled(casing.bump_height)


class Books(NamedTuple):
    """What an audited integration keeps. K modes, C contact points, L lanes; r rows, one after
    another for each step, and the first again after the last."""

    inertia: np.ndarray  # (1 + decay)/(4 gain) (K, L)
    loss: np.ndarray  # (1 − decay)/(4 gain) (K, L)
    increment: np.ndarray  # d before the step (K, L)
    moved: np.ndarray  # d_{n+1} + d_n (K, L)
    gap: np.ndarray  # g at t_{n−1}, t_n, t_{n+1} (3, C, L) [m]
    slack: np.ndarray  # r at t_{n−1}, t_n, t_{n+1} (3, C, L) [m]
    first: np.ndarray  # E at the start of the lane (1, L) [J]
    energy: np.ndarray  # E after the step (r, L) [J]
    work: np.ndarray  # sums of works of the steps of this row (r, 5, L) [J]
    unexplained: np.ndarray  # sums of |what the balance of a step does not explain| (r, L) [J]
    # losses of single tips below zero (3, L) [J]: their sum, what r allows of it, the rest beyond
    negative: np.ndarray
    row: np.ndarray  # (1,) of the next step


def open_books(bank, n_rows=1):
    """Books of a Bank of idle lanes; with one row they hold sums over all steps."""
    n_modes, width = bank.state.position.shape
    n_points = len(bank.polar.angle)
    return Books(
        *np.zeros((4, n_modes, width)),
        gap=np.zeros((3, n_points, width)),
        slack=np.zeros((3, n_points, width)),
        first=np.zeros((1, width)),
        energy=np.zeros((n_rows, width)),
        work=np.zeros((n_rows, 5, width)),
        unexplained=np.zeros((n_rows, width)),
        negative=np.zeros((3, width)),
        row=np.zeros(1, dtype=np.int64),
    )


def audit(bank, n_blocks):
    """Integrate a Bank in time, at the start of its table, and account for its energy.

    Args:
        bank: arrays.Bank (modified).
        n_blocks: how far.

    Returns:
        Books with one row for each step.
    """
    books = open_books(bank, n_blocks * len(bank.scheme.bump))
    for lane in np.flatnonzero(bank.scheme.gain[0]):
        open_lane(books, bank, lane)
    integrate((0,) * len(bank.scheme.step), *bank, n_blocks, -1, 1, books)
    return books


def open_lane(books, bank, lane):
    """Begin the account of a lane that has just been filled (books are modified)."""
    decay, gain = bank.scheme.decay[:, lane], bank.scheme.gain[:, lane]
    q, d = bank.state.position[:, lane], bank.state.increment[:, lane]
    books.inertia[:, lane], books.loss[:, lane] = (1.0 + decay) / gain / 4, (1.0 - decay) / gain / 4
    books.increment[:, lane] = d
    for values in (books.slack, books.energy, books.work, books.unexplained, books.negative):
        values[..., lane] = 0.0
    squared = bank.scheme.squared
    books.first[0, lane] = np.sum(books.inertia[:, lane] * d**2 + squared * q * (q - d) / 2.0)
    books.energy[-1, lane] = books.first[0, lane]
    for back, place in ((1, 0), (0, 1)):
        find_gaps(bank.scheme, bank.state, bank.polar, -1 - back, back, lane, books.gap[place])


def close_lane(books, lane):
    """What became of a lane's energy: `ACCOUNTS` (6,) [J]."""
    work, stored = books.work[:, :, lane].sum(axis=0), books.energy[-1, lane] - books.first[0, lane]
    gained = work[[CASING, FRICTION]]
    return np.array(
        [*gained, work[DAMPING], work[IMPACT], stored, books.unexplained[:, lane].sum()]
    )


def is_balanced(books, lane):
    """Whether all energy of a lane is explained and no impact gave any, but for what r allows."""
    turned_over = np.abs(books.work[:, :, lane]).sum() + abs(books.first[0, lane])
    wrong = max(books.unexplained[:, lane].sum(), -books.negative[BEYOND, lane])
    return bool(wrong <= TOLERANCE * turned_over)


@compiled
def find_gaps(scheme, state, polar, step, back, lane, gap):
    """Gaps of one lane (gap (C, L) is modified), ``back`` steps ago, at row ``step`` of the table.

    Before its first step a lane has moved at its present velocity.
    """
    t = max(state.n_steps[lane] - back, 0) * scheme.step[lane]
    grown = bump_ramp(t, scheme.ramp_time)
    for i in range(len(polar.angle)):
        u_r = u_t = 0.0
        for k in range(state.position.shape[0]):
            q = state.position[k, lane] - back * state.increment[k, lane]
            u_r += scheme.normal[k, i] * q
            u_t += scheme.tangential[k, i] * q
        if polar.enabled:
            r = polar.radius[i] + u_r
            phi = polar.angle[i] + (step + 1) * polar.turn + np.arctan2(u_t, r)
            bump = bump_height(phi, 2.0 * np.pi / polar.pitch, polar.height)
            gap[i, lane] = polar.clearance[i] - grown * bump - (np.hypot(r, u_t) - polar.radius[i])
        else:
            bump = scheme.bump[step % scheme.bump.shape[0], i]
            gap[i, lane] = scheme.clearance[0, i] - grown * bump - u_r


@compiled
def account(lanes, scheme, state, polar, step, n_active, books):
    """Enter one step, already corrected, into the books (modified)."""
    row, before = books.row[0], books.row[0] - 1  # the last row comes before the first
    books.row[0] = (row + 1) % books.energy.shape[0]
    old = books.energy[before].copy()
    work = books.work[row]
    known = work[CASING] + work[FRICTION] + work[EXTERNAL] - work[DAMPING] - work[IMPACT]
    books.energy[row] = 0.0
    for k in range(state.position.shape[0]):
        for lane in range(len(lanes)):
            q, d = state.position[k, lane], state.increment[k, lane]
            moved = d + books.increment[k, lane]
            kinetic = books.inertia[k, lane] * d * d
            books.energy[row, lane] += kinetic + scheme.squared[k] * q * (q - d) / 2.0
            work[DAMPING, lane] += books.loss[k, lane] * moved * moved
            books.moved[k, lane] = moved
            books.increment[k, lane] = d
            if scheme.external.shape[0] > 0:
                work[EXTERNAL, lane] += scheme.external[step, k] * moved / 2.0
    books.slack[2] = 0.0
    for lane in range(len(lanes)):
        if scheme.gain[0, lane] > 0.0:  # else idle
            find_gaps(scheme, state, polar, step, 0, lane, books.gap[2])
            contact_work(scheme, state, polar, n_active, lane, books, work)
    books.gap[0], books.gap[1] = books.gap[1], books.gap[2]
    books.slack[0], books.slack[1] = books.slack[1], books.slack[2]
    gained = work[CASING] + work[FRICTION] + work[EXTERNAL] - work[DAMPING] - work[IMPACT]
    books.unexplained[row] += np.abs(books.energy[row] - old - (gained - known))


@compiled
def left_open(state, polar, n_active, i, lane, gap):
    """r of contact point i [m]: what the linearised correction may leave of its gap (C, L)."""
    n_points = state.penetration.shape[0] - 1
    n_pairs = n_points * n_points
    moved_r = moved_t = 0.0
    for a in range(n_active):
        j = state.active[a]
        if j < len(polar.angle):
            at = i * n_points + j
            force_r, force_t = state.multiplier[j, lane], state.multiplier[n_points + j, lane]
            moved_r += polar.compliance[at, lane] * force_r
            moved_r += polar.compliance[n_pairs + at, lane] * force_t
            moved_t += polar.compliance[2 * n_pairs + at, lane] * force_r
            moved_t += polar.compliance[3 * n_pairs + at, lane] * force_t
    moved = np.hypot(moved_r, moved_t)
    free_r, free_t = polar.moved[n_points + i, lane], polar.moved[2 * n_points + i, lane]
    free, whole = np.hypot(free_r, free_t), np.hypot(free_r + moved_r, free_t + moved_t)
    along = abs(polar.cosine[i, lane] * moved_t - polar.sine[i, lane] * moved_r)
    nearest = polar.radius[i] + polar.clearance[i] - polar.height - gap[i, lane]
    nearest -= max(moved, whole)  # of all ρ
    width = 0.1 * polar.pitch
    slope = polar.height * np.sqrt(2.0 / np.e) / width
    bend = 2.0 * polar.height / width**2
    radius = whole * whole / (2.0 * nearest)
    turned = slope * (along / nearest + free * moved / nearest**2)
    return radius + turned + (slope + bend) * moved * moved / (2.0 * nearest**2)


@compiled
def contact_work(scheme, state, polar, n_active, lane, books, work):
    """Enter the works of the contact forces of one lane (books and work are modified)."""
    n_padded = scheme.normal.shape[1]
    for a in range(n_active):
        i = state.active[a]
        if i >= len(polar.angle):
            continue  # padding, and the tangential forces of polar kinematics
        way_r = way_t = 0.0
        for k in range(books.moved.shape[0]):
            way_r += scheme.normal[k, i] * books.moved[k, lane] / 2.0
            way_t += scheme.tangential[k, i] * books.moved[k, lane] / 2.0
        if polar.enabled:
            force_r, force_t = state.multiplier[i, lane], state.multiplier[n_padded + i, lane]
            cosine, sine = polar.cosine[i, lane], polar.sine[i, lane]
            force = force_r * cosine + force_t * sine
            normal = -force * (cosine * way_r + sine * way_t)
            slide = force_t * cosine - force_r * sine  # μλ
            friction = -slide * (cosine * way_t - sine * way_r)
            books.slack[2, i, lane] = left_open(state, polar, n_active, i, lane, books.gap[2])
        else:
            force = state.multiplier[i, lane]
            normal = -force * way_r
            friction = -force * polar.friction * way_t
        impact = force * (books.gap[0, i, lane] - books.gap[2, i, lane]) / 2.0
        work[CASING, lane] += normal + impact
        work[FRICTION, lane] += friction
        work[IMPACT, lane] += impact
        if impact < 0.0:
            allowed = force * (books.slack[0, i, lane] + books.slack[2, i, lane]) / 2.0
            books.negative[NEGATIVE, lane] += impact
            books.negative[BOUND, lane] -= allowed
            books.negative[BEYOND, lane] += min(impact + allowed, 0.0)


@compiled
def integrate(
    lanes, scheme, contact, state, record, polar, spatial, n_blocks, block, stride, books
):
    """`kernel.integrate`, step for step the same bits, with every step in the books (modified)."""
    n_observed = scheme.observed.shape[1]
    n_steps = scheme.bump.shape[0]
    for b in range(n_blocks):
        place = (block + b) % (record.peak.shape[0] // n_observed)
        if block >= 0:
            record.peak[place * n_observed : (place + 1) * n_observed] = 0.0
        for step in range(n_steps):
            raise_bumps(scheme, state)
            for lane in range(len(lanes)):
                state.n_steps[lane] += 1
            n_active = advance(lanes, scheme, contact, state, polar, spatial, step, 0)
            correct(lanes, scheme, state, n_active)
            account(lanes, scheme, state, polar, step, n_active, books)
            if block >= 0 and (step + 1) % stride == 0:
                row = place * (n_steps // stride) + step // stride
                observe(lanes, scheme, state, record, row, place, 0)
