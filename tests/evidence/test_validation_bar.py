"""Bouncing bar against its exact solution (`validation.bouncing_bar` derives it)."""

import numpy as np
import pytest

from evidence.validation import bouncing_bar as bar
from evidence.validation.report import fitted_order
from hpcrub.contact.integrate import run
from hpcrub.contact.observers import Record

SCHEMES = ["central_difference", "exact_modal"]


def test_exact_solution_keeps_its_energy_and_never_penetrates():
    x = np.linspace(0.0, bar.LENGTH, 4001)
    for t in np.linspace(0.0, 8.0, 47):
        u, v, _ = bar.exact(x, t)
        strain = np.gradient(u, x)
        density = v**2 / 2.0 + bar.E * strain**2 / 2.0 + bar.GRAVITY * u
        whole = np.sum((density[1:] + density[:-1]) / 2.0) * x[1]
        assert abs(whole / (bar.LENGTH * bar.GRAVITY * bar.HEIGHT) - 1.0) < 2e-3  # kinks
        assert u[0] >= -1e-12


def test_exact_solution_obeys_newton_for_the_whole_bar():
    """Momentum gained = impulse of the pressure − weight, over the first cycle."""
    t = np.linspace(0.0, bar.PERIOD, 200_001)
    pressure = bar.exact(0.0, t)[2]
    x = (np.arange(2000) + 0.5) * bar.LENGTH / 2000
    for end in (1.2, 1.6, 2.5, 3.9, 5.0):
        momentum = bar.exact(x, end)[1].mean() * bar.LENGTH
        impulse = np.sum(pressure[t <= end]) * t[1]
        weight = bar.LENGTH * bar.GRAVITY * end
        assert abs(momentum - (impulse - weight)) < 1e-2 * weight


@pytest.mark.parametrize(
    ("name", "lumped", "ratio", "order"),
    [
        ("central_difference", True, 0.98, 0.9),
        ("exact_modal", True, 0.98, 0.6),
        ("central_difference", False, 0.5, 0.55),
        ("exact_modal", False, 0.5, 0.55),
    ],
)
def test_bar_converges_to_the_exact_motion(name, lumped, ratio, order):
    """Order one where waves are carried without dispersion, two thirds where they are not."""
    meshes = np.array([20, 40, 80, 160])
    rows = []
    for n in meshes:
        motion = bar.bounce(n, name, ratio * bar.critical_step(n, lumped), bar.PERIOD, lumped)
        rows.append(bar.errors(motion, bar.PERIOD))
    displacement, velocity, pressure, impulse = np.array(rows).T
    assert fitted_order(1.0 / meshes, displacement) > order
    assert fitted_order(1.0 / meshes, impulse) > order
    assert displacement[-1] < 0.07
    assert fitted_order(1.0 / meshes, velocity) > 0.25
    assert fitted_order(1.0 / meshes, pressure) > 0.2


@pytest.mark.parametrize("name", SCHEMES)
def test_first_impact_takes_the_energy_of_the_foot(name):
    """(M⁻¹)_00 of the consistent mass is 2√3/(ρΔx) in the limit: the foot weighs 0.289 ρΔx."""
    n = 80
    _, lost = bar.lost_energy(n, name, bar.critical_step(n) / 10.0, bar.FALL + 0.2)
    foot = bar.RHO * bar.LENGTH / n / (2.0 * np.sqrt(3.0))
    expected = foot * bar.V0**2 / 2.0 / (bar.RHO * bar.LENGTH * bar.GRAVITY * bar.HEIGHT)
    assert abs(lost[-1] / expected - 1.0) < 0.05
    assert np.diff(lost).min() > -1e-12


def test_recorded_motion_is_that_of_the_single_steps():
    step = bar.critical_step(20) / 2.0
    n = int(2.0 / step)
    bank, _ = bar.falling_bank(20, "central_difference", step, n)
    record = Record.allocate(bank, 1, 1)
    run(bank, 1, record)
    recorded = bar.HEIGHT + record.history.reshape(n, -1, 8)[:, 0, 0]
    _, u, _, force = bar.bounce(20, "central_difference", step, (n + 0.5) * step)
    assert force.max() > 0.0
    assert np.abs(recorded - u[1:]).max() < 1e-12
