"""The contact kernel against implementations that share no code with it.

Theory: central differences on every mode, (1 + c) q_{n+1} = h² f + (2 − ω²h²) q_n − (1 − c) q_{n−1}
with c = ξωh, written without the kernel's increments. Both are the same scheme, so they agree to
rounding as long as rounding is not amplified (some hundred steps). The multipliers solve a linear
complementarity problem, here found by trying all sets of contacts. The kernel works on contact
points and knows of no blades: in the last tests every blade of a small disk touches at its tip and
at the node before it. (`tests.evidence` has a whole disk without modal coordinates.)
"""

import itertools
import os
import subprocess
import sys

import numpy as np
import pytest

from evidence.truth.disk import make_disk, reference_reduced, reference_scene
from evidence.validation.report import fitted_order
from hpcrub.contact.bank import allocate, fill_lane
from hpcrub.contact.integrate import run
from hpcrub.contact.observers import Record, strokes
from hpcrub.contact.recurrence import coefficients
from hpcrub.model import casing
from hpcrub.model.casing import CasingShape
from hpcrub.model.interface import Interface, planar_interface
from hpcrub.model.reduction import Modes, craig_bampton, mistuned_modes
from hpcrub.response.linear import engine_order_response
from hpcrub.response.revolution import Grid, cut_revolution
from hpcrub.response.scene import Scene
from hpcrub.response.steady import SteadyCriteria, localisation
from hpcrub.response.sweep import run_sweep
from tests.program import ROOT, whole

SPEEDS = np.array([33.5, 34.0, 34.5])
REVOLUTION = 1500  # steps


def integrate_lanes(modes, scene, speeds, n_blocks, width, revolution=REVOLUTION):
    """Histories u_t (steps, n_c, lanes) of some blocks, recorded at every step, and the lanes."""
    grid = Grid(revolution, scene.casing.n_bumps, 1)
    bank = allocate(modes, scene, grid, width, speeds)
    record = Record.allocate(bank, n_blocks, 1)
    run(bank, n_blocks, record)
    history = record.history.reshape(n_blocks * grid.steps_per_block, -1, width)
    return history[:, : len(modes.observed), : len(speeds)], bank


def test_strokes_are_those_of_the_records_of_a_ring_in_order():
    ring = np.random.default_rng(0).normal(size=(6, 3, 2))  # records, rows, lanes
    oldest, n_rows, lane = 4, 2, 1
    records = np.roll(ring, -oldest, axis=0)[:, :n_rows, lane]
    stroke, jump = strokes(ring.reshape(-1, 2), lane, 3, n_rows, oldest)
    assert stroke == np.ptp(records[3:], axis=0).max()
    assert jump == np.abs(np.diff(records, axis=0)).max()


def all_contact_sets(W, depth, reach=1e-4, rounding=1e-18):
    """Multipliers of a complementarity problem by trying every set of the points within reach."""
    deep = np.argsort(-depth)[: (depth > -reach).sum()]
    for size in range(len(deep) + 1):
        for chosen in map(list, itertools.combinations(deep, size)):
            lam = np.zeros(len(depth))
            if size:
                lam[chosen] = np.linalg.solve(W[np.ix_(chosen, chosen)], depth[chosen])
            if lam.min() >= 0.0 and (depth - W @ lam).max() <= rounding:
                return lam
    raise AssertionError("no contact set fits")


def central_differences(modes, damping_ratio, h):
    """Free motion of a step h by q and q before, and the factors (K,) of forces on it."""
    w, c = modes.omega * h, damping_ratio * modes.omega * h
    return lambda q, p: ((2.0 - w**2) * q - (1.0 - c) * p) / (1.0 + c), h**2 / (1.0 + c)


def textbook(
    modes, scene, speed, n_steps, revolution=REVOLUTION, reach=1e-4, rounding=1e-18,
    step_of=central_differences,
):  # fmt: skip
    """Observed displacements (n, O) and normal forces (n, C), until a point jams.

    Friction is along the slip of the step before, which in a plane is forward.
    """
    h, points = 1.0 / (speed * revolution), scene.interface
    free_of, per_force = step_of(modes, scene.damping_ratio, h)
    rows = np.stack([part for part in (modes.tangential, modes.axial) if len(part)])
    q, before = np.zeros((2, len(modes.omega)))
    seen, forces = [], []
    for step in range(1, n_steps + 1):
        free = free_of(q, before)
        turned = points.angle + 2.0 * np.pi * step / revolution
        bump = casing.bump_height(turned, *scene.casing[:2])
        depth = modes.normal @ free + casing.ramp(step * h, scene.ramp_time) * bump
        depth -= scene.clearance + points.clearance
        slip = rows @ (q - before) / h
        slip[0] += 2.0 * np.pi * speed * points.radius
        way = slip / np.linalg.norm(slip, axis=0)
        push = modes.normal + scene.friction * np.einsum("dc,dck->ck", way, rows)
        found, W = np.zeros(len(depth)), (modes.normal * per_force) @ push.T
        if (np.diag(W)[depth > 0.0] <= 0.0).any():
            break
        if depth.max() > 0.0:
            found = all_contact_sets(W, depth, reach, rounding)
        q, before = free - per_force * (push.T @ found), q
        seen.append(modes.observed @ q)
        forces.append(found)
    return np.array(seen), np.array(forces)


