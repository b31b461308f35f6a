"""Run-ups: constant speed, slow gain of speed, coefficients in between, repetitions, going on.

Linear and rubbing runs are held against other programs in tests.evidence.test_run_up.
"""

import numpy as np
import pytest

from hpcrub.config.schema import Config
from hpcrub.contact import retune
from hpcrub.contact.bank import allocate
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.response import history
from hpcrub.response.revolution import cut_revolution
from hpcrub.response.run_up import Asked, Runner, run_up
from hpcrub.response.schedule import Schedule
from hpcrub.response.sweep import run_sweep
from hpcrub.setup.disks import rubbing_modes
from hpcrub.setup.problem import build_problem
from tests.program import TINY

BORDERS = np.linspace(33.0, 36.0, 13)
FAR = [30.5, 33.0, 36.0, 39.5]  # [Hz], of a rotor that gains speed fast against its own
COATING = "contact: {law: abradable, coating: {yield_mpa: 0.5}}\n"


def scene_and_modes(text, folder=None):
    """Scene of an input, and modes of a mistuned disk."""
    config = Config.from_yaml(text)
    problem = build_problem(config)
    blades = stiffness_deviation(5, 0, 0, config.disk.n_blades, 0.01)
    return problem.scene, rubbing_modes(config, problem, blades)


def test_a_schedule_turns_by_the_integral_of_its_speed():
    schedule = Schedule([0.0, 2.0, 3.0, 5.0], [10.0, 30.0, 30.0, 12.0])
    time = np.linspace(0.0, 6.0, 600_001)
    turned = np.append(0.0, np.cumsum((schedule.at(time[1:]) + schedule.at(time[:-1])) / 2e5))
    np.testing.assert_allclose(schedule.when(turned[::997]), time[::997], atol=1e-9)
    assert schedule.when(np.array([-5.0])) == pytest.approx(-0.5)
    np.testing.assert_array_equal(schedule.leg_ends, [3.0, 5.0])
    np.testing.assert_array_equal(schedule.leg_rises, [True, False])


def test_passes_of_a_rate_come_back_in_between():
    schedule = Schedule.of_rate(20.0, 30.0, 5.0, hold_s=1.0, passes=2)
    np.testing.assert_allclose(schedule.time, [0.0, 2.0, 3.0, 5.0, 7.0, 8.0])
    np.testing.assert_allclose(schedule.speed_hz, [20.0, 30.0, 30.0, 20.0, 30.0, 30.0])
    np.testing.assert_array_equal(schedule.leg_rises, [True, False, True])


@pytest.mark.parametrize("more", ["", COATING])
def test_constant_speed_has_the_bits_of_a_history(more):
    scene, modes = scene_and_modes(TINY + more)
    lasts, speed = 0.3, 34.2
    pieces = list(history.integrate(modes, scene, np.array([speed]), 2 * lasts))
    peaks = [piece.peak[:, 0] for piece in pieces]
    runner = Runner(modes, scene, Schedule([0.0, lasts], [speed, speed]), Asked(BORDERS, 8))
    assert runner.period == cut_revolution(speed, scene).steps_per_block
    before = 0
    for periods in runner.go_on():
        found = runner.record.peak[: len(modes.observed), 0]
        block, before = slice(before, periods), periods
        np.testing.assert_array_equal(found, np.max(peaks[block], axis=0))
    assert np.max(peaks) > 0.005
    if scene.coating:
        worn = runner.bank.law.surface.worn_depth(0).max()
        assert worn == pieces[periods - 1].worn[0].max()


def test_a_slow_run_has_the_amplitudes_of_a_steady_sweep():
    scene, modes = scene_and_modes(TINY)
    speeds = np.array([33.2, 33.3])  # where the motion repeats itself
    steady = run_sweep(modes, scene, speeds, width=8).amplitude
    borders = np.array([33.0, 33.19, 33.21, 33.29, 33.31, 33.4])
    run = run_up(modes, scene, Schedule([0.0, 4.0], [33.0, 33.4]), Asked(borders, 8))
    np.testing.assert_allclose(run.envelope[:, 0, [1, 3]], np.tile(steady, (8, 1)), rtol=0.05)


