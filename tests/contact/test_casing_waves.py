"""A disk in contact with a casing that vibrates: turned pairs of modes in the time steps.

Truths: the same run with the casing at rest in its own frame, where the blades' places turn and
every projection is made anew at every step (`evidence.truth.ring`); the balance of energy; a casing
that is stiffer and stiffer becomes a rigid one; two masses that collide; a constant force that
travels around a ring; momentum.
"""

from typing import NamedTuple

import numpy as np
import pytest

from evidence.truth import energy, ring
from evidence.truth.disk import STEEL
from evidence.truth.motion import Structure, make_bank, recorded, wall
from evidence.validation.report import fitted_order
from hpcrub.contact.bank import allocate
from hpcrub.contact.integrate import run
from hpcrub.contact.jit import compiled
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
    "spatial rigid": ("spatial", {}),
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


def test_a_stiff_ring_is_a_rigid_casing(problem):
    """The difference goes with 1/E, and with the inverse of the mass of a pair that is heavy.

    With 1/E once the step is longer than the ring's periods: a shorter one resolves how it rings.
    """
    scene = problem.scene
    rigid = disk_in(problem, None)
    (q,) = whole(rigid, scene, [SPEED], 1.0 / SPEED, "position")

    def difference(casing):
        (found,) = whole(disk_in(problem, casing), scene, [SPEED], 1.0 / SPEED, "position")
        return np.abs(found - q).max() / np.abs(q).max()

    waves = np.arange(2, 6)
    stiff = [ring_modes(STEEL._replace(young=E), waves, 0.01) for E in (1e23, 1e24)]
    by_stiffness = [difference(casing) for casing in stiff]
    light = ring_modes(STEEL, waves, 0.01)
    by_mass = [
        difference(light._replace(radial=light.radial * s, tangential=light.tangential * s))
        for s in (1e-3, 1e-4)
    ]
    assert 0 < by_stiffness[0] < 1e-4
    assert by_stiffness[0] / by_stiffness[1] == pytest.approx(10, rel=0.1)
    assert by_mass[0] / by_mass[1] == pytest.approx(100, rel=0.1)


def test_a_force_that_travels_around_the_ring_deflects_it_as_in_closed_form():
    """Y (ω² − n²Ω² − 2iζω nΩ) = f, of a force f at rest for who turns with it.

    The error goes with h²: a force of the direction of the end of its step would come a step late.
    """
    modes, scene, speed = rubbing("planar", {"clearance": 1.0})
    casing = ring_modes(STEEL._replace(bed_radial=2e7, bed_tangential=2e6), np.arange(5), 0.2)
    modes = modes._replace(pairs=casing.seen_from(scene.interface.angle))
    outward, along = casing.rows(scene.interface.angle[:1])
    force, errors = (outward + scene.friction * along)[0], []
    for n_steps in (300, 600):
        bank = allocate(modes, scene, Grid(n_steps, 1, 1), 8, [speed])
        run(bank, 20, Pushing(np.array([0])))
        found = bank.state.position[len(modes.omega) :, 0]
        turn = casing.n_waves * 2 * np.pi * speed
        stiffness = casing.omega**2 - turn**2 - 2j * casing.damping_ratio * casing.omega * turn
        true = (force[::2] - 1j * force[1::2]) / stiffness
        errors.append(np.abs(found[::2] - 1j * found[1::2] - true).max() / np.abs(true).max())
    assert errors[1] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.1)


class Pushing(NamedTuple):
    """Observer that presses on the casing at one contact point with 1 N."""

    point: np.ndarray

    @staticmethod
    @compiled
    def observe(lanes, bank, pushing, block, step, n_active):
        """One point is active, whatever the contact law has found."""
        bank.state.active[:] = len(bank.state.multiplier) - 1
        bank.state.active[0] = pushing.point[0]
        bank.state.multiplier[pushing.point[0]] = 1.0
        return 1


def test_a_tip_that_hits_the_breathing_casing_goes_on_with_it():
    """Two masses that collide without restitution: their momentum is kept."""
    h, speed, gap = 1e-5, 2.0, 1e-3
    tip = Structure(np.array([1e-3]), np.array([1.5]), np.array([0.0]), 0.0, 0.0)
    casing = CasingModes(np.array([0]), np.array([1e-3]), np.zeros(1), np.array([0.8]), np.zeros(1))
    bank = make_bank(
        tip, wall(tip, gap), [h], 100,
        lambda modes: modes._replace(pairs=casing.seen_from(np.zeros(1))),
    )  # fmt: skip
    bank.state.increment[0, 0] = speed * h / tip.radial[0]
    run(bank, 2)  # 2 ms, the gap is closed after half a millisecond
    before, both = 1.0 / tip.radial[0] ** 2, 1.0 / tip.radial[0] ** 2 + 1.0 / 0.8**2
    q, d = bank.state.position[:, 0], bank.state.increment[:, 0]
    assert d[0] * tip.radial[0] / h == pytest.approx(speed * before / both, rel=1e-5)
    assert d[1] * casing.radial[0] / h == pytest.approx(speed * before / both, rel=1e-5)
    assert q[0] * tip.radial[0] - q[1] * casing.radial[0] == pytest.approx(gap, rel=1e-9)


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
