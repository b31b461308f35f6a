"""The energy audit in plain Python and NumPy: the twin of `evidence.validation.energy_balance`."""

from typing import NamedTuple

import numpy as np

from evidence.truth.motion import single_steps
from hpcrub.model import casing


class Ledger(NamedTuple):
    """Energy and works of n steps, L lanes."""

    energy: np.ndarray  # E (n + 1, L) before the first and after every step [J]
    casing: np.ndarray  # work of the casing's motion in every step (n, L) [J]
    friction: np.ndarray  # work of friction (n, L) [J]
    external: np.ndarray  # work of the external forces (n, L) [J]
    damping: np.ndarray  # D, dissipated (n, L) [J]
    impact: np.ndarray  # loss in impacts (n, L) [J]

    def residual(self):
        """What the balance of every step fails to explain (n, L) [J]: rounding, or a defect."""
        gained = self.casing + self.friction + self.external
        return np.diff(self.energy, axis=0) - (gained - self.damping - self.impact)


def audit(bank, n_steps):
    """Integrate a Bank in time, at the start of its table, and account for its energy.

    Args:
        bank: arrays.Bank (modified).
        n_steps: how far.

    Returns:
        Ledger. Idle lanes have zeros.
    """
    scheme, state = bank.scheme, bank.state
    inverse = np.divide(1.0, scheme.gain, out=np.zeros_like(scheme.gain), where=scheme.gain > 0.0)
    inertia, loss = (1.0 + scheme.decay) * inverse / 4.0, (1.0 - scheme.decay) * inverse / 4.0
    spring = scheme.squared[:, None] / 2.0
    q, d = state.position.copy(), state.increment.copy()
    start = state.n_steps.copy()
    gap_before, gap = _gap(bank, q - d, start, -1), _gap(bank, q, start, 0)
    energy = [np.sum(inertia * d**2 + spring * q * (q - d), axis=0)]
    works = []
    for n in single_steps(bank, n_steps):
        q_before, d_before = q, d
        q, d = state.position.copy(), state.increment.copy()
        gap_two_before, gap_before, gap = gap_before, gap, _gap(bank, q, start, n)
        moved = d + d_before
        force, normal, friction = _contact_work(bank, moved)
        impact = np.sum(force * (gap_two_before - gap), axis=0) / 2.0
        external = scheme.external[(n - 1) % len(scheme.bump)] if len(scheme.external) else 0.0
        works.append(
            (
                normal + impact,
                friction,
                np.sum(np.reshape(external, (-1, 1)) * moved, axis=0) / 2.0,
                np.sum(loss * moved**2, axis=0),
                impact,
            )
        )
        energy.append(np.sum(inertia * d**2 + spring * q * q_before, axis=0))
    return Ledger(np.array(energy), *np.moveaxis(np.array(works), 1, 0))


def _gap(bank, q, start, n):
    """Gaps g after n steps of a run that began at step ``start`` of each lane (n_c, L) [m]."""
    scheme, n_points = bank.scheme, _n_points(bank)
    t = np.maximum(start + n, 0) * scheme.step
    grown = np.array([casing.ramp(time, scheme.ramp_time) for time in t])
    bump = scheme.bump[(n - 1) % len(scheme.bump), :n_points, None]
    clearance = scheme.clearance + scheme.own[0, :n_points, None]
    return clearance - grown * bump - scheme.normal[:, :n_points].T @ q


def _contact_work(bank, moved):
    """Contact forces of the last step and their works over half of ``moved`` = d_{n+1} + d_n.

    Returns λ (n_c, L) [N] and the works of the normal forces and of friction (L,) [J].
    """
    n_points = _n_points(bank)
    force = bank.state.multiplier[:n_points]
    normal, load = (table[:, :n_points].T for table in (bank.scheme.normal, bank.scheme.load))
    along = (load + normal) @ moved / 2.0  # −μ u_t
    return force, np.sum(-force * (normal @ moved / 2.0), axis=0), np.sum(force * along, axis=0)


def _n_points(bank):
    """Contact points, without those of the padding, that nothing reaches."""
    return np.count_nonzero(np.isfinite(bank.scheme.own))
