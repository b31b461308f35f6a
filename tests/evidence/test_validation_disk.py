"""The disk against full matrices with an implicit scheme, and under a load against closed forms."""

import numpy as np
import pytest

from evidence.truth.disk import MATERIAL, disk_section, mistune, reference_reduced, reference_scene
from evidence.validation import full_disk, linear_load
from evidence.validation.report import fitted_order
from hpcrub.contact.status import STEADY
from hpcrub.model.disk import build_disk
from hpcrub.model.reduction import craig_bampton, mistuned_modes
from hpcrub.response.steady import SteadyCriteria
from hpcrub.response.sweep import run_sweep

DAMPING_RATIO = 0.02
SPEEDS = np.array([33.25, 34.5])


def test_periodic_contact_of_a_mistuned_disk_is_that_of_its_full_matrices():
    """12 blades of two elements, all modes kept: both programs solve the same equations."""
    deviation = np.linspace(-0.02, 0.02, 12)[[3, 8, 1, 11, 5, 0, 9, 2, 6, 10, 4, 7]]
    tuned = build_disk(disk_section(blade={"n_elements": 2}), MATERIAL)
    n_modes = len(tuned.mass) - 24
    reduced = craig_bampton(tuned, n_modes)
    modes = mistuned_modes(reduced, deviation)
    scene = reference_scene(
        interface=reduced.interface,
        damping_ratio=DAMPING_RATIO,
        scheme="exact_modal",
        step=4e-6,
        steady=SteadyCriteria(first_check=0.4, max_time=0.4),
    )
    result = run_sweep(modes, scene, SPEEDS, width=8)
    full = mistune(tuned, deviation)
    casing = full_disk.Casing()
    before, last = full_disk.amplitudes(full, DAMPING_RATIO, casing, SPEEDS, 1e-5, 0.4)
    assert (result.point_status == STEADY).all()
    assert np.abs(before / last - 1.0).max() < 5e-3
    assert np.abs(result.amplitude / last - 1.0).max() < 0.01
    assert last.min() > 5e-3


@pytest.mark.parametrize("name", ["central_difference", "exact_modal"])
def test_a_load_in_time_gives_the_closed_form_response(name):
    reduced = reference_reduced(12)
    modes = mistuned_modes(reduced, np.linspace(-0.03, 0.03, 12))
    divisions = np.array([256, 512, 1024])
    errors = linear_load.errors(modes, reduced.interface, name, divisions)
    assert 1.95 < fitted_order(1.0 / divisions, errors) < 2.05
    assert errors[-1] < 1e-4


def test_an_impact_of_the_independent_scheme_takes_the_whole_velocity():
    """A free mass with 2 m/s in 1 mm from a wall at rest: e = 0, it stays; none is thrown back."""
    model = full_disk.Model(
        np.eye(2), np.zeros((2, 2)) + 1e-9 * np.eye(2), np.array([[0, 1]]), np.zeros(1)
    )
    wall = full_disk.Casing(n_bumps=1, height=0.0, clearance=1e-3, friction=1.0)
    for h in (1e-4, 0.7e-4, 0.31e-4):
        start = np.zeros((2, 1)), np.array([[2.0], [0.0]]), np.zeros(1)
        ends = [
            full_disk.amplitudes(model, 0.0, wall, [1.0], h, t, start=start)[1, 0]
            for t in (0.01, 0.02)
        ]
        # friction p = 2 along −t is all that moves it after the impact: −2 m/s
        assert abs((ends[1] - ends[0]) / 0.01 - 2.0) < 2e-2


def test_the_impulses_solve_their_complementarity_problem():
    rng = np.random.default_rng(5)
    for _ in range(50):
        A = rng.normal(size=(6, 6))
        W = A @ A.T + 6.0 * np.eye(6)
        approach = rng.normal(size=6)
        approach[0] = abs(approach[0])
        p = full_disk._impulses(W, approach)
        rest = approach - W @ p
        assert p.min() >= 0.0
        assert rest.max() < 1e-9
        assert np.abs(p * rest).max() < 1e-9
