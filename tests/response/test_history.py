"""Whole histories: the same steps as the sweep, and failures where it fails.

Their forces are held against a textbook scheme in tests.contact.test_kernel, and histories that go
on from one another in test_wear.
"""

from dataclasses import replace

import numpy as np
import pytest

from hpcrub.config.schema import Config
from hpcrub.contact import status
from hpcrub.contact.status import DIVERGED, STEADY
from hpcrub.model.casing import CasingShape
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import blade_stiffness, mistuned_modes
from hpcrub.response import history
from hpcrub.response.revolution import Grid
from hpcrub.response.steady import localisation
from hpcrub.response.sweep import Motion, SweepResult, run_sweep
from hpcrub.setup.disks import Disks
from hpcrub.setup.problem import build_problem
from hpcrub.studies import branches, energy, interaction_map, time_response
from tests.program import TINY, whole


@pytest.fixture(scope="module")
def problem():
    return build_problem(Config.from_yaml(TINY).replace({"steady_state.rule": "last_window"}))


@pytest.fixture(scope="module")
def mistuned(problem):
    return mistuned_modes(problem.reduced, stiffness_deviation(5, 0, 0, 12, 0.04))


def test_same_steps_as_the_sweep(problem, mistuned):
    speeds = np.array([34.0, 34.2])
    motion = Motion.at_rest(2, len(mistuned.omega))
    scene = problem.scene  # fewer records than steps: amplitudes are of all steps in both
    result = run_sweep(mistuned, scene, speeds, motion=motion)
    for s in range(2):
        pieces = list(history.integrate(mistuned, scene, speeds, result.time[s]))
        ends, q = (np.array([getattr(p, name)[-1, ..., s] for p in pieces])
                   for name in ("time", "position"))  # fmt: skip
        last = ends <= result.time[s] * (1 + 1e-9)
        first = ends > result.time[s] - 3 / speeds[s] * (1 - 1e-9)
        peaks = np.array([piece.peak[:, s] for piece in pieces])
        largest = peaks[last & first].max(axis=0)
        assert largest.max() == pytest.approx(result.amplitude[s], rel=1e-9)
        assert localisation(largest) == pytest.approx(result.localisation[s], rel=1e-9)
        assert motion.time[s] == pytest.approx(result.time[s])
        at_end = q[np.flatnonzero(last)[-1]]
        np.testing.assert_allclose(motion.position[s], at_end, atol=1e-9 * np.abs(q).max())
    (alone,) = whole(mistuned, scene, [34.2], 0.05, "time")
    assert len(alone) == history.n_records(34.2, 0.05, scene)


def test_recorded_displacements_are_those_after_the_contact_forces(problem, mistuned):
    seen, q, force = whole(mistuned, problem.scene, [34.0], 0.1, "observed", "position",
                           "normal_force")  # fmt: skip
    assert force.any()
    after = np.einsum("ok,rks->ros", mistuned.observed, q)
    np.testing.assert_allclose(seen, after, rtol=0, atol=1e-13 * np.abs(after).max())


def test_a_continued_sweep_starts_from_the_same_motion(problem, mistuned):
    """In the transient: from rest, the amplitude at the same time would be another one."""
    speed, scene = 34.3, problem.scene._replace(record_interval=problem.scene.step)
    motion = Motion.at_rest(1, len(mistuned.omega))
    first = run_sweep(mistuned, scene, [speed], motion=motion)
    start = Motion(*(values.copy() for values in motion))
    result = run_sweep(mistuned, scene, [speed], motion=motion)
    time, q = whole(mistuned, scene, [speed], result.time[0], "time", "position", motion=start)
    tips = np.einsum("ck,rk->rc", mistuned.tangential, q[:, :, 0])
    window = time[:, 0] > time[-1, 0] - 3 / speed * (1 - 1e-9)
    assert np.abs(tips[window]).max() == pytest.approx(result.amplitude[0], rel=1e-9)
    assert motion.time[0] == pytest.approx(first.time[0] + result.time[0])
    np.testing.assert_allclose(motion.position[0], q[-1, :, 0], atol=1e-9 * np.abs(q).max())


