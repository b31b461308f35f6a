"""More contact points than blades: the kernel works on points, and knows of no blades.

Every blade of a small disk touches at its tip and at the node before it. Truth: dense central
differences whose contact forces are found by trying all sets of contacts, as in `test_kernel`.
"""

import numpy as np
import pytest

from evidence.truth.disk import make_disk, reference_scene
from hpcrub.model.interface import Interface
from hpcrub.model.reduction import craig_bampton, mistuned_modes
from hpcrub.response.linear import engine_order_response
from hpcrub.response.revolution import cut_revolution
from hpcrub.response.steady import SteadyCriteria, localisation
from hpcrub.response.sweep import run_sweep
from tests.contact.test_kernel import integrate_lanes, textbook

N_BLADES, SPEED = 4, 36.0
APART = 0.03  # [rad] from the tip to the second point
DEVIATION = np.array([-0.03, 0.02, 0.04, -0.01])


@pytest.fixture(scope="module")
def reduced():
    tuned = make_disk(n_blades=N_BLADES, blade={"n_elements": 3})
    before = tuned.blade_dof[:, -6:-4]
    two = tuned._replace(
        contact_dof=np.vstack([tuned.contact_dof, before]),
        contact_blade=np.tile(np.arange(N_BLADES), 2),
        contact_angle=np.concatenate([tuned.contact_angle, tuned.contact_angle - APART]),
        contact_radius=np.concatenate([tuned.contact_radius, tuned.contact_radius]),
    )
    return craig_bampton(two, 0)


def scene_of(reduced, **changes):
    defaults = {"interface": reduced.interface, "scheme": "central_difference"}
    return reference_scene(**(defaults | changes))


def test_two_points_a_blade_are_the_textbook_scheme(reduced):
    modes, scene = mistuned_modes(reduced, DEVIATION), scene_of(reduced)
    assert modes.normal.shape == (2 * N_BLADES, 4 * N_BLADES)
    history, _ = integrate_lanes(modes, scene, [SPEED], n_blocks=2, width=8)
    tips, forces = textbook(reduced, modes, scene, SPEED, len(history))
    touches = forces.reshape(len(tips), -1, 2, N_BLADES).any(axis=1)  # tip or second point
    assert touches.all(axis=1).any()  # both points of a blade at once
    assert np.abs(history[:, :, 0] - tips).max() < 1e-9 * np.abs(tips).max()


def test_a_sweep_looks_at_all_points_and_counts_blades(reduced):
    """Largest |u_t| of any point, and of each blade, in the second of two revolutions."""
    modes = mistuned_modes(reduced, DEVIATION)
    steady = SteadyCriteria(first_check=0.01, window_revolutions=1, max_time=2.0 / SPEED)
    scene = scene_of(reduced, step=1.0 / (1500 * SPEED), steady=steady, damping_ratio=0.05)
    n_steps = cut_revolution(SPEED, scene).steps_per_revolution
    result = run_sweep(modes, scene, [SPEED])
    tips, _ = textbook(reduced, modes, scene, SPEED, 2 * n_steps, n_steps)
    assert result.time == pytest.approx(2.0 / SPEED)
    last = tips[n_steps:]  # every step, whatever is recorded
    assert result.amplitude == pytest.approx(np.abs(last).max(), rel=1e-6)
    blades = np.abs(last).reshape(-1, 2, N_BLADES).max(axis=(0, 1))
    assert result.localisation[0] == pytest.approx(localisation(blades), rel=1e-6)


def test_an_engine_order_excitation_loads_blades():
    """Twice the same contact points: each carries half the load of its blade, which moves alike."""
    one = craig_bampton(make_disk(n_blades=N_BLADES, blade={"n_elements": 3}), 0).interface
    two = Interface(*(np.concatenate([values, values]) for values in one))
    speeds = np.array([20.0, 21.0])
    reduced = craig_bampton(make_disk(n_blades=N_BLADES, blade={"n_elements": 3}), 0)
    answers = [
        engine_order_response(
            mistuned_modes(reduced._replace(interface=points), DEVIATION),
            0.005, 150.0, 2, points, speeds,
        )
        for points in (one, two)
    ]  # fmt: skip
    np.testing.assert_allclose(answers[1][:, :N_BLADES], answers[0], rtol=1e-12)
