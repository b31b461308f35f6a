"""Air between the blades: matrices, waves and complex modes against what they are to have."""

import numpy as np
import pytest

from hpcrub.config.schema import Config
from hpcrub.model import aero
from hpcrub.model.imported.cyclic import tuned_diameters
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import mistuned_modes
from hpcrub.setup.problem import build_problem
from tests.program import TINY

N = 12
R = np.arange(N)
OMEGA = 2 * np.pi * 91 * (1 + 0.01 * np.cos(2 * np.pi * R / N + np.pi))
RATIO = 0.005 + 0.002 * np.sin(2 * np.pi * R / N) + 0.001 * np.cos(4 * np.pi * R / N)
CURVE = aero.Curve(0, RATIO, 0.003 * np.cos(2 * np.pi * R / N))


def of_waves(values):
    """Σ_r value_r ψ_r ψ_rᴴ of blades of one mass, wave r being e^{−2πi r j/N}/√N."""
    shapes = np.exp(-2j * np.pi * np.outer(R, R) / N) / np.sqrt(N)
    return (shapes * values) @ shapes.conj().T


def config_in(curve):
    text = TINY + "aero:\n  waves:\n"
    for r in R:
        h = min(r, N - r)
        way = "neither" if 2 * h % N == 0 else "forward" if r == h else "backward"
        text += f"    - {{diameters: {h}, travels: {way}, damping_ratio: {curve.damping_ratio[r]}"
        text += f", frequency_shift: {curve.frequency_shift[r]}}}\n"
    return Config.from_yaml(text)


def reduced_in(curve):
    return build_problem(config_in(curve)).reduced


@pytest.fixture(scope="module")
def reduced():
    return reduced_in(CURVE)


def test_the_mean_decay_stays_and_mistuning_stabilises():
    """The trace: 2.858849 1/s a wave. The least stable one gains, by more with more mistuning."""
    wanted = aero.eigenvalues(OMEGA, CURVE._replace(frequency_shift=0.0 * R))
    damping, stiffness = (of_waves(values).real for values in aero.coefficients(wanted))
    assert -wanted.real.mean() == pytest.approx(2.858849, abs=5e-7)
    least = [(-wanted.real / np.abs(wanted)).min()]
    assert least[0] == pytest.approx(0.0020, abs=1e-4)
    drawn = np.random.default_rng(5).normal(size=N)
    for sigma in (0.01, 0.03):
        mistuned = stiffness + np.diag(sigma * drawn * OMEGA.mean() ** 2)
        found = aero.eigen(damping, mistuned)[0]
        assert -found.real.mean() == pytest.approx(-wanted.real.mean(), rel=1e-12)
        least.append((-found.real / np.abs(found)).min())
    assert least[0] + 5e-4 < least[1] < least[2] < RATIO.mean()


def test_alternate_blades_part_neighbours():
    """Far apart in frequency, blades feel only those of their kind: influence at even distances."""
    distance, omega = np.array([0, 1, -1, 2, -2]), np.full(N, OMEGA.mean())
    damping = np.array([0.005, 0.0008, -0.0008, 0.0005, -0.0005])
    shift = np.array([0.0, 0.0024, -0.0021, 0.0003, 0.0002])
    ratio, shifts = aero.of_influence(N, distance, damping, shift)
    wanted = aero.eigenvalues(omega, aero.Curve(0, ratio, shifts))
    D, K = (of_waves(values).real for values in aero.coefficients(wanted))
    kind = distance % 2 == 0
    limit = aero.of_influence(N, distance[kind], damping[kind], shift[kind])[0].min()
    least = [ratio.min()]  # decay over the mean frequency
    for size in (0.01, 0.05, 0.2):
        found = aero.eigen(D, K + size * omega[0] ** 2 * np.diag((-1.0) ** R))[0]
        least.append(-found.real.max() / omega[0])
    assert 5 * least[0] < least[1] < least[2] < least[3] < limit
    assert least[3] == pytest.approx(limit, rel=0.015)