@pytest.mark.parametrize("speed", [33.9, 34.1, 35.7, 101.3])
def test_a_duration_of_whole_blocks_has_no_further_one(speed):
    grid = Grid(steps_per_revolution=400, blocks_per_revolution=4, stride=2)
    durations = np.arange(1, 400) / (speed * 4)
    assert [history.n_blocks(speed, d, grid) for d in durations] == list(range(1, 400))
    assert history.n_blocks(speed, durations[7] * (1.0 + 1e-9), grid) == 9


WITH_ROTATION = {"disk.blade.lean_deg": 55.0, "disk.blade.bow": -0.05}  # friction may lock these
FAILING = [
    ({"friction": 1.5}, status.JAMMING),
    ({"friction": 1.0}, status.NOT_UNIQUE),
    ({"scheme": "central_difference", "step": 1e-4, "least_steps": 0.0}, status.TOO_LARGE),
    ({"friction": 0.6, "casing": CasingShape(4, 3e-3)}, status.TOO_LARGE),  # flutter
]


@pytest.fixture(scope="module")
def leaning():
    """Problem and modes of a disk whose blades lean with the rotation."""
    problem = build_problem(Config.from_yaml(TINY).replace(WITH_ROTATION))
    return problem, mistuned_modes(problem.reduced, np.zeros(12))


@pytest.mark.parametrize(("changes", "reason"), FAILING)
def test_a_history_fails_where_the_sweep_does(leaning, changes, reason):
    problem, modes = leaning
    scene, speeds = problem.scene._replace(**changes), [34.0, 34.2]
    result = run_sweep(modes, scene, speeds)
    assert (result.point_status == DIVERGED).all()
    *_, last = history.integrate(modes, scene, speeds, 0.3)
    assert last.reason.tolist() == [reason] * 2  # a sweep, looking later, may find NOT_FINITE
    assert np.isin(result.point_reason, (reason, status.NOT_FINITE)).all()
    *_, sound = history.integrate(modes, problem.scene, speeds, 0.3)
    assert not sound.reason.any()


def test_a_failure_stays(problem):
    """A lane that has been larger than the disk has failed, even when it is small again."""
    modes = mistuned_modes(problem.reduced, np.zeros(12))
    scene = problem.scene._replace(casing=CasingShape(4, 0.0), damping_ratio=0.5)
    motion = Motion.at_rest(2, len(modes.omega))
    tips = modes.tangential[:, 0]
    motion.position[0, 0] = 1.1 * scene.interface.radius.max() / np.abs(tips).max()
    first, *_, last = history.integrate(modes, scene, [34.0, 34.2], 0.1, motion)
    end = np.abs(modes.tangential @ last.position[-1, :, 0]).max()
    assert end < 0.01 * scene.interface.radius.max()
    assert first.reason.tolist() == last.reason.tolist() == [status.TOO_LARGE, status.NONE]


def test_points_that_fail_later_have_no_result():
    nan = np.nan
    result = replace(
        SweepResult.empty(3),
        amplitude=np.array([1.0, 2.0, nan]),
        localisation=np.array([0.1, 0.2, nan]),
        point_status=np.array([STEADY, STEADY, DIVERGED], np.uint8),
        point_reason=np.array([status.UNPROVEN, 0, status.JAMMING], np.uint8),
    )
    later = result.continued(np.array([0, status.UNSOLVED, status.NOT_FINITE]))
    np.testing.assert_array_equal(later.amplitude, [1.0, nan, nan])
    np.testing.assert_array_equal(later.localisation, [0.1, nan, nan])
    assert later.point_status.tolist() == [STEADY, DIVERGED, DIVERGED]
    assert later.point_reason.tolist() == [status.UNPROVEN, status.UNSOLVED, status.JAMMING]


