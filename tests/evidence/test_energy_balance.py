"""Energy audit: the balance of the two-step scheme, and of what it must tell.

Theory: docs/theory.md. The balance holds to rounding for any scheme and friction. The impact loss
is λ g_{n−1}/2 ≥ 0. A mass that hits a fixed wall loses m v²/2.
"""

import numpy as np
import pytest

from evidence.truth.disk import earlier_reduced
from evidence.truth.energy import audit as plain_audit
from evidence.truth.motion import Structure, make_bank, single_steps, start_free
from evidence.validation import energy_balance
from evidence.validation.coating import MILD, SOFT
from evidence.validation.energy_audit import REVOLUTION, SPEEDS, bank_of
from hpcrub.contact.bank import allocate
from hpcrub.contact.integrate import run
from hpcrub.model import casing
from hpcrub.model.coating import ElasticCasing
from hpcrub.response.revolution import Grid
from tests.contact.test_coating import KINDS, rubbing

N_BLOCKS, N_ROWS = 2, REVOLUTION // 4
SCHEMES = ["central_difference", "exact_modal"]
LANES = slice(0, len(SPEEDS))


@pytest.mark.parametrize("name", SCHEMES)
def test_audit_of_the_disk_closes_to_rounding(name):
    books = energy_balance.audit(bank_of(name, n_modes=12), N_BLOCKS)
    work = books.work[:, :, LANES]
    assert (work[:, energy_balance.IMPACT].sum(axis=0) > 1.0).all()  # J: contact did occur
    assert (work[:, energy_balance.FRICTION].sum(axis=0) > 1.0).all()  # J: blades yield its way
    turned_over = np.abs(work).sum(axis=(0, 1))
    assert (books.unexplained[:, LANES].sum(axis=0) < 1e-11 * turned_over).all()
    assert books.unexplained.max() < 1e-13 * books.energy.max()
    assert work[:, energy_balance.DAMPING].min() >= 0.0
    assert (-books.negative[0, LANES] < 1e-12 * turned_over).all()
    assert all(energy_balance.is_balanced(books, lane) for lane in range(len(SPEEDS)))
    assert not books.energy[:, len(SPEEDS) :].any()  # idle lanes


@pytest.mark.parametrize("name", SCHEMES)
def test_audit_is_that_of_its_twin(name):
    earlier = earlier_reduced(12)  # whose motion lets rounding grow less than the reference disk's
    books = energy_balance.audit(bank_of(name, reduced=earlier), N_BLOCKS)
    twin = plain_audit(bank_of(name, reduced=earlier), N_BLOCKS * N_ROWS)
    works = np.stack([twin.casing, twin.friction, twin.external, twin.damping, twin.impact], axis=1)
    assert np.abs(books.work - works).max() < 1e-9 * np.abs(works).max()
    assert np.abs(books.energy - twin.energy[1:]).max() < 1e-10 * twin.energy.max()
    assert np.abs(twin.residual()).max() < 1e-13 * twin.energy.max()


def test_impacts_that_give_energy_are_found():
    """Half the compliance, double the force: a tip is thrown back, with a work that balances."""
    bank = bank_of("exact_modal", n_modes=12)
    bank.law.stiffness[:] *= 2.0
    books = energy_balance.audit(bank, N_BLOCKS)
    turned_over = np.abs(books.work[:, :, LANES]).sum(axis=(0, 1))
    assert (books.unexplained[:, LANES].sum(axis=0) < 1e-11 * turned_over).all()
    assert not any(energy_balance.is_balanced(books, lane) for lane in range(len(SPEEDS)))


def test_work_of_the_casing_is_that_of_its_moving_surface():
    n = N_BLOCKS * N_ROWS
    bank = bank_of("central_difference", n_modes=12)
    h = bank.scheme.step[1]
    forces = np.array([bank.state.multiplier[:12, 1].copy() for _ in single_steps(bank, n)])
    books = energy_balance.audit(bank_of("central_difference", n_modes=12), N_BLOCKS)

    step = np.arange(-1, n + 1)
    angle = 2.0 * np.pi * (step[:, None] / REVOLUTION + np.arange(12) / 12.0)
    grown = np.array([casing.ramp(max(0.0, k * h), 0.01) for k in step])
    surface = 0.25e-3 - grown[:, None] * casing.bump_height(angle, 4, 1.25e-3)
    work = -np.sum(forces * (surface[2:] - surface[:-2]), axis=1) / 2.0
    assert np.abs(books.work[:, energy_balance.CASING, 1] - work).max() < 1e-9 * np.abs(work).max()
    assert np.abs(work).max() > 1e-3


