"""Run-ups of the product against exact passages, a second program and an ODE solver.

Without contact the load is an exact harmonic of the casing's angle, for which `evidence.truth`
has closed forms.
"""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from evidence.truth import ring
from evidence.truth.disk import DAMPING_RATIO, LOAD, reference_reduced
from evidence.truth.hexahedra import sector_arrays
from evidence.truth.run_up_rubbing import rubbing_run
from evidence.validation import run_up as case
from evidence.validation.report import SCHEMES, fitted_order
from hpcrub.model.casing import CasingShape
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.schedule import Schedule
from hpcrub.setup.disks import modes_of
from hpcrub.setup.problem import build_problem
from tests.program import TINY
from tests.response.test_run_up import scene_and_modes
from tests.setup.test_imported import study_of

HZ, ORDER = case.HZ, case.ORDER
TUNED = np.zeros(12)
MISTUNING = np.linspace(-0.03, 0.03, 12)[[3, 8, 1, 11, 5, 0, 9, 2, 6, 10, 4, 7]]


class Trail(NamedTuple):
    """Modal displacements of R repetitions at the ends of stretches, with the exact time."""

    time: np.ndarray  # of every repetition, negative before it begins to turn (S, R) [s]
    position: np.ndarray  # (S, K, R) [m √kg]
    waits: np.ndarray  # before it begins to turn (R,) [s]


def trail(modes, scene, schedule, repeats=1):
    """The Trail of a run until the last stretch that ends before the schedule does."""
    run, time, position = case.runner(modes, scene, schedule, repeats), [], []
    waits = run.delay / (schedule.speed_hz[0] * run.grid.steps_per_revolution)
    for _ in run.go_on():
        if run.time.max() > schedule.time[-1]:
            break
        time.append(run.time)
        position.append(run.bank.state.position[:, :repeats].copy())
    return Trail(np.array(time), np.array(position), waits)


@pytest.mark.parametrize(
    ("ends", "deviation", "scheme"),
    [((22.7, 23.2), TUNED, SCHEMES[0]), ((23.3, 22.8), MISTUNING, SCHEMES[1])],
    ids=["up, tuned", "down, mistuned"],
)
def test_all_modes_follow_their_closed_form_to_second_order(ends, deviation, scheme):
    """Of the tuned disk two modes of each family answer; where the order ends is 1e-6."""
    modes = mistuned_modes(reference_reduced(case.N_MODES), deviation)
    steps, lasts, errors = 8e-5 * 2.0 ** -np.arange(4), 0.4, []
    for step in steps:
        scene = case.loaded(scheme, step=step, record_interval=0.0)
        run = trail(modes, scene, Schedule([0.0, lasts], ends))
        rate = (ends[1] - ends[0]) / lasts
        exact = case.exact(modes, scene, ends[0], rate, run.time[:, 0]) @ modes.observed.T
        off = run.position[..., 0] @ modes.observed.T - exact
        errors.append(off / np.abs(exact).max())
    largest = np.abs(errors).max(axis=(1, 2))
    assert fitted_order(steps, largest) == pytest.approx(2.0, abs=0.1)
    assert np.abs(4.0 * errors[-1] - errors[-2]).max() / 3.0 < 1e-6  # the limit of the steps


def test_all_repetitions_follow_a_table_that_holds_its_speed():
    """Up, hold, down; waiting lanes and corners have short stretches."""
    modes = mistuned_modes(reference_reduced(case.N_MODES), MISTUNING)
    scene = case.loaded(step=2e-5, record_interval=0.0)
    times, speeds = np.array([0.0, 0.2, 0.3, 0.5]), np.array([22.5, 23.3, 23.3, 22.6])
    run = trail(modes, scene, Schedule(times, speeds), repeats=4)
    for lane in (0, 3):
        waits = run.waits[lane]
        begin = [0.0] if waits else []
        table = np.append(begin, times + waits), np.append(22.5 * np.ones(len(begin)), speeds)
        exact = case.by_table(modes, scene, *table, run.time[:, lane] + waits)
        off = np.abs(run.position[:, :, lane] - exact).max(axis=1)
        assert off.max() < 1e-4 * np.abs(exact).max()


