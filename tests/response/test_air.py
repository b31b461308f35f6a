"""Motions of disks in air: the linear response, free motions, contact, growth."""

import numpy as np
import pytest
from scipy.linalg import expm

from evidence.truth import air, ring
from hpcrub.config.schema import Config
from hpcrub.contact.status import NOT_STEADY
from hpcrub.model import aero
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.linear import engine_order_response, linear_peak
from hpcrub.response.revolution import cut_revolution
from hpcrub.response.sweep import Motion, run_sweep
from hpcrub.setup.problem import build_problem
from tests.model.test_aero import CURVE, OMEGA, RATIO, N, R, of_waves, reduced_in
from tests.program import TINY, whole

SPEED = 35.0


@pytest.fixture(scope="module")
def reduced():
    return reduced_in(CURVE)


@pytest.fixture(scope="module")
def scene():
    return build_problem(Config.from_yaml(TINY)).scene._replace(record_interval=0.0)


def disk(reduced, half_range=0.04):
    return mistuned_modes(reduced, stiffness_deviation(5, 0, 0, N, half_range))


def matrices(modes, ratio):
    """D and K of all real modes, dense where the air couples them."""
    D, K = np.diag(2 * ratio * modes.omega), np.diag(modes.omega**2)
    family = np.ix_(modes.waves.rows, modes.waves.rows)
    D[family] = modes.waves.damping
    K[family] += modes.waves.stiffness
    return D, K


@pytest.mark.parametrize("order", [4, -3, 1])
def test_the_linear_response_is_that_of_a_direct_solution(reduced, scene, order):
    modes, face = disk(reduced), scene.interface
    speeds = np.linspace(80, 105, 26) / abs(order)
    D, K = matrices(modes, scene.damping_ratio)
    load = (face.share * np.exp(-1j * order * face.angle)) @ modes.normal
    direct = np.array([
        modes.observed @ np.linalg.solve(K - w * w * np.eye(len(K)) + 1j * w * D, load)
        for w in 2 * np.pi * abs(order) * speeds
    ])  # fmt: skip
    found = engine_order_response(modes, scene.damping_ratio, 1.0, order, face, speeds)
    np.testing.assert_allclose(found, direct, rtol=0, atol=1e-10 * np.abs(direct).max())
    peak, at = linear_peak(modes, scene.damping_ratio, 1.0, order, face, N)
    mesh = np.linspace(0.98, 1.02, 2001) * at
    near = np.abs(engine_order_response(modes, scene.damping_ratio, 1.0, order, face, mesh))
    assert near.max() == pytest.approx(peak, rel=1e-5)


def test_blades_of_one_mass_never_exceed_the_limits_of_whitehead():
    """A ≤ (1 + √N)/2 of equal waves, and A ≤ ½ [1 + √(ζ_n Σ 1/ζ_r)] of a load of n diameters."""
    omega, drawn = OMEGA, np.random.default_rng(8)  # coupled by the disk
    near = omega.mean() * np.linspace(0.95, 1.05, 801)
    for ratio, n in ((np.full(N, 0.005), 3), (RATIO, 1), (RATIO, 4), (RATIO, 8)):
        wanted = aero.eigenvalues(omega, aero.Curve(0, ratio, 0.0 * R))
        D, K = (of_waves(values).real for values in aero.coefficients(wanted))
        load = np.exp(-2j * np.pi * n * R / N)
        most = []
        for sigma in (0.0, *np.repeat([0.005, 0.01, 0.02], 12)):
            mistuned = K + np.diag(sigma * drawn.normal(size=N) * omega**2)
            pencil = mistuned - near[:, None, None] ** 2 * np.eye(N) + 1j * near[:, None, None] * D
            x = np.linalg.solve(pencil, np.broadcast_to(load, (len(near), N))[..., None])
            most.append((near[:, None] * np.abs(x[..., 0])).max())  # of the velocity
        limit = aero.largest_amplification(ratio, np.ones((1, N)), n)
        assert 1.2 < max(most[1:]) / most[0] < limit
        assert limit == pytest.approx((1 + np.sqrt(N)) / 2) or ratio is RATIO


def test_a_free_motion_is_that_of_the_matrix_exponential(reduced, scene):
    modes, far = disk(reduced), scene._replace(clearance=1.0)
    D, K = matrices(modes, scene.damping_ratio)
    m = len(D)
    start = np.zeros(m)
    start[modes.waves.rows] = 1e-3 * np.random.default_rng(3).normal(size=N)
    motion = Motion.at_rest(1, modes.n_rows)
    motion.position[0] = modes.at_rest(start)
    q, time = whole(modes, far, [SPEED], 2.0 / SPEED, "position", "time", motion=motion)
    A = np.block([[np.zeros((m, m)), np.eye(m)], [-K, -D]])
    for k in (0, 100, len(time) - 1):
        true = (expm(A * time[k, 0]) @ np.concatenate([start, 0 * start]))[:m]
        np.testing.assert_allclose(q[k, :, 0], true, rtol=0, atol=1e-10 * np.abs(start).max())


def test_in_contact_the_steps_tend_to_those_of_one_system_of_first_order(reduced, scene):
    """`evidence.truth.air`, with the order of the step: two of position, in an asymmetric air."""
    modes, wall = disk(reduced), ring.wall_of(scene)
    D, K = matrices(modes, scene.damping_ratio)
    off = []
    for step in (2e-5, 1e-5, 5e-6):
        fine = scene._replace(step=step, least_steps=0.0, scheme="exact_modal")
        q, force = whole(modes, fine, [SPEED], 0.5 / SPEED, "position", "normal_force")
        steps = cut_revolution(SPEED, fine).steps_per_revolution
        true, pushes = air.integrate(
            D, K, modes.normal, modes.tangential, scene.interface.angle, wall, SPEED, steps, len(q)
        )
        assert force.any()
        assert pushes.any()
        off.append(np.abs(modes.observed @ (q[:, :, 0] - true).T).max())
    size = np.abs(modes.observed @ true.T).max()
    assert off[-1] < 1e-4 * size
    assert 2.5 < off[0] / off[1] < 8
    assert 2.5 < off[1] / off[2] < 8


def test_a_disk_that_flutters_is_no_steady_motion_and_has_no_linear_peak(scene):
    growing = CURVE._replace(damping_ratio=np.where(R == 2, -0.004, RATIO))
    modes = mistuned_modes(reduced_in(growing), np.zeros(N))
    assert linear_peak(modes, 0.005, 1.0, 4, scene.interface, N)[0] == np.inf
    result = run_sweep(modes, scene, [SPEED])
    assert result.point_status[0] == NOT_STEADY
