"""Sweeps over angular speeds: the cut of the revolution, lanes and their refilling, known peaks."""

import numpy as np
import pytest

from evidence.truth.disk import earlier_reduced, reference_reduced, reference_scene
from hpcrub.contact import status
from hpcrub.contact.status import NO_POINT, NOT_STEADY, STEADY
from hpcrub.errors import Interrupted
from hpcrub.model.casing import CasingShape, Profile
from hpcrub.model.damping import Damping
from hpcrub.model.interface import planar_interface
from hpcrub.model.reduction import Modes, mistuned_modes
from hpcrub.response import history
from hpcrub.response.band import PIECE
from hpcrub.response.revolution import MIN_BLOCK, cut_revolution, rung, slowest, speed_bands
from hpcrub.response.scene import Scene, can_touch
from hpcrub.response.steady import SteadyCriteria
from hpcrub.response.sweep import Motion, run_sweep
from tests.program import at_speed

SHORT = SteadyCriteria(first_check=0.2, max_time=0.6)
ENSEMBLE = SteadyCriteria(first_check=0.2, max_time=1.0, rule="ensemble")


def scene_of(**changes):
    short = {"step": 2e-5, "scheme": "exact_modal", "steady": SHORT}
    return reference_scene(**(short | changes))


@pytest.fixture(scope="module")
def modes():
    return mistuned_modes(reference_reduced(), np.linspace(-0.03, 0.03, 12))


def one_blade(**changes):
    """Modes and scene of a mass of 1 kg on a spring, pushed away by one bump per turn."""
    ones = np.ones((1, 1))
    modes = Modes.planar(np.array([2 * np.pi * 20.0]), ones, ones)
    face = planar_interface(np.zeros(1), 1.0)
    scene = Scene(face, 0.05, CasingShape(1, 2e-3), 1e-3, 0.01, 0.0, step=1e-4)
    return modes, scene._replace(**changes)


@pytest.mark.parametrize("n_bumps", [1, 4, 6, 97])
@pytest.mark.parametrize("step", [1e-3, 3e-5, 1e-6, 1e-7])
@pytest.mark.parametrize("speed", [0.5, 33.5, 900.0])
def test_revolution_is_cut_into_whole_steps_blocks_and_records(n_bumps, step, speed):
    scene = scene_of(casing=CasingShape(n_bumps, 1.25e-3), step=step, look_interval=5e-5)
    grid = cut_revolution(speed, scene)
    assert 1.0 / (speed * grid.steps_per_revolution) <= step * (1.0 + 1e-9)
    assert grid.steps_per_block * grid.blocks_per_revolution == grid.steps_per_revolution
    assert grid.steps_per_block % grid.stride == grid.stride % grid.look == 0
    looks = slowest(rung(speed)) * grid.steps_per_revolution / grid.look  # in a second
    assert grid.look == 1 or looks >= 1.0 / 5e-5
    assert n_bumps % grid.blocks_per_revolution == 0  # a block turns by whole pitches
    assert grid.steps_per_block >= MIN_BLOCK or grid.blocks_per_revolution == 1


def test_a_tip_that_vibrates_faster_than_it_rotates_is_marked():
    """|u̇_t| > RΩ: at a radius below ω/Ω times the amplitude, 20/13, of a motion at ω."""
    modes, scene = one_blade()
    amplitude = run_sweep(modes, scene, [13.0]).amplitude[0]
    for radius, reason in ((1.2, status.REVERSED), (3.0, status.NONE)):
        face = planar_interface(np.zeros(1), radius * amplitude)
        result = run_sweep(modes, scene._replace(interface=face), [13.0])
        assert result.point_reason[0] == reason
        assert result.amplitude[0] == amplitude


def test_every_mode_decays_with_its_own_damping():
    """Two free modes, seen one by one by two contact points that never touch."""
    damping = Damping((0.01, 0.03))
    omega = 2 * np.pi * np.array([20.0, 50.0])
    modes = Modes.planar(omega, np.eye(2), np.eye(2))
    scene = Scene(
        planar_interface(np.zeros(2), 1.0), damping, CasingShape(1, 0.0), 1.0, 0.0, 0.0, step=1e-4,
        scheme="exact_modal",
    )  # fmt: skip
    start = np.array([1e-3, 2e-3])
    end = Motion.at_rest(1, 2)
    end.position[:] = start
    pieces = list(history.integrate(modes, scene, [10.0], 0.5, end))
    time, ratio = pieces[-1].time[-1, 0], np.array(damping.ratios)
    q, v = end.position[0], end.velocity[0]
    envelope = np.hypot(q, v / omega + ratio * q)
    np.testing.assert_allclose(envelope, start * np.exp(-ratio * omega * time), rtol=0.02)


def test_a_profile_below_the_clearance_never_touches():
    modes, scene = one_blade(casing=CasingShape(1, 0.0, Profile(((2, 0.9e-3, 0.0),))))
    assert not can_touch(scene)
    result = run_sweep(modes, scene, [13.0, 15.0])
    assert (result.amplitude == 0.0).all()
    assert (result.localisation == 0.0).all()
    assert (result.point_status == STEADY).all()
    both = Profile(((2, 0.9e-3, 0), (3, 0.3e-3, 0)))
    assert can_touch(scene._replace(casing=CasingShape(1, 0.0, both)))


@pytest.mark.parametrize("factor", [0.013, 0.37, 1.0, 4.9])
def test_bands_hold_every_speed_once_and_those_of_a_rung(factor):
    speeds = factor * np.array([40.0, 10.0, 10.5, 39.0, 80.0, 10.9])
    bands = speed_bands(speeds)
    assert sorted(np.concatenate(bands)) == list(range(6))
    assert [speeds[band].min() for band in bands] == sorted(speeds[band].min() for band in bands)
    for band in bands:
        assert speeds[band].max() < 1.08 * speeds[band].min()
        grids = {cut_revolution(speed, scene_of()) for speed in speeds[band]}
        assert len(grids) == 1


