"""A disk in air that stiffens with the speed, against dense solutions with K(W) and D(W).

The truth is made here, in the modes of the disk at rest: waves are the combinations of eigenvectors
of K(W) in which the tips move as a travelling wave, and have the damping ratios and frequency
shifts that are given, whatever the speed.
"""

import numpy as np
import pytest

from evidence.truth.disk import LOAD, reference_scene
from hpcrub.config.schema import Config
from hpcrub.model.casing import CasingShape
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.linear import engine_order_response, linear_peak
from hpcrub.response.steady import SteadyCriteria
from hpcrub.response.sweep import run_sweep
from hpcrub.setup import plausibility
from hpcrub.setup.aero import in_air
from hpcrub.setup.disks import deviation
from hpcrub.setup.problem import build_problem
from tests.model.test_aero import CURVE, N, R, config_in
from tests.program import TINY

SPEEDS = np.array([20.0, 24.0, 28.0])  # [Hz]
STILL = Config.from_yaml(TINY)
RATIO = 0.005  # of the modes of other families
DAMPED = CURVE._replace(damping_ratio=10 * CURVE.damping_ratio)


def spinning(curve):
    """Reduced disk whose shapes change with the speed: blades are 30 % stiffer at 30 Hz."""
    config, full = config_in(curve), 2 * np.pi * 30.0
    reduced = build_problem(STILL).reduced
    blades = reduced.modal_blade_stiffness.sum(axis=0)
    disk = np.diag(reduced.tuned_eigenvalues) - blades
    slopes = 0.3 / full**2 * blades + 0.1 / full**2 * disk, -0.02 / full**4 * blades
    return config, reduced._replace(stiffening=slopes)


def truth(reduced, curve, hz, deviation):
    """λ_r (N,) of the tuned disk, and dense D and K of a mistuned one in the modes at rest."""
    W, face = 2 * np.pi * hz, reduced.interface
    K = np.diag(reduced.tuned_eigenvalues)
    K = K + W**2 * reduced.stiffening[0] + W**4 * reduced.stiffening[1]
    family = np.linalg.eigh(K)[1][:, :N]
    tips = (face.tangential @ reduced.tuned_modes @ family)[np.argsort(face.angle % (2 * np.pi))]
    psi = family @ np.linalg.solve(tips, np.exp(-2j * np.pi * np.outer(R, R) / N))
    psi /= np.linalg.norm(psi, axis=0)
    own = np.sqrt(np.einsum("kr,kl,lr->r", psi.conj(), K, psi).real)
    wanted = own * (-curve.damping_ratio + 1j * (1 + curve.frequency_shift))
    opposite = wanted[-R % N].conj()
    d, k = -(wanted + opposite), wanted * opposite
    squared, V = np.linalg.eigh(K + np.tensordot(deviation, reduced.modal_blade_stiffness, axes=1))
    omega = np.sqrt(squared)
    of_others = 2 * RATIO * np.where(np.arange(len(omega)) < N, 0.0, omega)
    root = V @ np.diag(np.sqrt(omega)) @ V.T
    D, even, odd = (
        ((psi * values) @ psi.conj().T).real for values in (d, k.real - own**2, 1j * k.imag / own)
    )
    return (
        wanted,
        V @ np.diag(of_others) @ V.T + D,
        V @ np.diag(squared) @ V.T + even + (root @ odd @ root),
    )


def by_frequency(values):
    return values[np.lexsort((values.real, np.round(values.imag, 6)))]


def direct(reduced, curve, hz, deviation, order):
    """Amplitudes (O,) of the observed displacements at a speed, by a dense complex solution."""
    _, D, K = truth(reduced, curve, hz, deviation)
    w, face = 2 * np.pi * abs(order) * hz, reduced.interface
    force = face.share * np.exp(-1j * order * face.angle) @ face.normal @ reduced.tuned_modes
    q = np.linalg.solve(K - w**2 * np.eye(len(K)) + 1j * w * D, LOAD * force)
    return np.abs(face.observed @ reduced.tuned_modes @ q)


@pytest.mark.parametrize("hz", SPEEDS)
def test_every_wave_has_at_every_speed_the_damping_that_is_given(hz):
    """By the matrices of the speed exactly; with shapes of another one frequencies are near."""
    config, reduced = spinning(CURVE)
    wanted = by_frequency(truth(reduced, CURVE, hz, np.zeros(N))[0])
    exact = in_air(config, reduced, 2 * np.pi * hz)
    found = mistuned_modes(exact, np.zeros(N), 2 * np.pi * hz).waves.eigenvalue
    np.testing.assert_allclose(by_frequency(found), wanted, rtol=1e-9)
    at_rest = mistuned_modes(in_air(config, reduced), np.zeros(N))
    near = at_rest.at(hz).waves
    np.testing.assert_allclose(near.damping_ratio, at_rest.waves.damping_ratio, rtol=1e-9)
    np.testing.assert_allclose(np.sort(near.eigenvalue.imag), wanted.imag, rtol=1e-3)
    assert abs(near.eigenvalue.imag / at_rest.waves.eigenvalue.imag - 1).min() > 0.05


