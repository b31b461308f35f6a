"""Blades with several contact points that move in three dimensions.

Truth: the textbook scheme of `tests.contact.test_kernel`, whose friction is along the slip.
"""

import numpy as np
import pytest
from scipy.optimize import brentq

from evidence.validation.report import fitted_order
from hpcrub.contact import status
from hpcrub.contact.arrays import FLAW, UNSOLVED
from hpcrub.contact.bank import allocate
from hpcrub.contact.integrate import run
from hpcrub.contact.observers import Record
from hpcrub.model.casing import CasingShape
from hpcrub.model.interface import Interface
from hpcrub.model.reduction import Modes
from hpcrub.response.revolution import Grid, rung, slowest
from hpcrub.response.scene import Scene
from hpcrub.response.steady import SteadyCriteria
from hpcrub.response.sweep import Motion, run_sweep
from tests.contact.test_kernel import textbook
from tests.program import whole

N_BLADES, PER_BLADE, N_MODES = 3, 4, 40
REVOLUTION, SPEED, FRICTION, XI = 1200, 30.0, 0.3, 0.01
BOOK = {"revolution": REVOLUTION, "reach": 2e-3, "rounding": 1e-15}


def made_up(seed=0, n_blades=N_BLADES, per_blade=PER_BLADE):
    """Modes and Scene of blades whose points move nearly alike: stiffly coupled within a blade."""
    rng = np.random.default_rng(seed)
    n = n_blades * per_blade
    blade = np.tile(np.arange(n_blades), per_blade)  # not in order
    common = rng.normal(size=(n_blades, N_MODES))[blade]
    normal = common + 0.3 * rng.normal(size=(n, N_MODES))
    tangential = 0.5 * rng.normal(size=(n_blades, N_MODES))[blade] + 0.1 * normal
    axial = 3.0 * rng.normal(size=(n_blades, N_MODES))[blade]
    omega = 2.0 * np.pi * np.sort(rng.uniform(60.0, 3000.0, N_MODES))
    modes = Modes(omega, normal, tangential, axial, np.vstack([tangential, axial]), np.eye(N_MODES))
    interface = Interface(
        blade=blade,
        angle=2.0 * np.pi * blade / n_blades + 0.02 * rng.uniform(size=n),
        radius=rng.uniform(0.4, 0.5, n),
        axial_position=np.zeros(n),
        clearance=2e-4 * rng.uniform(size=n),
        normal=normal,
        tangential=tangential,
        axial=axial,
        observed=modes.observed,
        observed_blade=np.tile(blade, 2),
    )
    return modes, Scene(interface, XI, CasingShape(2, 3e-3), 1e-3, 0.005, FRICTION)


