"""Linear response: against a direct solve of the full matrices, and its peak against brute force.

Modal damping on the full model is C = M Phi diag(2 xi omega) Phi^T M with all its modes Phi; then
(K - w^2 M + j w C) u = f needs no modal sum. The load's complex amplitude f is taken from the
samples of equation (5) over one period, not from a formula.
"""

import numpy as np
import pytest
from scipy.linalg import eigh

from evidence.truth.disk import DAMPING_RATIO, LOAD, mistune, reference_disk, reference_reduced
from hpcrub.config.schema import Config
from hpcrub.model.damping import Damping, ratios_of
from hpcrub.model.interface import planar_interface
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import Modes, mistuned_modes
from hpcrub.response.linear import engine_order_response, linear_peak

ANGLE = 2 * np.pi * np.arange(12) / 12
TIPS = planar_interface(ANGLE, 0.5)


def deviation_of(sample):
    return stiffness_deviation(11, 0, sample, 12, 0.04)


def sampled_load(n_diameters, n_times=64):
    """Complex amplitude of F cos(n_d theta - w t), from its samples over a period."""
    turned = 2 * np.pi * np.arange(n_times)[:, None] / n_times  # w t
    force = LOAD * np.cos(n_diameters * ANGLE - turned)
    return 2 / n_times * np.sum(force * np.exp(-1j * turned), axis=0)


def direct_response(disk, n_diameters, speed_hz, ratio=DAMPING_RATIO):
    """Tangential amplitudes by a complex solve of the full model, (S, 12); ratio: of all modes."""
    eigenvalues, Phi = eigh(disk.stiffness, disk.mass)
    projected = Phi.T @ disk.mass
    C = projected.T @ ((2 * ratio * np.sqrt(eigenvalues))[:, None] * projected)
    force = np.zeros(len(C), dtype=complex)
    force[disk.contact_dof[:, 0]] = sampled_load(n_diameters)
    responses = []
    for speed in speed_hz:
        w = 2 * np.pi * abs(n_diameters) * speed
        u = np.linalg.solve(disk.stiffness - w**2 * disk.mass + 1j * w * C, force)
        responses.append(u[disk.contact_dof[:, 1]])
    return np.array(responses)


def response(modes, n_diameters, speed_hz, damping=DAMPING_RATIO):
    return engine_order_response(modes, damping, LOAD, n_diameters, TIPS, speed_hz)


EACH = np.random.default_rng(3).uniform(1e-3, 2e-2, 240)  # damping ratios, of every mode its own


@pytest.mark.parametrize("n_diameters", [1, 4, 6, -4])
@pytest.mark.parametrize(
    ("mistuned", "ratio"), [(False, DAMPING_RATIO), (True, DAMPING_RATIO), (True, EACH)],
    ids=["tuned", "mistuned", "with a damping of each mode"],
)  # fmt: skip
def test_response_is_that_of_the_full_matrices(n_diameters, mistuned, ratio):
    deviation = deviation_of(0) * mistuned
    speed_hz = np.array([20.0, 88.0, 91.0, 92.3, 93.2, 150.0, 541.0]) / n_diameters
    direct = direct_response(mistune(reference_disk(), deviation), n_diameters, speed_hz, ratio)
    modes = mistuned_modes(reference_reduced(216), deviation)
    modal = response(modes, n_diameters, speed_hz, Damping(tuple(np.atleast_1d(ratio))))
    np.testing.assert_allclose(modal, direct, rtol=1e-6, atol=1e-8 * np.abs(direct).max())


def made_up_modes(rng, n_family, spread, cancelling):
    """Closely spaced resonances; cancelling: terms that nearly add up to nothing far away."""
    family = 600 * (1 + spread * rng.uniform(size=n_family))
    omega = np.sort(np.concatenate([family, rng.uniform(700, 9000, 3)]))
    radial, tangential = rng.normal(size=(2, n_family, len(omega)))
    if cancelling:
        radial[:] = 1.0
        tangential -= tangential.mean(axis=1, keepdims=True)
    return Modes.planar(omega, radial, tangential)