@pytest.fixture(scope="module")
def reduced():
    return reference_reduced()


@pytest.fixture(scope="module")
def mistuned(reduced):
    order = [3, 8, 1, 11, 5, 0, 9, 2, 6, 10, 4, 7]
    return mistuned_modes(reduced, np.linspace(-0.04, 0.04, 12)[order])


def test_kernel_is_the_textbook_scheme_to_rounding(mistuned):
    scene = reference_scene()
    history, _ = integrate_lanes(mistuned, scene, SPEEDS, n_blocks=2, width=8)
    for lane, speed in enumerate(SPEEDS):
        tips, forces = textbook(mistuned, scene, speed, len(history))
        contacts = forces != 0.0
        assert contacts.any(axis=0).sum() >= 4
        assert contacts.sum(axis=1).max() >= 3
        assert np.abs(history[:, :, lane] - tips).max() < 1e-9 * np.abs(tips).max()


def test_a_history_holds_the_forces_of_the_textbook_scheme(mistuned):
    scene = reference_scene(step=2e-5)
    grid = cut_revolution(SPEEDS[0], scene)
    names = "normal_force", "tangential_force"
    found = whole(mistuned, scene, SPEEDS[:1], 0.4 / SPEEDS[0], *names)
    radial, tangential = (force[:, :, 0] for force in found)
    n_steps = len(radial) * grid.stride
    _, forces = textbook(mistuned, scene, SPEEDS[0], n_steps, grid.steps_per_revolution)
    mean = forces.reshape(len(radial), grid.stride, -1).mean(axis=1)
    assert radial.max() > 100.0  # [N]
    for found, expected in ((radial, mean), (tangential, scene.friction * mean)):
        assert np.abs(found - expected).max() < 1e-7 * radial.max()


def plain_python(expression, module, folder):
    """Array that an expression gives in a module of these tests where nothing is compiled."""
    code = f"import numpy; from {module} import *; numpy.save('twin.npy', {expression})"
    plain = os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, "-c", code], check=True, cwd=folder, env=plain)
    return np.load(folder / "twin.npy")


def released(name, n_steps, damping_ratio=0.02):
    """A mass released from 1 m at rest, over one second of a 5 Hz oscillation: error at its end."""
    ones, omega, face = np.ones((1, 1)), 2.0 * np.pi * 5.0, planar_interface(np.zeros(1), 1.0)
    modes = Modes.planar(np.array([omega]), ones, ones)
    scene = Scene(face, damping_ratio, CasingShape(1, 0.0), 10.0, 0.01, 0.0, scheme=name)
    bank = allocate(modes, scene, Grid(n_steps, 1, 1), 8)
    h = 1.0 / n_steps
    fill_lane(bank, 0, modes, scene, h)
    decay, omega_d = damping_ratio * omega, omega * np.sqrt(1.0 - damping_ratio**2)

    def exact(t):
        return np.exp(-decay * t) * (np.cos(omega_d * t) + decay / omega_d * np.sin(omega_d * t))

    bank.state.position[0, 0] = 1.0
    bank.state.increment[0, 0] = 1.0 - exact(-h)
    run(bank, 1)
    return abs(bank.state.position[0, 0] - exact(1.0))


def test_exact_modal_has_no_error_without_contact():
    assert max(released("exact_modal", n) for n in (17, 100, 10_000)) < 1e-10


def test_free_motion_is_of_second_order_by_central_differences():
    steps = 500 * np.array([1, 2, 4, 8])
    errors = [released("central_difference", n) for n in steps]
    assert 1.95 < fitted_order(1.0 / steps, errors) < 2.05


