"""A disk in contact with a casing that vibrates: turned pairs of modes in the time steps.

Truths: the same run with the casing at rest in its own frame, where the blades' places turn and
every projection is made anew at every step (`evidence.truth.ring`); the balance of energy; a casing
that is stiffer and stiffer becomes a rigid one; two masses that collide; a constant force that
travels around a ring; momentum.
"""

import numpy as np
import pytest

from evidence.truth import energy, ring
from hpcrub.config.schema import Config
from hpcrub.contact.bank import allocate
from hpcrub.contact.laws.planar import Planar
from hpcrub.contact.laws.solid import Solid
from hpcrub.model.casing_modes import CasingModes, Ring, ring_modes
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.revolution import cut_revolution
from hpcrub.setup.problem import build_problem
from tests.program import TINY, whole

STEEL = Ring(radius=0.5025, thickness=0.02, width=0.1, young=2.1e11, density=7800.0)
SPEED = 34.0


@pytest.fixture(scope="module")
def problem():
    return build_problem(Config.from_yaml(TINY))


def disk_in(problem, casing, deviation=0.04):
    """Modes of a mistuned disk in a casing."""
    reduced = problem.reduced._replace(casing=casing)
    return mistuned_modes(reduced, stiffness_deviation(5, 0, 0, 12, deviation))


def in_its_frame(problem, modes, casing, n_steps):
    """The same run of n steps in the frame of the casing (`ring.Run`)."""
    scene = problem.scene
    grid = cut_revolution(SPEED, scene)
    return ring.integrate(
        modes.omega, scene.damping_ratio, modes.normal, modes.tangential, scene.interface.angle,
        ring.Ring(*casing), ring.Wall(scene.n_bumps, scene.bump_height, scene.clearance,
                                      scene.friction, scene.ramp_time),
        SPEED, grid.steps_per_revolution, n_steps,
    )  # fmt: skip


def test_seen_from_the_rotor_as_in_the_frame_of_the_casing(problem):
    casing = ring_modes(STEEL, np.arange(2, 6), 0.01)
    scene = problem.scene._replace(scheme="exact_modal", record_interval=0.0, step=2e-5)
    modes, problem = disk_in(problem, casing), problem._replace(scene=scene)
    q, pairs, force = whole(
        modes, scene, [SPEED], 2.0 / SPEED, "position", "casing", "normal_force"
    )
    true = in_its_frame(problem, modes, casing, len(q))
    assert np.ptp(true.ring, axis=0).max() > 0 and true.force.any()
    np.testing.assert_allclose(q[:, :, 0], true.disk, rtol=0, atol=1e-9 * np.abs(true.disk).max())
    turned = np.arange(1, len(q) + 1)[:, None] * 2 * np.pi * casing.n_waves
    turned = turned / cut_revolution(SPEED, scene).steps_per_revolution
    y = (true.ring[:, ::2] - 1j * true.ring[:, 1::2]) * np.exp(1j * turned)
    found = pairs[:, ::2, 0] - 1j * pairs[:, 1::2, 0]
    np.testing.assert_allclose(found, y, rtol=0, atol=1e-9 * np.abs(y).max())