@pytest.mark.parametrize("name", SCHEMES)
def test_a_mass_that_hits_a_wall_loses_its_kinetic_energy(name):
    """A free mass of 0.25 kg: R = 2, q' = 3 → 4.5 J, all lost; nothing else happens."""
    mass = Structure(np.zeros(1), np.full(1, 2.0), np.zeros(1), 0.0, 0.0)
    steps = [1e-3, 1.3e-4]
    bank = make_bank(mass, name, steps, clearance=0.1234)
    start_free(bank, mass, np.zeros(1), np.full(1, 3.0), steps)
    books = energy_balance.audit(bank, 400)
    impact = books.work[:, energy_balance.IMPACT]
    assert np.abs(impact.sum(axis=0)[:2] / 4.5 - 1.0).max() < 1e-12
    assert np.abs(books.energy[-1]).max() < 1e-12
    assert np.count_nonzero(impact[:, 0]) <= 2  # two steps: reach the wall, stay there


def test_audited_motion_is_that_of_the_studies():
    audited, bank = (bank_of("exact_modal", n_modes=12) for _ in range(2))
    energy_balance.audit(audited, N_BLOCKS)
    run(bank, N_BLOCKS)
    assert np.abs(bank.state.position).max() > 0.0
    assert (audited.state.position == bank.state.position).all()
    assert (audited.state.increment == bank.state.increment).all()


def test_bumps_that_are_there_at_once_do_work_and_balance():
    """No ramp, no clearance: tips stand where the casing will be after the first step."""
    bank = bank_of("exact_modal", n_modes=12, ramp_time=0.0, clearance=0.0)
    books = energy_balance.audit(bank, N_BLOCKS)
    assert all(energy_balance.is_balanced(books, lane) for lane in range(len(SPEEDS)))
    assert (books.work[:, energy_balance.CASING, LANES].sum(axis=0) > 0.0).all()


def test_energy_from_nowhere_is_found():
    """An inertia that does not belong to the scheme, as of a defect: the balance must not close."""
    bank = bank_of("exact_modal", n_modes=12)
    books = energy_balance.Books.open(bank)
    books.inertia[:] *= 1.0 + 1e-6
    run(bank, N_BLOCKS, books)
    assert not any(energy_balance.is_balanced(books, lane) for lane in range(len(SPEEDS)))


DISKS = {
    "planar elastic": ("planar", {"elastic_casing": MILD}),
    "planar both": (
        "planar",
        {"coating": SOFT._replace(thickness=1e-4, hardening=1e6), "elastic_casing": MILD},
    ),
    "spatial elastic": ("spatial", {"elastic_casing": ElasticCasing(5e5, 10.0)}),
    **{name: KINDS[name] for name in ("planar coated", "spatial coated", "spatial both")},
}


@pytest.mark.parametrize("name", DISKS)
def test_energy_of_a_disk_whose_casing_gives_or_wears_closes(name):
    """With the plastic work, which is that of the depths in the end where nothing is worn through;
    a bar that is softer than it should be does not close."""
    modes, scene, speed = rubbing(*DISKS[name])
    grid = Grid(1200, 1, 1)
    bank, coating = allocate(modes, scene, grid, 8, [speed]), scene.coating
    books = plain_audit(bank, 2400, scene)
    assert books.unexplained()[0] < 1e-12
    assert books.elastic[:, 0].max() > 0.0
    assert (books.dashpot >= -1e-15).all()
    assert (books.dashpot[:, 0].sum() > 0.0) == bool(scene.elastic_casing)
    if coating:
        worn, share = bank.law.surface.worn[:, 0], scene.interface.share[0]
        found = books.plastic[:, 0].sum() / (coating.area * share * coating.energy(worn).sum())
        assert abs(found - 1.0) < 1e-12 or worn.max() == coating.thickness
        assert books.groove[:, 0].sum() > 0.0
    bank = allocate(modes, scene, grid, 8, [speed])
    bank.law.surface.bars[:] *= 0.999
    wrong = bank.law.surface._replace(stiffness=bank.law.surface.stiffness * 1.001)
    books = plain_audit(bank._replace(law=bank.law._replace(surface=wrong)), 2400, scene)
    assert books.unexplained()[0] > 1e-9