def test_steps_of_a_bump_do_not_depend_on_the_speed():
    """The step is the shorter of the one in seconds and of a part of a turn, at every speed."""
    scene = scene_of(step=3e-5, least_steps=1500.0)
    for speed in (1.0, 10.0, 21.0, 40.0, 900.0):
        n_steps = cut_revolution(speed, scene).steps_per_revolution
        needed = max(1500.0, 1.0 / (speed * 3e-5))
        assert needed <= n_steps <= 1.08 * needed + 16


def test_a_speed_alone_and_among_others_has_the_same_bits(modes):
    """Alone, in two grids that begin elsewhere, and in a grid over several rungs."""
    grids = [34.3], np.linspace(33.5, 35.5, 11), [27.0, 31.0, 34.3, 36.5, 40.0], [34.3, 34.31]
    found = [run_sweep(modes, scene_of(steady=ENSEMBLE), np.array(grid)) for grid in grids]
    at = [int(np.argmin(abs(np.array(grid) - 34.3))) for grid in grids]
    assert found[0].amplitude[0] > 1e-3
    for result, i in zip(found[1:], at[1:], strict=True):
        np.testing.assert_equal(at_speed(result, i), at_speed(found[0], 0))


def test_result_does_not_depend_on_lanes_or_parts(modes):
    speeds = np.linspace(33.5, 35.5, 11)
    scene = scene_of()
    whole = run_sweep(modes, scene, speeds)
    assert set(whole.point_status) <= {STEADY, NOT_STEADY}
    assert np.ptp(whole.time) > 0.1
    for lanes, width in (((4, 8), None), ((8,), 4)):
        narrowed = run_sweep(modes, scene._replace(lanes=lanes), speeds, width=width)
        np.testing.assert_equal(narrowed.by_name(), whole.by_name())
        assert narrowed.n_steps == whole.n_steps
    parts = [run_sweep(modes, scene, speeds, selection=range(k, 11, 3)) for k in range(3)]
    for k, part in enumerate(parts):
        for i in range(k, 11, 3):
            np.testing.assert_equal(at_speed(part, i), at_speed(whole, i))
        assert np.all(np.delete(part.point_status, np.arange(k, 11, 3)) == NO_POINT)
    assert sum(part.n_steps for part in parts) == whole.n_steps


def test_confirmations_are_successive_checks():
    """A periodic motion passes every check: n confirmations take n − 1 extensions more."""
    speeds = np.array([15.0, 15.5])
    results = []
    for confirmations, max_time in ((1, 9.0), (3, 9.0), (3, 3.5)):
        steady = SteadyCriteria(3.0, max_time=max_time, confirmations=confirmations)
        results.append(run_sweep(*one_blade(steady=steady), speeds))
    once, thrice, never = results
    assert once.amplitude.min() > 1e-4
    assert (once.point_status == STEADY).all()
    assert (thrice.point_status == STEADY).all()
    assert (never.point_status == NOT_STEADY).all()
    np.testing.assert_allclose(thrice.time - once.time, 2 * 10 / speeds, rtol=1e-9)


def test_poll_can_stop_a_sweep(modes):
    calls = []

    def poll():
        calls.append(1)
        if len(calls) == 3:
            raise Interrupted("enough")

    with pytest.raises(Interrupted):
        run_sweep(modes, scene_of(), np.array([34.0]), poll=poll)
    assert len(calls) == 3
    # before the first check, too: `poll` is called after so many steps, not after a time
    calls.clear()
    short = SteadyCriteria(first_check=0.02, max_time=0.02)
    fine = scene_of(step=1e-6, record_interval=1e-5, steady=short)
    result = run_sweep(modes, fine, np.array([34.0]), poll=lambda: calls.append(1), width=8)
    block = cut_revolution(34.0, fine).steps_per_block
    assert len(calls) >= result.n_steps / max(PIECE, block) > 2


def test_tuned_amplitudes_are_the_reference_values():
    """Disk of hpcrub 0.1, n_d = 4: 10.8 mm at 33.25 Hz, 14.4 mm at 33.5 Hz, both periodic;
    reference values of an independent implementation of the same model."""
    reduced = earlier_reduced()
    modes = mistuned_modes(reduced, np.zeros(12))
    scene = scene_of(
        interface=reduced.interface, step=1e-6, steady=SteadyCriteria(), scheme="central_difference"
    )
    result = run_sweep(modes, scene, np.array([33.25, 33.5]))
    assert np.all(result.point_status == STEADY)
    assert result.amplitude * 1e3 == pytest.approx([10.8, 14.4], abs=0.06)
    assert np.all(result.localisation < 1e-3)  # all blades of the tuned disk move alike


def test_amplitudes_do_not_depend_on_how_often_displacements_are_recorded(modes):
    """960 steps a revolution whatever the record; recorded peaks of a fast motion would be lost."""
    speed = 35.0
    step = 1 / slowest(rung(speed)) / 960
    scene = scene_of(step=step, steady=SteadyCriteria(first_check=0.25, max_time=0.25))
    found = []
    for stride in (1, 2, 30):
        every = scene._replace(record_interval=stride * scene.step * 1.001)
        grid = cut_revolution(speed, every)
        assert (grid.steps_per_revolution, grid.stride) == (960, stride)
        found.append(run_sweep(modes, every, [speed]).amplitude[0])
    assert found[0] == found[1] == found[2]