def test_peak_of_made_up_modes_at_any_damping_and_spacing():
    """Brute force is a mesh graded to every resonance, steps of 0.008 half-widths or, of modes
    with a damping each, 0.03."""
    rng = np.random.default_rng(1)
    for trial in range(60):
        xi, spread = 10 ** rng.uniform(-4, -1.3), 10 ** rng.uniform(-4, -1)
        n_family, n_d = rng.integers(1, 13), rng.integers(1, 7)
        modes = made_up_modes(rng, n_family, spread, cancelling=trial % 3 == 0)
        points = planar_interface(2 * np.pi * np.arange(n_family) / n_family, 1.0)
        damping = xi
        if trial % 2:
            damping = Damping(tuple(xi * rng.uniform(0.25, 1, len(modes.omega))))
        amplitude, at = linear_peak(modes, damping, LOAD, n_d, points, n_family)
        there = engine_order_response(modes, damping, LOAD, n_d, points, [at])
        assert np.abs(there).max() == pytest.approx(amplitude, rel=1e-12)

        omega, low, high = modes.omega, 0.9 * modes.omega[0], 1.1 * modes.omega[n_family - 1]
        graded = xi * omega[0] * np.sinh(np.linspace(-12, 12, 3001))
        w = np.clip(omega[omega < high][:, None] + graded, low, high).ravel()
        speed_hz = w / (2 * np.pi * n_d)
        brute = np.abs(engine_order_response(modes, damping, LOAD, n_d, points, speed_hz)).max()
        assert brute <= amplitude * (1 + 1e-6), trial
        assert amplitude <= brute * (1 + 1e-4), trial


def test_of_two_nearly_equal_peaks_the_larger_is_found():
    """Two tips with a mode each: c²F/(2ξω²√(1 − ξ²)) in closed form, the other one out of reach.

    They differ by less than what the search mesh makes of them.
    """
    rng = np.random.default_rng(2)
    points, xi = planar_interface(np.zeros(2), 1.0), 5e-3
    for _ in range(50):
        omega = 600.0 * np.array([1.0, 1.0 + rng.uniform(0.05, 0.15)])
        share = 1.0 + rng.uniform(-2e-3, 2e-3, 2)
        own = np.diag(omega * np.sqrt(share))
        amplitude, _ = linear_peak(Modes.planar(omega, own, own), xi, LOAD, 1, points, 2)
        expected = LOAD * share.max() / (2.0 * xi * np.sqrt(1.0 - xi**2))
        assert amplitude == pytest.approx(expected, rel=1e-6)


def test_peak_at_the_edge_of_the_range():
    """So much damping that the response only falls with speed: the first one is the largest."""
    mode = np.ones((1, 1))
    modes = Modes.planar(np.array([100.0]), mode, mode)
    amplitude, speed_hz = linear_peak(modes, 0.6, 1.0, 1, planar_interface(np.zeros(1), 1.0), 1)
    first = 90.0  # [rad/s]
    expected = 1 / abs(100**2 - first**2 + 2j * 0.6 * 100 * first)
    assert amplitude == pytest.approx(expected, rel=1e-12)
    assert speed_hz == pytest.approx(first / (2 * np.pi))


def stiffened(seed, at_speed, fourth=0.0):
    """Modes of a disk of 3 blades whose K0 + W²K1 + W⁴K2 keeps its shapes, and these matrices."""
    rng = np.random.default_rng(seed)
    shapes, _ = np.linalg.qr(rng.normal(size=(6, 6)))
    at_rest = (2 * np.pi * np.array([100.0, 103.0, 106.0, 300.0, 350.0, 400.0])) ** 2
    slopes = np.array([2.0, 1.5, 1.0, 1.0, 3.0, 0.5])
    powers = np.stack([slopes, -fourth * slopes / at_rest])
    K = [shapes @ np.diag(values) @ shapes.T for values in (at_rest, *powers)]
    omega = np.sqrt(at_rest + np.array([at_speed**2, at_speed**4]) @ powers)
    normal, tangential = rng.normal(size=(2, 3, 6))
    normal, tangential = normal @ shapes, tangential @ shapes
    return Modes(
        omega, normal, tangential, np.zeros((0, 6)), tangential, shapes, at_speed, powers
    ), [*K, normal @ shapes.T, tangential @ shapes.T, shapes]


