"""Where the energy of a contact run of a planar disk goes: a balance that closes to rounding.

Both schemes read  d_{n+1} = decay·d_n − ω² gain·q_n + gain·f,  f the force that acts at t_n. Times
(d_{n+1} + d_n)/(2 gain), where d_{n+1} + d_n = q_{n+1} − q_{n−1}, this is an exact balance,

    E_{n+1/2} − E_{n−1/2} = f·(d_{n+1} + d_n)/2 − D,
    E_{n+1/2} = (1 + decay)/(4 gain) d_{n+1}² + ω² q_n q_{n+1}/2,
    D = (1 − decay)/(4 gain) (d_{n+1} + d_n)² ≥ 0,

summed over the modes. Of the work of a contact force λ > 0, whose gap goes from g_{n−1} to g_{n+1},

    impact loss = λ (g_{n−1} − g_{n+1})/2,     work of the casing = work of the normal force + loss.

On a rigid casing g_{n+1} = 0 and g_{n−1} ≥ 0: an impact can only take energy, contact that lasts
takes none, and the work of the casing is −λ times the half of the way that its surface makes from
t_{n−1} to t_{n+1}.

`Books` are an observer of the steps: an audited integration takes several times as long.
"""

from typing import NamedTuple

import numpy as np

from hpcrub.contact.integrate import bump_ramp, run
from hpcrub.contact.jit import compiled
from hpcrub.contact.passes import correct

CASING, FRICTION, EXTERNAL, DAMPING, IMPACT = range(5)  # rows of `Books.work`
ACCOUNTS = ("casing", "friction", "damping", "impact", "stored", "unexplained")
TOLERANCE = 1e-9  # of the energy turned over: what may stay unexplained, of works and of signs


@compiled
def find_gaps(scheme, state, step, back, gap):
    """Gaps (gap (C, L) is modified), ``back`` steps ago, at row ``step`` of the table.

    Before its first step a lane has moved at its present velocity.
    """
    n_points, width = gap.shape
    for lane in range(width):
        t = max(state.n_steps[lane] - back, 0) * scheme.step[lane]
        grown = bump_ramp(t, scheme.ramp_time)
        for i in range(n_points):
            bump = scheme.bump[step % scheme.bump.shape[0], i]
            gap[i, lane] = scheme.clearance[0, lane] + scheme.own[0, i] - grown * bump
    for k in range(state.position.shape[0]):
        for i in range(n_points):
            for lane in range(width):
                q = state.position[k, lane] - back * state.increment[k, lane]
                gap[i, lane] -= scheme.normal[k, i] * q


@compiled
def contact_work(scheme, state, n_active, books, work):
    """Enter the works of the contact forces of a step (books and work are modified)."""
    for i in state.active[:n_active]:
        for lane in range(work.shape[1]):
            normal = along = 0.0
            for k in range(books.moved.shape[0]):
                half = books.moved[k, lane] / 2.0
                normal -= scheme.normal[k, i] * half
                along += (scheme.load[k, i] + scheme.normal[k, i]) * half  # −μ u_t
            force = state.multiplier[i, lane]
            impact = force * (books.gap[0, i, lane] - books.gap[2, i, lane]) / 2.0
            work[CASING, lane] += force * normal + impact
            work[FRICTION, lane] += force * along
            work[IMPACT, lane] += impact
            books.negative[0, lane] += min(impact, 0.0)


class Books(NamedTuple):
    """What an audited integration keeps. K modes, C contact points, L lanes; r rows, one after
    another for each step, and the first again after the last."""

    inertia: np.ndarray  # (1 + decay)/(4 gain) (K, L)
    loss: np.ndarray  # (1 − decay)/(4 gain) (K, L)
    increment: np.ndarray  # d before the step (K, L)
    moved: np.ndarray  # d_{n+1} + d_n (K, L)
    gap: np.ndarray  # g at t_{n−1}, t_n, t_{n+1} (3, C, L) [m]
    first: np.ndarray  # E at the start (L,) [J]
    energy: np.ndarray  # E after the step (r, L) [J]
    work: np.ndarray  # sums of works of the steps of this row (r, 5, L) [J]
    unexplained: np.ndarray  # sums of |what the balance of a step does not explain| (r, L) [J]
    negative: np.ndarray  # sum of the losses of single tips below zero (1, L) [J]

    @staticmethod
    @compiled
    def observe(lanes, bank, books, block, step, n_active):
        """Apply the forces of a step and enter their works; see ``contact.observers``."""
        scheme, state = bank.scheme, bank.state
        correct(lanes, scheme, state, n_active)
        n_rows = books.energy.shape[0]
        row = (block * scheme.bump.shape[0] + step) % n_rows
        old, work = books.energy[(row - 1) % n_rows].copy(), books.work[row]
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
        find_gaps(scheme, state, step, 0, books.gap[2])
        contact_work(scheme, state, n_active, books, work)
        books.gap[0], books.gap[1] = books.gap[1], books.gap[2]
        gained = work[CASING] + work[FRICTION] + work[EXTERNAL] - work[DAMPING] - work[IMPACT]
        books.unexplained[row] += np.abs(books.energy[row] - old - (gained - known))
        return 0

    @staticmethod
    def per_lane():
        """Arrays whose last axis are the lanes: all."""
        return Books._fields

    @classmethod
    def open(cls, bank, n_rows=1):
        """Books of a Bank at the start of its table; with one row they hold sums over all steps."""
        scheme, state = bank.scheme, bank.state
        inverse = np.divide(0.25, scheme.gain, np.zeros_like(scheme.gain), where=scheme.gain > 0.0)
        inertia, q, d = (1.0 + scheme.decay) * inverse, state.position, state.increment
        books = cls(
            inertia=inertia,
            loss=(1.0 - scheme.decay) * inverse,
            increment=d.copy(),
            moved=np.zeros_like(d),
            gap=np.zeros((3, scheme.normal.shape[1], bank.width)),
            first=np.sum(inertia * d**2 + scheme.squared[:, None] * q * (q - d) / 2.0, axis=0),
            energy=np.zeros((n_rows, bank.width)),
            work=np.zeros((n_rows, 5, bank.width)),
            unexplained=np.zeros((n_rows, bank.width)),
            negative=np.zeros((1, bank.width)),
        )
        books.energy[-1] = books.first
        for back, place in ((1, 0), (0, 1)):
            find_gaps(scheme, state, -1 - back, back, books.gap[place])
        return books


def audit(bank, n_blocks):
    """Integrate a Bank over blocks from the start of its table (bank is modified).

    Returns Books with one row for each step.
    """
    books = Books.open(bank, n_blocks * len(bank.scheme.bump))
    run(bank, n_blocks, books)
    return books


def accounts(books, lane):
    """What became of a lane's energy: `ACCOUNTS` (6,) [J]."""
    casing, friction, _, damping, impact = books.work[:, :, lane].sum(axis=0)
    stored = books.energy[-1, lane] - books.first[lane]
    return np.array([casing, friction, damping, impact, stored, books.unexplained[:, lane].sum()])


def is_balanced(books, lane):
    """Whether all energy of a lane is explained and no impact gave any."""
    turned_over = np.abs(books.work[:, :, lane]).sum() + abs(books.first[lane])
    wrong = max(books.unexplained[:, lane].sum(), -books.negative[0, lane])
    return bool(wrong <= TOLERANCE * turned_over)
