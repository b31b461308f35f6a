"""Energy audit: the balance of the two-step scheme, and of what it must tell.

Theory: docs/theory.md. The balance holds to rounding for any scheme and friction. The impact loss
is λ g_{n−1}/2 ≥ 0. A mass that hits a fixed wall loses m v²/2.
"""

import numpy as np
import pytest

from evidence.truth.disk import reference_reduced, reference_scene
from evidence.truth.energy import audit
from evidence.truth.motion import WIDTH, Structure, make_bank, start_free, wall
from evidence.validation.report import SCHEMES
from hpcrub.contact.bank import allocate
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.revolution import Grid
from tests.contact.laws.test_coating import KINDS, rubbing
from tests.contact.laws.thrown import MILD, SOFT

SPEEDS = np.array([33.5, 34.25, 35.0])
REVOLUTION = 3000  # steps of 10 µs
N_STEPS = 2 * REVOLUTION // 4
LANES = slice(0, len(SPEEDS))


def bank_of(scheme, **changes):
    """The reference disk at SPEEDS, one lane each, at rest; changes of the Scene."""
    modes = mistuned_modes(reference_reduced(12), np.linspace(-0.03, 0.03, 12))
    scene = reference_scene(12, scheme=scheme, **changes)
    return allocate(modes, scene, Grid(REVOLUTION, 4, 1), WIDTH, SPEEDS)


@pytest.mark.parametrize("name", SCHEMES)
def test_audit_of_the_disk_closes_to_rounding(name):
    books = audit(bank_of(name), N_STEPS)
    assert (books.impact[:, LANES].sum(axis=0) > 1.0).all()  # J: contact did occur
    assert (books.friction[:, LANES].sum(axis=0) > 1.0).all()  # J: blades yield its way
    assert (books.unexplained()[LANES] < 1e-11).all()
    assert np.abs(books.residual()).max() < 1e-13 * books.energy.max()
    assert books.damping.min() >= 0.0
    assert (-books.negative.sum(axis=0) <= 1e-12 * books.turnover()).all()
    assert books.is_balanced().all()
    assert not books.energy[:, len(SPEEDS) :].any()  # idle lanes


@pytest.mark.parametrize("name", SCHEMES)
def test_a_mass_that_hits_a_wall_loses_its_kinetic_energy(name):
    """A free mass of 0.25 kg: R = 2, q' = 3 → 4.5 J, all lost; nothing else happens."""
    mass = Structure(np.zeros(1), np.full(1, 2.0), np.zeros(1), 0.0, 0.0)
    steps = [1e-3, 1.3e-4]
    bank = make_bank(mass, wall(mass, 0.1234, scheme=name), steps)
    start_free(bank, mass, np.zeros(1), np.full(1, 3.0), steps)
    books = audit(bank, 400)
    assert np.abs(books.impact.sum(axis=0)[:2] / 4.5 - 1.0).max() < 1e-12
    assert np.abs(books.energy[-1]).max() < 1e-12
    assert np.count_nonzero(books.impact[:, 0]) <= 2  # two steps: reach the wall, stay there


def test_bumps_that_are_there_at_once_do_work_and_balance():
    """No ramp, no clearance: tips stand where the casing will be after the first step."""
    bank = bank_of("exact_modal", ramp_time=0.0, clearance=0.0)
    books = audit(bank, N_STEPS)
    assert books.is_balanced().all()
    assert (books.casing[:, LANES].sum(axis=0) > 0.0).all()


DISKS = {
    "planar both": (
        "planar",
        {"coating": SOFT._replace(thickness=1e-4, hardening=1e6), "elastic_casing": MILD},
    ),
    **{name: KINDS[name] for name in ("planar coated", "spatial coated", "spatial both")},
}


@pytest.mark.parametrize("name", DISKS)
def test_energy_of_a_disk_whose_casing_gives_or_wears_closes(name):
    """With the plastic work, which is that of the depths where nothing is worn through."""
    modes, scene, speed = rubbing(*DISKS[name])
    grid = Grid(1200, 1, 1)
    bank, coating = allocate(modes, scene, grid, 8, [speed]), scene.coating
    books = audit(bank, 2400, scene)
    assert books.unexplained()[0] < 1e-12
    assert books.elastic[:, 0].max() > 0.0
    assert (books.dashpot >= -1e-15).all()
    assert (books.dashpot[:, 0].sum() > 0.0) == bool(scene.elastic_casing)
    worn, share = bank.law.surface.worn[:, 0], scene.interface.share[0]
    found = books.plastic[:, 0].sum() / (coating.area * share * coating.energy(worn).sum())
    assert abs(found - 1.0) < 1e-12 or worn.max() == coating.thickness
    assert books.groove[:, 0].sum() > 0.0
