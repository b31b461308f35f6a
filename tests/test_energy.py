"""Energy audit: the balance of the two-step scheme, and of what it must tell.

Theory: docs/theory.md. The balance holds to rounding for any scheme, kinematics and friction. The
impact loss is λ g_{n−1}/2 ≥ 0 for small kinematics. A mass that hits a fixed wall loses m v²/2.
"""

import numpy as np
import pytest

from hpcrub import casing, energy, kernel
from validation.energy_audit import REVOLUTION, SPEEDS, bank_of
from validation.motion import Structure, make_bank, start_free

N_STEPS = 1500
SCHEMES = ["central_difference", "exact_modal"]


@pytest.mark.parametrize("kinematics", ["small", "polar"])
@pytest.mark.parametrize("name", SCHEMES)
def test_audit_of_the_disk_closes_to_rounding(kinematics, name):
    ledger = energy.audit(bank_of(kinematics, name, n_modes=12), N_STEPS)
    lanes = slice(0, len(SPEEDS))
    assert (ledger.impact[:, lanes].sum(axis=0) > 1.0).all()  # J: contact did occur
    assert (ledger.friction[:, lanes].sum(axis=0) < -1.0).all()
    assert np.abs(ledger.residual()).max() < 1e-13 * ledger.energy.max()
    whole = np.abs(ledger.residual().sum(axis=0)[lanes])
    assert (whole < 1e-13 * ledger.turnover()[lanes]).all()
    assert ledger.damping.min() >= 0.0
    if kinematics == "small":
        assert ledger.impact.min() > -1e-12 * ledger.impact.max()
    else:
        assert ledger.impact.min() > -1e-2 * ledger.impact.max()
    assert not ledger.energy[:, len(SPEEDS) :].any()  # idle lanes


def test_work_of_the_casing_is_that_of_its_moving_surface():
    bank = bank_of("small", "central_difference", n_modes=12)
    h = bank.scheme.step[1]
    forces = np.array(
        [bank.state.multiplier[:12, 1].copy() for _ in energy.single_steps(bank, 900)]
    )
    ledger = energy.audit(bank_of("small", "central_difference", n_modes=12), 900)

    n = np.arange(-1, 901)
    angle = 2.0 * np.pi * (n[:, None] / REVOLUTION + np.arange(12) / 12.0)
    grown = np.array([casing.growth(max(0.0, k * h), 0.01) for k in n])
    surface = 0.25e-3 - grown[:, None] * casing.bump_height(angle, 4, 1.25e-3)
    work = -np.sum(forces * (surface[2:] - surface[:-2]), axis=1) / 2.0
    assert np.abs(ledger.casing[:, 1] - work).max() < 1e-9 * np.abs(work).max()
    assert np.abs(work).max() > 1e-3


@pytest.mark.parametrize("name", SCHEMES)
def test_a_mass_that_hits_a_wall_loses_its_kinetic_energy(name):
    """A free mass of 0.25 kg: R = 2, q' = 3 → 4.5 J, all lost; nothing else happens."""
    mass = Structure(np.zeros(1), np.full(1, 2.0), np.zeros(1), 0.0, 0.0)
    steps = [1e-3, 1.3e-4]
    bank = make_bank(mass, name, steps, clearance=0.1234)
    start_free(bank, mass, np.zeros(1), np.full(1, 3.0), steps)
    ledger = energy.audit(bank, 400)
    assert np.abs(ledger.impact.sum(axis=0)[:2] / 4.5 - 1.0).max() < 1e-12
    assert np.abs(ledger.energy[-1]).max() < 1e-12
    assert np.count_nonzero(ledger.impact[:, 0]) <= 2  # two steps: reach the wall, stay there


def test_single_steps_are_the_march_of_the_studies():
    by_step, at_once = (bank_of("small", "exact_modal", n_modes=12) for _ in range(2))
    n_rows = len(by_step.scheme.bump)
    for _ in energy.single_steps(by_step, 2 * n_rows):
        pass
    kernel.march((0,) * 8, *at_once, 2, -1, 1)
    assert np.abs(at_once.state.position).max() > 0.0
    scale = np.abs(at_once.state.position).max()
    assert np.abs(by_step.state.position - at_once.state.position).max() < 1e-12 * scale
