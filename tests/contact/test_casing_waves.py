"""A disk in contact with a casing that vibrates: turned pairs of modes in the time steps.

Truths: the same run with the casing at rest in its own frame, where the blades' places turn and
every projection is made anew at every step (`evidence.truth.ring`); the balance of energy;
momentum.
"""

import numpy as np
import pytest

from evidence.truth import energy, ring
from evidence.truth.disk import STEEL
from evidence.truth.motion import recorded
from evidence.validation.report import fitted_order
from hpcrub.contact.bank import allocate
from hpcrub.model.casing_modes import CasingModes, ring_modes
from hpcrub.model.coating import ElasticCasing
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.revolution import Grid, cut_revolution
from tests.contact.laws.test_coating import KINDS, rubbing
from tests.program import whole

SPEED = 34.0


def disk_in(problem, casing, deviation=0.04):
    """Modes of a mistuned disk in a casing."""
    reduced = problem.reduced._replace(casing=casing)
    return mistuned_modes(reduced, stiffness_deviation(5, 0, 0, 12, deviation))


def test_seen_from_the_rotor_as_in_the_frame_of_the_casing(problem):
    casing = ring_modes(STEEL, np.arange(2, 6), 0.01)
    scene = problem.scene._replace(scheme="exact_modal", record_interval=0.0, step=2e-5)
    modes, n = disk_in(problem, casing), cut_revolution(SPEED, scene).steps_per_revolution
    names = "position", "casing", "normal_force"
    q, pairs, force = whole(modes, scene, [SPEED], 2.0 / SPEED, *names)
    true = ring.integrate(
        modes.omega, scene.damping_ratio, modes.normal, modes.tangential, scene.interface.angle,
        casing, ring.wall_of(scene), SPEED, n, len(q),
    )  # fmt: skip
    assert np.ptp(true.ring, axis=0).max() > 0
    assert true.force.any()
    np.testing.assert_allclose(q[:, :, 0], true.disk, rtol=0, atol=1e-9 * np.abs(true.disk).max())
    turned = np.arange(1, len(q) + 1)[:, None] * 2 * np.pi * casing.n_waves / n
    y = (true.ring[:, ::2] - 1j * true.ring[:, 1::2]) * np.exp(1j * turned)
    found = pairs[:, ::2, 0] - 1j * pairs[:, 1::2, 0]
    np.testing.assert_allclose(found, y, rtol=0, atol=1e-9 * np.abs(y).max())


@pytest.mark.parametrize("law", [None, ElasticCasing(2.4e7)], ids=["rigid", "elastic"])
def test_the_error_of_a_motion_goes_with_the_square_of_the_step(problem, law):
    """Of disk and ring; with the direction of the end of a step it went with the step."""
    casing = ring_modes(STEEL._replace(thickness=0.04), np.arange(2, 9), 0.005)
    scene = problem.scene._replace(scheme="exact_modal", elastic_casing=law)
    modes, n = disk_in(problem, casing), 900

    def motion(finer):
        bank = allocate(modes, scene, Grid(n * finer, 1, 1), 8, [SPEED])
        found = np.concatenate([part.position[:, :, 0] for part in recorded(bank, n * finer)])
        return modes.of_rows(found[finer - 1 :: finer])

    fine, finer = motion(32), np.array([2, 4, 8])
    found = [motion(m) for m in finer]
    for part in (0, 1):
        errors = [np.abs(parts[part] - fine[part]).max() for parts in found]
        assert fitted_order(1.0 / finer, errors) > 1.6


SCENES = {
    "planar rigid": ("planar", {}),
    "spatial both": KINDS["spatial both"],
}


@pytest.mark.parametrize("name", SCENES)
def test_energy_of_disk_casing_friction_and_shaft_is_balanced(name):
    modes, scene, speed = rubbing(*SCENES[name])
    casing = CasingModes(
        np.array([0, 2, 3]), 0.7 * modes.omega[[0, 2, 4]], np.full(3, 0.01),
        *(np.abs(modes.normal).max() * np.array([[0.7, 1.0, 0.8], [0.0, -0.5, -0.3]])),
    )  # fmt: skip
    modes = modes._replace(pairs=casing.seen_from(scene.interface.angle))
    bank = allocate(modes, scene, Grid(1200, 1, 1), 8, [speed])
    books = energy.audit(bank, 2400, scene)
    assert np.ptp(bank.state.position[len(modes.omega) :, 0]) > 0
    assert books.unexplained()[0] < 1e-11
    assert books.impact[:, 0].sum() + books.elastic[:, 0].max() > 0.0


def test_a_ring_on_a_soft_bed_takes_the_impulse_of_the_contact(problem):
    """M v of the whole ring is the sum of all normal and friction forces, each in its direction."""
    ring_ = STEEL._replace(bed_radial=1.0, bed_tangential=1.0)
    casing, scene = ring_modes(ring_, np.array([1, 2]), 0.0), problem.scene
    scene = scene._replace(record_interval=0.0)
    time, pairs, *forces = whole(
        disk_in(problem, casing), scene, [SPEED], 1.0 / SPEED,
        "time", "casing", "normal_force", "tangential_force",
    )  # fmt: skip
    normal, friction = (force[:, :, 0] for force in forces)
    h = time[0, 0]
    theta = scene.interface.angle + 2 * np.pi * SPEED * (time - h)  # at the begin of a step
    along_x = normal * np.cos(theta) - friction * np.sin(theta)
    impulse = np.cumsum(along_x.sum(axis=1)) * h
    y = (pairs[:, 0, 0] - 1j * pairs[:, 1, 0]) * np.exp(-2j * np.pi * SPEED * time[:, 0])
    mass = STEEL.density * STEEL.width * STEEL.thickness * 2 * np.pi * STEEL.radius
    momentum = mass * casing.radial[0] * np.diff(y.real) / h
    np.testing.assert_allclose(momentum, impulse[1:], rtol=0, atol=1e-6 * np.abs(impulse).max())
