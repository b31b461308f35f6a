"""Kinematics to second order: the kernel against a program that shares no code with it.

The second program closes gaps by the whole gradients of all points, where the kernel leaves out how
the tilt of a blade's point changes what other blades' forces move it by.
"""

from functools import cache, partial
from itertools import permutations

import numpy as np
import pytest

from evidence.truth import second_order as truth
from evidence.truth.ring import wall_of
from hpcrub.contact.bank import allocate, fill_lane
from hpcrub.contact.integrate import run
from hpcrub.contact.observers import Record
from hpcrub.contact.status import BENT
from hpcrub.model.casing import CasingShape
from hpcrub.model.reduction import mistuned_modes
from hpcrub.model.second_order import SecondOrder
from hpcrub.model.tuned_basis import own_modes, tuned_basis
from hpcrub.response.revolution import Grid
from hpcrub.response.scene import Scene
from hpcrub.response.sweep import run_sweep
from hpcrub.setup.problem import build_problem
from tests.model.test_tuned_basis import small_disk
from tests.program import load

WIDTH, XI = 4, 0.01  # as many lanes as other tests of this law take: each number is compiled
DEVIATION = 0.03 * np.sin(1.7 * np.arange(12.0))


@cache
def planar(kinematics="second_order"):
    """Modes of the mistuned reference disk, and its scene."""
    problem = build_problem(load("inputs/quickstart.yaml", [f"contact.kinematics={kinematics}"]))
    scene = problem.scene._replace(damping_ratio=XI, ramp_time=1e-3)
    return mistuned_modes(problem.reduced, DEVIATION), scene


def spatial(is_cyclic, size=0.3):
    """Modes and scene of five blades with two points each; size: of all second order.

    At size 1 the second order of a motion of 0.3 mm is a third of it.
    """
    model = small_disk(5, by_modes=True)
    face, rng = model.interface, np.random.default_rng(3)
    points = np.argsort(face.blade, kind="stable").reshape(5, 2)
    rows = [face.tangential[points[:, 0]], face.axial[points[:, 0]], face.normal[points[:, 1]]]
    bent = np.einsum("pbm,bmk->bpk", rows, model.blade_stiffness)
    bent /= np.abs(bent @ model.tuned_modes).max(axis=(0, 2))[:, None]
    G = 1e4 * size * rng.standard_normal((2, 3, 3, 3))
    C = 2e10 * size * rng.standard_normal((3, 3, 3))
    D = 2e16 * size**2 * rng.standard_normal((3, 3, 3, 3))
    moved = 2e3 * size * rng.standard_normal((2, 2, 4))  # of two bent modes
    moved += moved.swapaxes(0, 1)
    inertia = np.einsum("abi,cdi->abcd", moved, moved)
    shortening = np.empty((len(face.blade), 3, 3, 3))
    shortening[points] = G + G.swapaxes(2, 3)
    coupling, quartic = (
        sum(part.transpose(order) for order in permutations(range(part.ndim))) for part in (C, D)
    )
    curvature = size / face.radius
    little = np.full((len(face.blade), 3), 1e3), 2e4 * np.ones(3)  # modes that bend little
    second = SecondOrder(
        bent, shortening, shortening[:, 1], coupling, little[1], curvature, little[0], quartic,
        inertia[(np.s_[: 0 if is_cyclic else 2],) * 4],  # no disk in the cyclic basis has it
    )  # fmt: skip
    face = face._replace(second_order=second)
    modes = tuned_basis(model._replace(interface=face), 0.06).modes_of(DEVIATION[:5]).fixed
    scene = Scene(face, XI, CasingShape(2, 3e-4), 1e-4, 1e-3, 0.2, scheme="exact_modal")
    return modes if is_cyclic else own_modes(modes), scene


def integrated(modes, scene, speed, revolution):
    """Observed displacements (n, O) of the first lane, from rest, until a bump has passed."""
    grid = Grid(revolution, scene.casing.repeats, 1)
    bank = allocate(modes, scene, grid, WIDTH)
    fill_lane(bank, 0, modes, scene, 1.0 / (speed * revolution))
    record = Record.allocate(bank, 1, 1)
    run(bank, 1, record)
    found = record.history.reshape(grid.steps_per_block, -1, WIDTH)
    return found[:, : len(modes.observed), 0]


def second_program(modes, scene, speed, revolution, order="second"):
    """The same by the other program."""
    n_steps = revolution // scene.casing.repeats
    structure = truth.structure_of(modes, scene.interface, scene.interface.second_order, XI)
    found = truth.integrate(
        structure, wall_of(scene), speed, 1.0 / (speed * revolution), n_steps, order, scene.scheme
    )
    return found.place[:, :, 1]


CASES = {
    "planar": (planar, 35.0, 4000),
    "dense": (partial(spatial, False), 80.0, 8000),
    "cyclic": (partial(spatial, True), 80.0, 16000),
}


@pytest.mark.parametrize(
    "case",
    ["planar", *(pytest.param(case, marks=pytest.mark.long) for case in ("dense", "cyclic"))],
)
def test_the_kernel_is_the_second_program_as_the_step_shrinks(case):
    """They differ by the time at which bent modes push, and by the casing between two steps."""
    disk, speed, finest = CASES[case]
    modes, scene = disk()
    own, coarse = own_modes(modes) if modes.blades else modes, finest // 2
    exact = {steps: second_program(own, scene, speed, steps) for steps in (coarse, finest)}
    errors = [
        np.abs(integrated(modes, scene, speed, steps) - found).max()
        for steps, found in exact.items()
    ]
    first = second_program(own, scene, speed, coarse, "first")
    assert errors[1] < 0.6 * errors[0]
    assert errors[1] < 0.009 * np.abs(first - exact[coarse]).max()


def test_blades_that_bend_further_than_the_second_order_tells_have_no_result():
    """b u reaches 0.3 at 71 mm on the reference disk; 5 mm are soon passed."""
    modes, scene = planar()
    assert scene.furthest == pytest.approx(0.071, rel=0.05)
    found = run_sweep(modes, scene._replace(furthest=5e-3), [34.5], width=WIDTH)
    assert found.point_reason == [BENT]
    assert np.isnan(found.amplitude).all()