def test_coefficients_between_the_rungs_are_those_of_the_speed():
    scene, modes = scene_and_modes(TINY + "contact: {law: elastic, casing_stiffness_n_per_m: 1e7}")
    grid, ends = cut_revolution(30.0, scene), (30.0, 40.0)

    def bank_at(speeds):
        return allocate(modes, scene, grid, len(speeds), speeds)

    bank = bank_at(np.full(4, 30.0))
    tables = retune.Speeds(bank, bank_at, 30.0, ends)
    assert len(tables.changing) > 3
    for speeds in (
        [30.0, 30.1, 30.33, 30.4],
        [39.0, 39.02, 39.1, 39.1],
        [33.0, 32.9, 32.8, 32.7],
        FAR,
        FAR[::-1],
    ):
        speeds = np.array(speeds)
        tables.set(speeds, 1.0 / (speeds * grid.steps_per_revolution))
        exact, found = retune.of_lanes(bank_at(speeds)), retune.of_lanes(bank)
        for path in tables.changing:
            size = np.abs(exact[path]).max()
            np.testing.assert_allclose(found[path], exact[path], atol=1e-7 * size, err_msg=path)


def test_an_increment_fits_the_new_step():
    # a free mode: the displacement before a step of another length, by the exact motion
    scene, modes = scene_and_modes(TINY)
    scene = scene._replace(damping_ratio=0.0)
    grid = cut_revolution(30.0, scene)

    def bank_at(speeds):
        return allocate(modes, scene, grid, len(speeds), speeds)

    bank = bank_at(np.array([30.0]))
    omega, h = modes.rows.omega, bank.scheme.step[0]
    slow, phase = omega * h < 0.1, 0.7
    bank.state.position[:, 0] = np.cos(phase)
    bank.state.increment[:, 0] = np.cos(phase) - np.cos(phase - omega * h)
    new = h * 1.01
    retune.Speeds(bank, bank_at, 30.0, (29.0, 31.0)).set(np.array([30.0 / 1.01]), np.array([new]))
    exact = np.cos(phase) - np.cos(phase - omega * new)
    off = np.abs(bank.state.increment[:, 0] - exact)[slow]
    assert (off <= 4e-3 * (omega[slow] * h) ** 3).all()


def test_a_repetition_is_a_run_that_begins_at_another_angle():
    scene, modes = scene_and_modes(TINY)
    schedule, asked = Schedule([0.0, 0.2], [33.2, 34.2]), Asked(BORDERS, 8)
    runner = Runner(modes, scene, schedule, asked)
    angle = runner.delay[1] * 2.0 * np.pi / runner.grid.steps_per_revolution
    turned = scene.interface._replace(angle=scene.interface.angle + angle)
    list(runner.go_on())
    alone = run_up(modes, scene._replace(interface=turned), schedule, asked)
    found, expected = runner.result().envelope[1], alone.envelope[0]
    known = np.isfinite(found) & np.isfinite(expected)
    assert known.sum() > 3
    # intervals begin and end with other stretches
    np.testing.assert_allclose(np.nanmax(found), np.nanmax(expected), rtol=0.05)


@pytest.mark.parametrize("more", ["", COATING + "limits: {amplitude_mm: 5}\n"])
def test_a_run_goes_on_with_the_same_bits(more):
    scene, modes = scene_and_modes(TINY + more)
    asked = Asked(BORDERS, 8, amplitude=0.005, frequencies_hz=np.arange(0.0, 200.0, 5.0))
    schedule = Schedule([0.0, 0.5, 0.8], [33.0, 35.5, 33.0])
    whole, first, second = (Runner(modes, scene, schedule, asked) for _ in range(3))
    list(whole.go_on())
    for _, _ in zip(range(7), first.go_on(), strict=False):
        pass
    second.restore(first.state())
    list(second.go_on())
    expected, found = vars(whole.result()), vars(second.result())
    for name, values in expected.items():
        np.testing.assert_array_equal(found[name], values, err_msg=name)
    assert (expected["seconds"] > 0.0).any()
    assert (expected["cycles"] > 0.0).any()
    assert np.isfinite(expected["spectrum"]).any()
    assert np.isfinite(expected["worn"]).all() == bool(scene.coating)


def test_the_strongest_frequency_is_that_of_the_bumps():
    scene, modes = scene_and_modes(TINY)
    frequencies = np.arange(60.0, 300.0, 1.0)
    asked = Asked(BORDERS, 8, frequencies_hz=frequencies)
    run = run_up(modes, scene, Schedule([0.0, 3.0], [33.0, 36.0]), asked)
    strongest = frequencies[run.spectrum[0].argmax(axis=1)]
    middles = (BORDERS[1:] + BORDERS[:-1]) / 2.0
    np.testing.assert_allclose(strongest, 4.0 * middles, atol=2.0)


def test_intervals_that_a_fast_run_passes_in_one_stretch_have_its_spectrum():
    scene, modes = scene_and_modes(TINY)
    asked = Asked(np.linspace(33.0, 36.0, 121), 1, frequencies_hz=np.arange(60.0, 300.0, 4.0))
    run = run_up(modes, scene, Schedule([0.0, 0.5], [33.0, 36.0]), asked)
    assert np.isfinite(run.envelope).all()
    assert np.isfinite(run.spectrum).all()
