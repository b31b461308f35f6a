"""Clearance that changes with the speed, and from blade to blade, against runs at one of them."""

import numpy as np
import pytest

from evidence.truth.disk import reference_reduced, reference_scene
from hpcrub.config.schema import Config
from hpcrub.contact.status import STEADY
from hpcrub.model.coating import Coating, ElasticCasing
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.steady import SteadyCriteria
from hpcrub.response.sweep import run_sweep
from hpcrub.setup.input_files import with_tables
from hpcrub.setup.problem import Model, interface_of, scene_of
from tests.program import at_speed

SPEEDS = np.array([33.9, 34.4, 34.9])
DEVIATION = np.linspace(-0.02, 0.02, 12)
LAWS = {
    "rigid": {},
    "elastic": {"elastic_casing": ElasticCasing(2.4e8, 0.0)},
    "abradable": {"coating": Coating(5e-3, 1e9, 15e6, 2e8, 1.4e-3, 0.1)},
}


def swept(deviation=DEVIATION, speeds=SPEEDS, own=None, **changes):
    steady = SteadyCriteria(max_time=0.2)
    scene = reference_scene(step=5e-5, scheme="exact_modal", steady=steady, **changes)
    if own is not None:
        scene = scene._replace(interface=scene.interface._replace(clearance=np.asarray(own)))
    return run_sweep(mistuned_modes(reference_reduced(), deviation), scene, speeds)


@pytest.mark.parametrize("law", LAWS)
def test_every_speed_has_the_clearance_of_the_table(law):
    """The same bits as a run at that clearance alone, in lanes beside other clearances."""
    table = ((30.0, 0.5e-3), (36.0, 0.1e-3))
    whole = swept(running=table, **LAWS[law])
    assert len(set(whole.amplitude)) == len(SPEEDS)
    for i, speed in enumerate(SPEEDS):
        clearance = 0.5e-3 - (speed - 30.0) / 6.0 * 0.4e-3  # by hand
        found = float(np.interp(speed, *np.array(table).T))
        assert abs(clearance - found) < 1e-18
        alone = swept(speeds=[speed], clearance=found, **LAWS[law])
        np.testing.assert_equal(at_speed(alone, 0), at_speed(whole, i))
    level = swept(running=((30.0, 0.25e-3), (36.0, 0.25e-3)), **LAWS[law])
    np.testing.assert_equal(level.by_name(), swept(clearance=0.25e-3, **LAWS[law]).by_name())


def test_a_speed_whose_clearance_is_out_of_reach_stays_at_rest():
    found = swept(running=((34.5, 2e-3), (34.6, 0.25e-3)))
    assert (found.amplitude[:2] == 0.0).all()
    assert (found.point_status[:2] == STEADY).all()
    assert found.amplitude[2] == swept(speeds=SPEEDS[2:]).amplitude[0] > 0.0


def test_blades_that_are_all_shorter_are_a_casing_that_is_wider():
    part = 2.0**-14  # adds without rounding
    found = swept(own=np.full(12, part), clearance=2.0**-12)
    np.testing.assert_equal(found.by_name(), swept(clearance=2.0**-12 + part).by_name())


def test_a_blade_takes_its_own_part_with_it():
    """Blades moved on by three, a pitch of the four bumps, are the same disk; by two they are not.

    Before bumps grow high enough for any chaos: amplitudes are close, not the same bits.
    """
    own = np.zeros(12)
    own[1], own[7] = -1e-4, 2e-4
    first = swept(own=own, friction=0.0)
    moved = swept(np.roll(DEVIATION, 3), own=np.roll(own, 3), friction=0.0)
    apart = swept(np.roll(DEVIATION, 3), own=np.roll(own, 2), friction=0.0)
    assert np.allclose(first.amplitude, moved.amplitude, rtol=1e-3)
    assert not np.allclose(first.amplitude, apart.amplitude, rtol=1e-2)


def test_what_an_input_says_reaches_the_scene(tmp_path):
    """A table by hand; a blade's part goes to all of its contact points."""
    reduced = reference_reduced()
    (tmp_path / "clearance.csv").write_text("clearance_mm, speed_hz\n0.5, 30\n0.1, 40\n")
    config = Config(casing={"clearance_hz_mm": str(tmp_path / "clearance.csv")})
    scene = scene_of(with_tables(config), reduced.interface)
    assert abs(scene.at(35.0).clearance - 0.3e-3) < 1e-18
    assert abs(scene.clearance - 0.28e-3) < 1e-18  # the smallest, at 35.5 Hz
    two = reduced.interface._replace(blade=np.arange(12) // 2, clearance=np.full(12, 1e-5))
    few = Config(disk={"n_blades": 6}, casing={"blade_clearance_mm": [0, 0, 0, 0, 0, 0.1]})
    own = interface_of(few, Model(None, reduced._replace(interface=two))).clearance
    assert np.allclose(own, [1e-5] * 10 + [1.1e-4] * 2, rtol=1e-12)