@pytest.mark.parametrize(("order", "sample"), [(4, None), (-4, 1), (6, 3)])
def test_the_peak_is_that_of_the_matrices_of_its_speed(order, sample):
    """Whichever speed the modes come from; the dense solution is refined around its maximum."""
    config, reduced = spinning(CURVE)
    deviation = np.zeros(N) if sample is None else stiffness_deviation(5, 0, sample, N, 0.04)
    at = np.linspace(90.0, 115.0, 251) / abs(order)
    for _ in range(3):
        sizes = [direct(reduced, CURVE, hz, deviation, order).max() for hz in at]
        best, step = at[np.argmax(sizes)], at[1] - at[0]
        at = np.linspace(best - step, best + step, 21)
    for start in (None, 2 * np.pi * 26.0):
        disk = in_air(config, reduced, start)
        found, hz = linear_peak(
            mistuned_modes(disk, deviation, start), RATIO, LOAD, order, reduced.interface, N,
            lambda speed, disk=disk: mistuned_modes(disk, deviation, speed),
        )  # fmt: skip
        assert found == pytest.approx(max(sizes), rel=2e-3)
        assert hz == pytest.approx(best, rel=2e-5)


def test_steps_without_contact_tend_to_the_response_at_every_speed():
    """Modes at rest in lanes of three speeds, whose forces move a stiffer disk by less."""
    config, reduced = spinning(DAMPED)
    deviation, order = stiffness_deviation(5, 0, 1, N, 0.02), 4
    modes = mistuned_modes(in_air(config, reduced), deviation)
    scene = reference_scene(
        clearance=1.0, damping_ratio=RATIO, load=LOAD, load_order=order, scheme="exact_modal",
        step=2e-5, record_interval=2e-5, casing=CasingShape(4, 1.25e-3),
        steady=SteadyCriteria(first_check=0.75, max_time=1.5),
    )  # fmt: skip
    speeds = np.array([23.0, 25.0, 26.0])
    found = run_sweep(modes, scene, speeds).amplitude
    expected = engine_order_response(modes, RATIO, LOAD, -order, reduced.interface, speeds)
    np.testing.assert_allclose(found, np.abs(expected).max(axis=1), rtol=1e-3)
    dense = [direct(reduced, DAMPED, hz, deviation, -order).max() for hz in speeds]
    np.testing.assert_allclose(found, dense, rtol=0.03)


def test_what_shapes_of_another_speed_cost_is_estimated():
    """Against frozen matrices: vectors at rest with their Rayleigh quotients, and exact ones."""
    config = STILL.replace({"mistuning.samples": 1, "mistuning.half_range_percent": [2]})
    (_, reduced), hz, order = spinning(CURVE), 28.0, 4
    problem = build_problem(config)._replace(reduced=reduced)
    face, blades = reduced.interface, deviation(config, 0, 0)
    force = face.share * np.exp(-1j * order * face.angle) @ face.normal @ reduced.tuned_modes
    extra = np.tensordot(blades, reduced.modal_blade_stiffness, axes=1)
    rest = np.diag(reduced.tuned_eigenvalues) + extra
    W = 2 * np.pi * hz
    K = rest + W**2 * reduced.stiffening[0] + W**4 * reduced.stiffening[1]
    sizes = []
    for squared, V in ((None, np.linalg.eigh(rest)[1]), np.linalg.eigh(K)):
        squared = np.diag(V.T @ K @ V) if squared is None else squared
        w = np.linspace(0.95, 1.05, 8001)[:, None] * np.sqrt(squared[:N].mean())
        answer = (V.T @ force) / (squared - w**2 + 2j * RATIO * np.sqrt(squared) * w)
        sizes.append(np.abs(answer @ (face.observed @ reduced.tuned_modes @ V).T).max())
    found = plausibility.shape_errors(config, problem, np.array([0.0, hz]))[:, 1]
    assert found[1] == pytest.approx(sizes[0] / sizes[1] - 1.0, abs=2e-4)
    assert abs(found[1]) > 0.01
    (line,) = plausibility._shape_warnings(config.replace({"speeds.to_hz": 50.0}), problem)
    assert line.startswith("not resolved: mode shapes are those of 0 Hz")
    still = problem._replace(reduced=reduced._replace(stiffening=()))
    assert not list(plausibility._shape_warnings(config, still))