@pytest.mark.parametrize(("engine_order", "fourth"), [(2, 0.0), (3, 0.02), (5, 0.02)])
def test_response_at_every_speed_is_that_of_its_own_stiffness(engine_order, fourth):
    """Against a complex solve with K(W), at speeds around the peak, which is the largest of all."""
    modes, (K0, K1, K2, normal, tangential, V) = stiffened(4, 2 * np.pi * 30.0, fourth)
    points = planar_interface(2 * np.pi * np.arange(3) / 3, 0.5, normal, tangential)
    xi = 0.01
    amplitude, peak_hz = linear_peak(modes, xi, LOAD, engine_order, points, 3)
    speeds = peak_hz * np.linspace(0.9, 1.1, 4001)
    found = engine_order_response(modes, xi, LOAD, engine_order, points, speeds)
    force = LOAD * normal.T @ np.exp(-1j * engine_order * points.angle)
    for k in (0, 1000, 2000, 3500):
        W = 2 * np.pi * speeds[k]
        K, w = K0 + W**2 * K1 + W**4 * K2, engine_order * W
        C = V @ np.diag(2 * xi * np.sqrt(np.diag(V.T @ K @ V))) @ V.T
        u = tangential @ np.linalg.solve(K - w**2 * np.eye(6) + 1j * w * C, force)
        np.testing.assert_allclose(found[k], u, rtol=1e-9, atol=1e-12 * np.abs(u).max())
    np.testing.assert_allclose(np.abs(found).max(), amplitude, rtol=1e-6)
    assert np.abs(found).max() <= amplitude * (1 + 1e-9)
    fixed, _ = linear_peak(modes._replace(stiffening=np.zeros((0, 0))), xi, LOAD, engine_order,
                           points, 3)  # fmt: skip
    assert abs(fixed / amplitude - 1) > 1e-3


def test_a_mode_that_lost_its_stiffness_below_the_peak_hides_no_peak():
    """The last mode's ω² is zero from 45 Hz on, where matrices of lower speeds are extrapolated."""
    modes, (*_, normal, tangential, _) = stiffened(4, 2 * np.pi * 30.0)
    falls = modes.stiffening.copy()
    falls[:, -1] = -((modes.omega[-1] / (2 * np.pi)) ** 2) / (45.0**2 - 30.0**2), 0.0
    modes = modes._replace(stiffening=falls)
    points = planar_interface(2 * np.pi * np.arange(3) / 3, 0.5, normal, tangential)
    amplitude, peak_hz = linear_peak(modes, 0.01, LOAD, 2, points, 3)
    assert modes.omega_at(2 * np.pi * peak_hz)[-1] == 0.0
    speeds = np.linspace(51.0, 90.0, 40_001)
    found = np.abs(engine_order_response(modes, 0.01, LOAD, 2, points, speeds)).max()
    assert amplitude == pytest.approx(found, rel=1e-5)


def test_a_load_that_never_meets_the_disk_sees_its_frequencies_of_the_middle():
    """ω² grows by 2 W², W² faster than the load of engine order 1."""
    modes, (*_, normal, tangential, _) = stiffened(4, 2 * np.pi * 30.0)
    points = planar_interface(2 * np.pi * np.arange(3) / 3, 0.5, normal, tangential)
    disks = modes, modes._replace(stiffening=np.zeros((0, 0)))
    never, fixed = (linear_peak(disk, 0.01, LOAD, 1, points, 3) for disk in disks)
    assert never == fixed


OMEGA = 2 * np.pi * np.array([80.0, 90.0, 100.0, 150.0, 200.0, 900.0])


@pytest.mark.parametrize(
    ("damping", "expected"),
    [
        (Damping((1e-3, 2e-3)), (1e-3, 2e-3, 2e-3, 2e-3, 2e-3, 2e-3)),
        (Damping((1e-3, 2e-3, 3e-3), family=2), (1e-3, 1e-3, 2e-3, 2e-3, 3e-3, 3e-3)),
        (
            Damping((1e-3, 2e-3, 3e-3), bands=(2 * np.pi * 100.0, 2 * np.pi * 200.5)),
            (1e-3, 1e-3, 1e-3, 2e-3, 2e-3, 3e-3),
        ),
        (0.01, 0.01),
    ],
)
def test_ratios_of_modes(damping, expected):
    np.testing.assert_array_equal(ratios_of(damping, OMEGA), expected)


def test_the_keys_of_damping():
    config = Config.from_yaml("material: {damping_ratios: [0.01, 0.02], damping_of: families}")
    assert config.damping == Damping((0.01, 0.02), family=12)
    config = Config.from_yaml(
        "material: {damping_ratios: [0.01, 0.02], damping_of: bands, damping_bands_hz: [100]}"
    )
    assert config.damping == Damping((0.01, 0.02), bands=(2 * np.pi * 100,))
    assert Config.from_yaml("material: {damping_ratio: 0.004}").damping == 0.004