def phase(omega, h, damping_ratio=0.01):
    """Angle [rad] by which the free samples of a mode turn in a step, and their decay."""
    decay, gain = coefficients("exact_modal", np.array([omega]), damping_ratio, h)
    trace = 1.0 + decay[0] - omega**2 * gain[0]
    roots = np.roots([1.0, -trace, decay[0]])
    return np.abs(np.angle(roots)).max(), np.abs(roots).max()


def test_modes_too_fast_for_the_step_do_not_look_slow():
    """Sampled exactly, a mode at ωh = 2πk + ε turns by ε: as slow as a mode that is not there."""
    for omega_h in [2.01, 3.0, 2.0 * np.pi, 2.0 * np.pi + 0.05, 4.0 * np.pi - 0.1, 30.0, 300.0]:
        angle, size = phase(omega_h / 1e-5, 1e-5)
        assert np.pi / 2.0 - 0.05 < angle <= np.pi + 1e-12
        assert size < 1.0
    assert phase(1.9e5, 1e-5)[0] == pytest.approx(1.9 * np.sqrt(1.0 - 0.01**2), rel=1e-9)


def test_a_constant_force_gives_its_static_deflection_at_any_step():
    """Of a fast mode, damped as much as it is: after some hundred steps nothing else is left."""
    for omega_h in (0.5, 1.9, 2.1, 20.0):
        decay, gain = (c[0] for c in coefficients("exact_modal", np.array([omega_h]), 0.3, 1.0))
        q = d = 0.0
        for _ in range(2000):
            d = decay * d - omega_h**2 * gain * q + gain
            q += d
        assert q == pytest.approx(1.0 / omega_h**2, rel=1e-9)


def test_a_rigid_body_mode_has_finite_coefficients():
    for name in ("central_difference", "exact_modal"):
        keep, push = coefficients(name, np.zeros(1), 0.01, 1e-5)
        assert keep[0] == 1.0
        assert abs(push[0] / 1e-10 - 1.0) < 1e-12


N_BLADES, SPEED = 4, 36.0
APART = 0.03  # [rad] from the tip to the second point
DEVIATION = np.array([-0.03, 0.02, 0.04, -0.01])


@pytest.fixture(scope="module")
def with_two_points():
    tuned = make_disk(n_blades=N_BLADES, blade={"n_elements": 3})
    before = tuned.blade_dof[:, -6:-4]
    two = tuned._replace(
        contact_dof=np.vstack([tuned.contact_dof, before]),
        contact_blade=np.tile(np.arange(N_BLADES), 2),
        contact_angle=np.concatenate([tuned.contact_angle, tuned.contact_angle - APART]),
        contact_radius=np.concatenate([tuned.contact_radius, tuned.contact_radius]),
    )
    return craig_bampton(two, 0)


def scene_of(reduced, **changes):
    defaults = {"interface": reduced.interface, "scheme": "central_difference"}
    return reference_scene(**(defaults | changes))


def test_a_sweep_looks_at_all_points_and_counts_blades(with_two_points):
    """Largest |u_t| of any point, and of each blade, in the second of two revolutions."""
    modes = mistuned_modes(with_two_points, DEVIATION)
    steady = SteadyCriteria(first_check=0.01, window_revolutions=1, max_time=2.0 / SPEED)
    scene = scene_of(with_two_points, step=1.0 / (1500 * SPEED), steady=steady, damping_ratio=0.05)
    n_steps = cut_revolution(SPEED, scene).steps_per_revolution
    result = run_sweep(modes, scene, [SPEED])
    tips, _ = textbook(modes, scene, SPEED, 2 * n_steps, n_steps)
    assert result.time == pytest.approx(2.0 / SPEED)
    last = tips[n_steps:]  # every step, whatever is recorded
    assert result.amplitude == pytest.approx(np.abs(last).max(), rel=1e-6)
    blades = np.abs(last).reshape(-1, 2, N_BLADES).max(axis=(0, 1))
    assert result.localisation[0] == pytest.approx(localisation(blades), rel=1e-6)


def test_an_engine_order_excitation_loads_blades():
    """Twice the same contact points: each carries half the load of its blade, which moves alike."""
    reduced = craig_bampton(make_disk(n_blades=N_BLADES, blade={"n_elements": 3}), 0)
    one, speeds = reduced.interface, np.array([20.0, 21.0])
    two = Interface(*(np.concatenate([values, values]) for values in one[:-1]))
    answers = [
        engine_order_response(
            mistuned_modes(reduced._replace(interface=points), DEVIATION),
            0.005, 150.0, 2, points, speeds,
        )
        for points in (one, two)
    ]  # fmt: skip
    np.testing.assert_allclose(answers[1][:, :N_BLADES], answers[0], rtol=1e-12)