def test_diverged_points_have_no_energies_and_no_windows(leaning):
    (problem, modes), (changes, _) = leaning, FAILING[0]
    model = problem._replace(scene=problem.scene._replace(**changes))
    speeds = np.array([34.0, 34.2])
    stiffness = blade_stiffness(model.reduced, np.zeros(12), modes)
    found, result = energy.energies(modes, stiffness, model.scene, speeds, list)
    assert np.isnan(found).all()
    assert (result.point_status == DIVERGED).all()
    cfg = Config.from_yaml(TINY.replace("34.4", "34.2"))
    values = branches.STUDY.compute(cfg, Disks(model, [modes]), 0, None)
    values = {name: value for name, _, value in values}
    assert status.are_fatal(values["point_reason"]).all()
    for name in ("amplitude_m", "localisation", "window_amplitude_m", "window_localisation"):
        assert np.isnan(values[name]).all()


def test_gap_of_a_tip_at_its_place(problem):
    """The tip's place in space is a complex number, its angle and radius meet the casing."""
    scene = problem.scene._replace(ramp_time=0.0)
    random = np.random.default_rng(4)
    time = random.uniform(0.0, 0.1, 50)
    radial = random.uniform(-0.02, 0.02, (50, 12))
    turned = 2j * np.pi * 34.0 * time[:, None] + 1j * scene.interface.angle
    place = (scene.interface.radius + radial) * np.exp(turned)
    pitch = 2 * np.pi / 4
    off = np.mod(np.angle(place) + pitch / 2, pitch) - pitch / 2
    inward = scene.casing.bump_height * np.exp(-((off / (0.1 * pitch)) ** 2))
    expected = scene.interface.radius + scene.clearance - inward - np.abs(place)
    found = time_response.gap(scene, 34.0, time, radial)
    assert np.abs(inward).max() > 0.9 * scene.casing.bump_height
    np.testing.assert_allclose(found, expected, atol=1e-14)


def test_spectrum_of_a_known_signal():
    spectrum = Config.from_yaml("spectrum: {max_frequency_hz: 100, step_hz: 0.5}").spectrum
    t = 1e-4 * np.arange(20000)
    signal = 3.0 + 2.0 * np.cos(2 * np.pi * 40 * t) + 0.5 * np.sin(2 * np.pi * 70.5 * t)
    amplitude = interaction_map.spectrum(signal[:, None], 1e-4, spectrum)[0]
    assert amplitude[[80, 141]] == pytest.approx([2.0, 0.5], rel=1e-3)
    assert amplitude[[0, 60, 110, 200]] == pytest.approx(0.0, abs=1e-3)


def test_records_of_a_history_are_as_fine_as_asked(problem, mistuned):
    """The same steps and verdict; the largest record grows to the largest of all steps."""
    every_step = problem.scene._replace(look_interval=0.0)
    (peak,) = whole(mistuned, every_step, [34.0], 0.1, "peak")
    found, means = [], []
    for interval in (np.inf, 2.1 * problem.scene.step, problem.scene.step):
        scene = problem.scene._replace(history_interval=interval)
        follower = history.Follower(mistuned, scene, 34.0, 0.1)
        for piece in history.integrate(mistuned, scene, [34.0], 0.1):
            follower.take(piece, 0)
        names = "time", "observed", "normal_force"
        time, seen, force = whole(mistuned, scene, [34.0], 0.1, *names)
        assert len(time) == history.n_records(34.0, 0.1, scene)
        means.append(force.sum(axis=0) / len(time))  # of all steps, in each record of its own
        found.append((time, seen, np.concatenate([part for part, *_ in follower.recent])))
    np.testing.assert_allclose(means, means[:1] * 3, rtol=1e-9)
    (coarse, _, tested), (middle, _, _), (fine, seen, also_tested) = found
    assert middle[1, 0] - middle[0, 0] <= 2.1 * problem.scene.step < coarse[1, 0] - coarse[0, 0]
    np.testing.assert_array_equal(tested, also_tested)
    every = len(fine) // len(coarse)
    assert every == 4
    np.testing.assert_array_equal(fine[every - 1 :: every], coarse)
    np.testing.assert_array_equal(seen[every - 1 :: every], found[0][1])
    sizes = [np.abs(records).max() for _, records, _ in found]
    assert sizes[0] < sizes[1] <= sizes[2] == peak.max()