def integrate(modes, scene, speeds, n_steps, width=8):
    """Observed displacements (n_steps, O, lanes) and the Bank."""
    bank = allocate(modes, scene, Grid(REVOLUTION, 1, 1), width, speeds)
    n_blocks = -(-n_steps // REVOLUTION)
    record = Record.allocate(bank, n_blocks, 1)
    run(bank, n_blocks, record)
    found = record.history.reshape(n_blocks * REVOLUTION, -1, width)
    return found[:n_steps, : len(modes.observed), : len(speeds)], bank


@pytest.mark.parametrize("seed", [0, 1])
def test_turning_friction_on_several_points_is_the_textbook_scheme(seed):
    modes, scene = made_up(seed)
    expected, forces = textbook(modes, scene, SPEED, 700, **BOOK)
    found, bank = integrate(modes, scene, [SPEED, 1.05 * SPEED], 700)
    touching = forces > 0.0
    assert touching.sum(axis=1).max() >= 2
    assert touching.any(axis=0).sum() >= 5
    assert np.abs(found[:, :, 0] - expected).max() < 1e-7 * np.abs(expected).max()
    assert bank.state.report[UNSOLVED, 0] == 0.0
    assert bank.state.report[FLAW, 0] in (status.NONE, status.UNPROVEN)
    fixed, _ = integrate(modes._replace(axial=modes.axial[:0]), scene, [SPEED], 700)
    assert np.abs(fixed[:, :, 0] - expected).max() > 1e-2 * np.abs(expected).max()


@pytest.mark.parametrize("seed", [0, 2])
def test_a_blade_that_only_forces_on_others_push_in_gets_its_force(seed):
    modes, scene = made_up(seed, n_blades=4, per_blade=2)
    sides = np.where(scene.interface.blade < 2, 2.0, -2.0)  # opposite blades push each other in
    shared = np.random.default_rng(100 + seed).normal(size=N_MODES)
    modes = modes._replace(normal=modes.normal + sides[:, None] * shared)
    expected, _ = textbook(modes, scene, SPEED, 700, **BOOK)
    found, _ = integrate(modes, scene, [SPEED], 700)
    assert np.abs(found[:, :, 0] - expected).max() < 1e-9 * np.abs(expected).max()


def test_friction_that_turns_until_a_point_jams_is_found_with_and_without_other_lanes():
    """Also at points that others hold out of the casing, as they do here at some speeds."""
    modes, scene = made_up(3)
    modes, scene = modes._replace(axial=-7.0 * modes.normal), scene._replace(friction=1.0)
    speeds = np.linspace(28.0, 34.0, 8)
    _, bank = integrate(modes, scene, speeds, REVOLUTION)
    ends = [len(textbook(modes, scene, speed, REVOLUTION, **BOOK)[0]) for speed in speeds]
    jams = [end < REVOLUTION for end in ends]
    assert 0 < sum(jams) < len(speeds)
    assert (bank.state.report[FLAW] == status.JAMMING).tolist() == jams
    for speed, jammed in zip(speeds, jams, strict=True):
        _, bank = integrate(modes, scene, [speed], REVOLUTION)
        assert (bank.state.report[FLAW, 0] == status.JAMMING) == jammed


def test_a_history_holds_the_forces_in_all_directions():
    """Whose resultant opposes the slip: its axial part grows with the axial velocity."""
    modes, scene = made_up(0)
    scene = scene._replace(step=1.0 / (SPEED * REVOLUTION))
    names = "normal_force", "tangential_force", "axial_force"
    normal, tangential, axial = whole(modes, scene, [SPEED], 0.5 / SPEED, *names)
    assert normal.max() > 0.0
    assert np.abs(axial).max() > 1e-3 * normal.max()
    touching = normal > 1e-3 * normal.max()
    friction = np.hypot(tangential, axial)[touching] / normal[touching]
    assert friction.max() <= FRICTION * (1.0 + 1e-9)  # less where it turns between two records
    assert np.median(friction) > 0.9 * FRICTION


def test_steps_in_which_a_blade_touches_are_counted():
    """Those in which any of its points carries a force, by a history of every step."""
    modes, scene = made_up(0)
    step = 1.0 / (slowest(rung(SPEED)) * REVOLUTION)  # as many steps as `integrate` takes here
    scene = scene._replace(step=step, record_interval=step)
    (force,) = whole(modes, scene, [SPEED], 1.0 / SPEED, "normal_force")
    touching = force[:, :, 0] > 0.0
    blade = scene.interface.blade
    expected = [touching[:, blade == b].any(axis=1).sum() for b in range(N_BLADES)]
    assert len(touching) == REVOLUTION
    assert min(expected) > 0
    _, bank = integrate(modes, scene, [SPEED], REVOLUTION)
    assert bank.law.steps_touched(0).tolist() == expected
    found = scene.interface.of_points(touching).sum(axis=0)
    np.testing.assert_array_equal(found, bank.law.steps_touched(0))


@pytest.mark.parametrize(("gap", "reason"), [(2e-3, status.NONE), (-2e-3, status.PERMANENT)])
def test_a_blade_that_is_always_pressed_has_no_amplitude(gap, reason):
    """A blade that is too long by 2 mm all around touches all the time; one too short by 2 mm,
    between the bumps of 3 mm, does not."""
    modes, scene = made_up(0)
    own = np.where(scene.interface.blade == 1, gap, 2.5e-3)
    steady = SteadyCriteria(first_check=0.2, window_revolutions=1, max_time=0.2)
    scene = scene._replace(clearance=0.0, step=1.0 / (SPEED * REVOLUTION), steady=steady)
    scene = scene._replace(interface=scene.interface._replace(clearance=own))
    result = run_sweep(modes._replace(omega=np.maximum(modes.omega, 3e3)), scene, [SPEED])
    assert result.max_sweeps[0] > 0
    assert result.point_reason[0] == reason
    assert np.isnan(result.amplitude[0]) == (reason != status.NONE)


def turned_by_friction(omega, friction, belt, velocity, times):
    """Motion ü + ω²u = −friction·sign(belt + u̇) from u = 0, exact between reversals (never stuck).

    Returns places at the times, and how often the slip reversed.
    """
    found, start, u, v, way, reversals = np.zeros(len(times)), 0.0, 0.0, velocity, 1.0, 0
    while start < times[-1]:
        at = -way * friction / omega**2

        def speed(t, u=u, v=v, at=at):
            return v * np.cos(omega * t) - omega * (u - at) * np.sin(omega * t)

        def place(t, u=u, v=v, at=at):
            return at + (u - at) * np.cos(omega * t) + v / omega * np.sin(omega * t)

        grid = np.linspace(1e-9, 2.0 * np.pi / omega, 400)
        slips = way * (belt + speed(grid)) > 0.0
        end = np.inf
        if not slips.all():
            first = int(np.argmin(slips))
            end = brentq(lambda t: belt + speed(t), grid[first - 1], grid[first], xtol=1e-15)
        here = (times >= start) & (times < start + min(end, grid[-1]))
        found[here] = place(times[here] - start)
        t = min(end, grid[-1])
        u, v, start = place(t), speed(t), start + t
        if end < np.inf:
            assert omega**2 * abs(u) > friction
            way, reversals = -way, reversals + 1
    return found, reversals


def test_friction_reverses_with_the_slip():
    """A tip that is pressed and vibrates along the casing faster than it rotates; first order."""
    omega, pressed, mu, speed, radius = 2.0 * np.pi * np.array([400.0, 60.0]), 1e-3, 0.05, 2.0, 0.5
    belt, velocity = 2.0 * np.pi * speed * radius, 25.0  # [m/s]
    force = mu * omega[0] ** 2 * pressed
    one = np.array([[1.0, 0.0]]), np.array([[0.0, 1.0]])
    modes = Modes(omega, *one, np.zeros((1, 2)), one[1], np.eye(2))
    face = Interface(
        *np.zeros((2, 1), int), np.array([radius]), *np.zeros((2, 1)), *one, modes.axial, one[1],
        np.zeros(1, int),
    )  # fmt: skip
    steps, errors = 1e-5 / 2.0 ** np.arange(2), []
    for step in steps:
        scene = Scene(
            face, 0.0, CasingShape(1, 0.0), -pressed, 0.0, mu, scheme="exact_modal", step=step
        )
        scene, motion = scene._replace(record_interval=step), Motion.at_rest(1, 2)
        motion.position[0, 0], motion.velocity[0, 1] = -pressed, velocity
        time, u = whole(modes, scene, [speed], 0.05, "time", "observed", motion=motion)
        u, time = u[time[:, 0] < 0.05, 0, 0], time[time < 0.05]
        expected, reversals = turned_by_friction(omega[1], force, belt, velocity, time)
        errors.append(np.abs(u - expected).max() / np.abs(expected).max())
    assert reversals >= 4
    assert errors[-1] < 1e-2
    assert 0.8 < fitted_order(steps, np.array(errors)) < 1.2
