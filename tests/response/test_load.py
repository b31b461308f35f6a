"""A load that travels around the disk during contact: its response without contact is known."""

import numpy as np
import pytest

from evidence.truth.disk import LOAD, reference_reduced, reference_scene
from hpcrub.config.schema import Config, load_runs
from hpcrub.contact.status import STEADY
from hpcrub.model.casing import CasingShape
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.linear import engine_order_response
from hpcrub.response.revolution import cut_revolution
from hpcrub.response.scene import can_touch
from hpcrub.response.steady import SteadyCriteria
from hpcrub.response.sweep import run_sweep
from hpcrub.setup.imported import resolved
from hpcrub.setup.problem import build_problem, scene_of
from tests.program import ROOT

DAMPING = 0.05  # transients decay by 10⁻⁹ until the first check
FREE = {
    "clearance": 1.0,
    "damping_ratio": DAMPING,
    "load": LOAD,
    "scheme": "exact_modal",
    "steady": SteadyCriteria(first_check=0.75, max_time=1.5),
    "lanes": (4,),  # as run-ups take with a load: each number is compiled
}


@pytest.mark.parametrize(("order", "n_bumps", "repeats"), [(4, 4, 4), (3, 4, 1), (2, 6, 2)])
def test_without_contact_it_gives_the_harmonic_response(order, n_bumps, repeats):
    reduced = reference_reduced()
    modes = mistuned_modes(reduced, np.linspace(-0.03, 0.03, 12))
    every_step = {"step": 2e-5, "record_interval": 2e-5}
    bumps = CasingShape(n_bumps, 1.25e-3)
    scene = reference_scene(**FREE, load_order=order, casing=bumps, **every_step)
    speeds = np.array([86.0, 91.0, 92.5, 100.0]) / order
    assert cut_revolution(speeds[0], scene).blocks_per_revolution == repeats
    found = run_sweep(modes, scene, speeds)
    # equation (5) travels the other way; this load stands still, and so do the bumps
    expected = engine_order_response(modes, DAMPING, LOAD, -order, reduced.interface, speeds)
    expected = np.abs(expected).max(axis=1)
    np.testing.assert_allclose(found.amplitude, expected, rtol=1e-3)
    other_way = engine_order_response(modes, DAMPING, LOAD, order, reduced.interface, speeds)
    assert not np.allclose(np.abs(other_way).max(axis=1), expected, rtol=5e-3)


@pytest.mark.parametrize(("max_error", "change"), [(0.15, 0.01), (0.01, 0.002)])
def test_a_light_disk_is_known_as_well_as_its_error_says(max_error, change):
    """Its transients are still there when the first verdict is possible: 24 % after 0.5 s."""
    modes = mistuned_modes(reference_reduced(), np.linspace(-0.03, 0.03, 12))
    steady = SteadyCriteria(
        rule="ensemble", max_time=6.0, max_error=max_error, max_amplitude_change=change
    )
    light = {"damping_ratio": 0.005, "steady": steady, "look_interval": 5e-5}
    scene = reference_scene(**(FREE | light), load_order=4, casing=CasingShape(4, 1e-3), step=2e-5)
    speeds = np.linspace(33.0, 35.5, 9)
    found = run_sweep(modes, scene, speeds)
    response = engine_order_response(modes, 0.005, LOAD, -4, reference_reduced().interface, speeds)
    exact = np.abs(response).max(axis=1)
    off = np.abs(found.amplitude - exact)
    assert (off < 2.0 * found.error).all()
    assert (found.error < max_error * found.amplitude).all()
    is_steady = found.point_status == STEADY  # what may still change is what was allowed
    assert (off < change * exact)[is_steady].all()
    assert (off < max_error * exact).all()


def test_looks_lose_no_more_of_a_vibration_than_their_distance_allows():
    """A sine that is looked at n times a period shows at least cos(π/n) of its amplitude."""
    modes = mistuned_modes(reference_reduced(), np.linspace(-0.03, 0.03, 12))
    scene = reference_scene(**FREE, load_order=4, casing=CasingShape(4, 1e-3), step=5e-6)
    speeds = np.array([22.0, 23.0])
    exact, lost = run_sweep(modes, scene, speeds).amplitude, []
    for n in (12, 100):
        looked = scene._replace(look_interval=1.0 / (n * 4 * speeds[-1]), record_interval=1.0)
        assert cut_revolution(speeds[-1], looked).look > 1
        lost.append(1.0 - run_sweep(modes, looked, speeds).amplitude / exact)
        assert (lost[-1] >= 0.0).all()
        assert (lost[-1] <= 1.0 - np.cos(np.pi / n)).all()
    assert lost[0].max() > 1e-4  # it does not look at every step


def test_the_first_family_is_looked_at_a_hundred_times_a_period():
    problem = build_problem(Config().replace({"time.step_s": 1e-6}))
    grid = cut_revolution(34.0, problem.scene)
    first = mistuned_modes(problem.reduced, np.zeros(12)).omega.min() / (2.0 * np.pi)
    looks = 34.0 * grid.steps_per_revolution / grid.look / first
    assert 95.0 < looks < 200.0


def test_every_step_of_a_disk_in_three_dimensions_counts():
    """More than one family moves its tips."""
    given = load_runs(ROOT / "inputs/blisk/contact.yaml")[0]
    config = resolved(given.replace({"time.step_s": 1e-6}))
    grids = [cut_revolution(speed, scene_of(config)) for speed in config.speeds.values_hz]
    assert max(grid.stride for grid in grids) > 1
    assert {grid.look for grid in grids} == {1}


def test_a_loaded_disk_may_touch_a_casing_without_bumps():
    modes = mistuned_modes(reference_reduced(), np.zeros(12))
    near = FREE | {"clearance": 1e-6, "casing": CasingShape(4, 0.0)}
    scene = reference_scene(**near, load_order=4, step=2e-5)
    assert can_touch(scene)
    free = run_sweep(modes, scene._replace(clearance=1.0), [23.0])
    stopped = run_sweep(modes, scene, [23.0])
    assert free.max_sweeps[0] == 0 < stopped.max_sweeps[0]
    assert 0.0 < stopped.amplitude[0] < 0.9 * free.amplitude[0]


def test_the_keys_of_the_load():
    config = Config().replace({"forcing.in_contact": True, "forcing.engine_order": 6})
    scene = build_problem(config).scene
    assert (scene.load, scene.load_order, scene.repeats) == (150.0, 6, 2)
    assert scene_of(config).repeats == 2
    assert build_problem(Config()).scene.load == 0.0