def test_a_tuned_disk_has_every_wave_as_given_and_it_travels_so(reduced):
    """In the motion of the tips: blade j moves as e^{i(ωt − 2πrj/N)}."""
    modes = mistuned_modes(reduced, np.zeros(N))
    waves = modes.waves
    order = np.argsort(reduced.interface.angle % (2 * np.pi))
    tips = (modes.tangential[:, waves.rows] @ waves.right)[order]
    family = np.flatnonzero(np.isin(tuned_diameters(reduced), range(7)))[:N]
    omega = np.sqrt(reduced.tuned_eigenvalues[family])
    seen = set()
    for k in range(N):
        r = int(np.round(-np.angle(tips[1, k] / tips[0, k]) * N / (2 * np.pi))) % N
        np.testing.assert_allclose(tips[:, k], tips[0, k] * np.exp(-2j * np.pi * r * R / N),
                                   atol=1e-8 * np.abs(tips[0, k]))  # fmt: skip
        own = omega[np.argmin(np.abs(omega * (1 + CURVE.frequency_shift[r])
                                     - waves.eigenvalue[k].imag))]  # fmt: skip
        expected = own * (-RATIO[r] + 1j * (1 + CURVE.frequency_shift[r]))
        assert waves.eigenvalue[k] == pytest.approx(expected, rel=1e-10)
        seen.add(r)
    assert seen == set(R)


def test_of_a_mistuned_disk_the_complex_modes_are_those_of_the_whole_matrices(reduced):
    """D and K of the air in the coordinates of the tuned family, all of it in one eigenproblem."""
    deviation = stiffness_deviation(5, 0, 0, N, 0.04)
    modes = mistuned_modes(reduced, deviation)
    waves, air = modes.waves, reduced.air
    part = np.linalg.solve(reduced.tuned_modes, modes.shapes)[:, waves.rows]
    own, omega = np.sqrt(air.squared), modes.omega[waves.rows]
    d, k = aero.coefficients(aero.eigenvalues(own, CURVE))
    D, even, odd = (
        part.T @ ((air.waves * values) @ air.waves.conj().T) @ part
        for values in (d, k.real - own**2, 1j * k.imag / own)
    )
    K = even + np.sqrt(np.outer(omega, omega)) * odd
    for whole, found in ((D, waves.damping), (K, waves.stiffness)):
        assert np.abs(whole.imag).max() < 1e-9 * np.abs(whole).max()
        np.testing.assert_allclose(found, whole.real, atol=1e-11 * np.abs(whole).max())
    K = np.diag(omega**2) + waves.stiffness
    for k, value in enumerate(waves.eigenvalue):
        left = value**2 * np.eye(N) + value * waves.damping + K
        assert np.abs(left @ waves.right[:, k]).max() < 1e-8 * np.abs(K @ waves.right[:, k]).max()


def test_soft_blades_whose_waves_are_all_damped_do_not_flutter():
    """Damping and circulation are in proportion to the velocity: every wave keeps its decay.

    With a circulation of the tuned frequency blades 8 % softer flutter where a wave has 0.01 %.
    """
    curve = aero.Curve(0, 0.005 - 0.0049 * np.sin(2 * np.pi * R / N), 0.0 * R)
    reduced = reduced_in(curve)
    omega = np.sqrt(reduced.air.squared)
    softer = mistuned_modes(reduced, np.full(N, -0.08)).waves
    decay = np.sort(curve.damping_ratio * omega)
    np.testing.assert_allclose(np.sort(-softer.eigenvalue.real), decay, rtol=2e-2)
    for sample in range(40):
        deviation = stiffness_deviation(5, 0, sample, N, 0.06) - 0.06
        assert mistuned_modes(reduced, deviation).waves.damping_ratio.min() > 0.0


def test_influence_coefficients_are_the_transform_of_the_waves():
    """Of a blade's own, of the one ahead and the one behind, by hand."""
    damping, shift = aero.of_influence(
        N, np.array([0, 1, -1]), np.array([0.006, 0.001, -0.002]), np.array([0.0, 0.004, 0.003])
    )
    phase = 2 * np.pi * R / N
    by_hand = 0.006 - 0.001 * np.cos(phase) - 0.001 * np.sin(phase)
    np.testing.assert_allclose(damping, by_hand, atol=1e-15)
    np.testing.assert_allclose(shift, 0.007 * np.cos(phase) + 0.003 * np.sin(phase), atol=1e-15)