def rubbing_pair(ends, lasts, step):
    """Tips (n, 12) [m] of the product's run at its times (n,) [s], and of the second program."""
    scene, modes = scene_and_modes(TINY)
    scene = scene._replace(step=step, record_interval=0.0, scheme="central_difference")
    run = case.runner(modes, scene, Schedule([0.0, lasts], ends))
    t, tips = case.records(run)
    before = t < lasts - 1.0 / min(ends)
    n, tips_at = round(lasts / step), scene.interface.angle

    def angle(t):
        return HZ * t * (ends[0] + (ends[1] - ends[0]) * t / (2.0 * lasts))

    wall = ring.wall_of(scene)
    moved, force = rubbing_run(modes, scene.damping_ratio, tips_at, wall, angle, lasts / n, n)
    assert (force > 0.0).any(axis=0).all()  # every tip touches
    times, theirs = t[before], lasts / n * np.arange(n + 1)
    return times, tips[before], np.stack([np.interp(times, theirs, tip) for tip in moved.T], axis=1)


def test_a_disk_rubs_as_in_a_program_with_even_steps_of_time():
    """Both are refined; at 18 Hz/s, all tips touch within a few turns."""
    apart = []
    for step in (4e-5, 2e-5, 1e-5):
        t, tips, theirs = rubbing_pair((33.0, 36.0), 0.16, step)
        size = np.abs(theirs).max()
        apart.append(np.abs(tips - theirs).max() / size)
        began = [t[np.abs(x).max(axis=1) > 1e-6 * size][0] for x in (tips, theirs)]
        assert abs(began[0] - began[1]) < 1.5 * step  # the first contact
    assert size > 0.01
    assert apart[2] < apart[1] < apart[0] < 0.05
    assert apart[2] < 3e-3


def imported():
    """Scene, and modes of the tuned disk at rest, all of which is 30 % stiffer at 600 Hz."""
    arrays = sector_arrays()
    for part in ("data", "indices", "indptr"):
        arrays[f"K0/{part}"] = arrays[f"K1/{part}"] = arrays.pop(f"K/{part}")
    arrays["K1/data"] = 0.3 / (HZ * 600.0) ** 2 * arrays["K0/data"]
    config = study_of(arrays, "reduction: {n_modes: 10}\n")
    problem = build_problem(config)
    modes = modes_of(config, problem, np.zeros(config.disk.n_blades))
    free = {"clearance": 1.0, "casing": CasingShape(4, 0.0), "load": LOAD, "load_order": ORDER}
    how = {"scheme": "exact_modal", "step": 2e-6, "record_interval": 0.0}
    return problem.scene._replace(**free, **how, damping_ratio=DAMPING_RATIO), modes


def by_solver(modes, main, force, begin, rate, times):
    """Displacements (T,) [m √kg] of the mode ``main`` with the frequency of every instant."""

    def rates(t, y):
        omega = modes.omega_at(HZ * (begin + rate * t))[main]
        load = (force * np.exp(1j * ORDER * HZ * (begin + rate * t / 2.0) * t)).real
        return [y[1], load - omega * (omega * y[0] + 2.0 * DAMPING_RATIO * y[1])]

    options = {"rtol": 1e-9, "atol": 1e-16}
    return solve_ivp(rates, (0.0, times[-1]), [0.0, 0.0], "DOP853", times, **options).y[0]


def test_frequencies_are_those_of_the_speed_while_it_changes(folder):
    """By an ODE solver with K(Ω(t)).

    The stiffness changes between stretches, at one phase of the load: of the energy of the springs
    that it adds all or nothing. That is of the order of the frequency's change in a decay time.
    """
    scene, modes = imported()
    force = case.forces(modes, scene)
    main = int(np.abs(force)[:10].argmax())
    at_rest = modes.omega[main] / (ORDER * HZ)

    def off(hz):
        return ORDER * HZ * hz - modes.omega_at(HZ * hz)[main]

    meets = brentq(off, at_rest, 1.5 * at_rest)
    lasts = 75.0 / meets  # turns
    rate = 0.12 * meets / lasts
    begin = meets - rate * lasts / 2.0
    run = trail(modes, scene, Schedule([0.0, lasts], [begin, begin + rate * lasts]))
    time, found = run.time[:, 0], run.position[:, main, 0]
    exact = by_solver(modes, main, force[main], begin, rate, time)
    np.testing.assert_allclose(found, exact, atol=4e-3 * np.abs(exact).max())
    assert abs(meets - at_rest) > abs(rate) * lasts / 2.0  # at rest it is nowhere near
