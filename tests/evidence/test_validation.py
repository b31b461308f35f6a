"""Validation: the bouncing bar, the whole disk and the cantilever with a stop.

Truth: the exact solution of the bar (`validation.bouncing_bar` derives it), full matrices with an
implicit scheme, and a reference that goes from event to event. The moving wall and the load in
time have the same thresholds in `make validate ARGS=--fast`.
"""

import numpy as np
import pytest

from evidence.truth import moreau_jean
from evidence.truth.disk import MATERIAL, disk_section, mistune, reference_scene
from evidence.truth.events import Reference, fixed_wall
from evidence.truth.ring import Wall
from evidence.validation import bouncing_bar as bar
from evidence.validation import cantilever
from evidence.validation.report import SCHEMES, fitted_order
from hpcrub.contact.status import STEADY
from hpcrub.model.disk import build_disk
from hpcrub.model.reduction import craig_bampton, mistuned_modes
from hpcrub.response.steady import SteadyCriteria
from hpcrub.response.sweep import run_sweep


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


DAMPING_RATIO = 0.02
SPEEDS = np.array([33.25, 34.5])


def test_periodic_contact_of_a_mistuned_disk_is_that_of_its_full_matrices():
    """12 blades of two elements, all modes kept: both programs solve the same equations."""
    deviation = np.linspace(-0.02, 0.02, 12)[[3, 8, 1, 11, 5, 0, 9, 2, 6, 10, 4, 7]]
    tuned = build_disk(disk_section(blade={"n_elements": 2}), MATERIAL)
    n_modes = len(tuned.mass) - 24
    reduced = craig_bampton(tuned, n_modes)
    modes = mistuned_modes(reduced, deviation)
    how = {"damping_ratio": DAMPING_RATIO, "scheme": "exact_modal", "step": 4e-6}
    steady = SteadyCriteria(first_check=0.4, max_time=0.4)
    scene = reference_scene(interface=reduced.interface, steady=steady, **how)
    result = run_sweep(modes, scene, SPEEDS, width=8)
    full = moreau_jean.unreduced(mistune(tuned, deviation))
    before, last = moreau_jean.amplitudes(full, DAMPING_RATIO, Wall(), SPEEDS, 1e-5, 0.4)
    assert (result.point_status == STEADY).all()
    assert np.abs(before / last - 1.0).max() < 5e-3
    assert np.abs(result.amplitude / last - 1.0).max() < 0.01
    assert last.min() > 5e-3


def test_reference_of_the_cantilever_balances_its_energy():
    """Without damping: energy at the start − losses in impacts = energy at the end."""
    structure, q, v = cantilever.beam(4)
    structure = structure._replace(damping_ratio=0.0)
    motion = Reference(structure, fixed_wall(cantilever.GAP), 0.15 / 1600).run(q, v, 1600)
    q, v = motion.position, motion.velocity
    energy = np.sum(v**2 + (structure.omega * q) ** 2, axis=1) / 2.0
    assert len(motion.impacts) >= 3
    assert abs(energy[-1] - (energy[0] - motion.lost)) < 1e-9 * energy[0]
    assert (q @ structure.radial).max() < cantilever.GAP + 1e-12


@pytest.mark.parametrize("name", SCHEMES)
def test_cantilever_with_a_stop_converges_to_the_events(name):
    divisions = 800 * 2 ** np.arange(4)
    error = cantilever.step_errors(2, name, divisions)
    assert len(cantilever.reference(2, 1600).impacts) >= 3
    assert fitted_order(1.0 / divisions, error) > 0.7
    assert error[-1] < 2e-3


def test_cantilever_with_eight_modes_converges_to_the_events():
    divisions = 6400 * 2 ** np.arange(3)
    error = cantilever.step_errors(8, "exact_modal", divisions)
    assert fitted_order(1.0 / divisions, error) > 0.7
    assert error[-1] < 1e-4


def test_cantilever_converges_in_modes():
    modes = np.array([1, 2, 4, 8])
    by_events, by_kernel = cantilever.mode_errors(modes, 16, 6400)
    assert fitted_order(1.0 / modes, by_events) > 1.0
    assert np.abs(by_kernel / by_events - 1.0).max() < 0.1
