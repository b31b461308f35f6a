"""Craig-Bampton against the full model it came from.

With all fixed-interface modes the reduced coordinates are only another basis: frequencies are
those of the full model, mistuned too. With none, static response to contact forces stays exact.
In between, reduced frequencies lie above the full ones and fall with every mode (Rayleigh-Ritz).
"""

import numpy as np
import pytest
from scipy.linalg import eigh

from evidence.truth.disk import (
    earlier_reduced,
    make_disk,
    mistune,
    reference_disk,
    reference_reduced,
)
from hpcrub.model.families import whole
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import craig_bampton, mistuned_modes

ALL_MODES = 216
DEVIATION = stiffness_deviation(2020, 3, 0, 12, 0.04)


def full_frequencies(disk):
    return np.sqrt(eigh(disk.stiffness, disk.mass, eigvals_only=True))


def test_frequencies_of_the_reduced_model_are_the_reference_values():
    """Reference values of an independent implementation of the same geometry and reduction."""
    hz = mistuned_modes(earlier_reduced(), np.zeros(12)).omega / (2 * np.pi)
    assert len(hz) == 84
    assert hz[0] == pytest.approx(90.1216, abs=5e-5)
    assert hz[-1] == pytest.approx(8971, abs=0.5)


@pytest.mark.parametrize("deviation", [np.zeros(12), DEVIATION], ids=["tuned", "mistuned"])
def test_all_modes_make_the_reduction_exact(deviation):
    disk = reference_disk()
    exact = full_frequencies(mistune(disk, deviation))
    np.testing.assert_allclose(
        mistuned_modes(reference_reduced(ALL_MODES), deviation).omega, exact, rtol=1e-8
    )


def test_frequencies_fall_to_the_full_ones_with_every_mode():
    exact = full_frequencies(reference_disk())[:24]
    omega = [reference_reduced(n).tuned_eigenvalues[:24] ** 0.5 for n in (0, 12, 36, 60, 120)]
    for coarse, fine in zip(omega, [*omega[1:], exact], strict=True):
        assert np.all(coarse >= fine * (1 - 1e-9))
    np.testing.assert_allclose(omega[3][:12], exact[:12], rtol=1e-5)


@pytest.mark.parametrize("n_modes", [0, 60])
def test_static_response_to_contact_forces_is_exact(n_modes):
    disk, reduced = reference_disk(), reference_reduced(n_modes)
    forces = np.random.default_rng(0).normal(size=24)
    full_load, reduced_load = np.zeros(240), np.zeros(24 + n_modes)
    full_load[disk.contact_dof.T.ravel()] = reduced_load[:24] = forces
    u = np.linalg.solve(disk.stiffness, full_load)
    q = np.linalg.solve(reduced.stiffness, reduced_load)
    np.testing.assert_allclose(reduced.basis @ q, u, rtol=1e-8, atol=1e-10 * np.abs(u).max())


def test_contact_coordinates_are_physical_and_modes_hold_them():
    disk, reduced = reference_disk(), reference_reduced(60)
    contact = reduced.basis[disk.contact_dof.T.ravel()]
    np.testing.assert_array_equal(contact, np.eye(24, 84))
    np.testing.assert_array_equal(reduced.interface.angle, disk.contact_angle)
    np.testing.assert_array_equal(reduced.interface.radius, disk.contact_radius)


def test_blade_stiffness_is_the_projection_of_what_mistuning_adds():
    disk, reduced = reference_disk(), reference_reduced(60)
    change = mistune(disk, DEVIATION).stiffness - disk.stiffness
    projected = reduced.basis.T @ change @ reduced.basis
    summed = np.tensordot(DEVIATION, reduced.blade_stiffness, axes=1)
    np.testing.assert_allclose(summed, projected, atol=1e-9 * np.abs(projected).max())
    assert reduced.blade_stiffness.shape == (12, 84, 84)


def test_modes_solve_the_mistuned_eigenproblem_and_are_mass_normalised():
    reduced = reference_reduced(60)
    modes = mistuned_modes(reduced, DEVIATION)
    K = reduced.stiffness + np.tensordot(DEVIATION, reduced.blade_stiffness, axes=1)
    Phi, eigenvalues = modes.shapes, modes.omega**2
    np.testing.assert_allclose(Phi.T @ reduced.mass @ Phi, np.eye(84), atol=1e-9)
    np.testing.assert_allclose(Phi.T @ K @ Phi, np.diag(eigenvalues), atol=1e-9 * eigenvalues.max())
    np.testing.assert_allclose(modes.omega, np.sqrt(eigh(K, reduced.mass)[0]), rtol=1e-8)
    np.testing.assert_array_equal(modes.normal, Phi[:12])
    np.testing.assert_array_equal(modes.tangential, Phi[12:24])
    assert np.all(np.diff(modes.omega) >= 0)


def test_rigid_body_modes_have_frequency_zero_not_nan():
    reduced = reference_reduced(60)
    eigenvalues = reduced.tuned_eigenvalues.copy()
    eigenvalues[0] = -1e-6
    omega = mistuned_modes(reduced._replace(tuned_eigenvalues=eigenvalues), np.zeros(12)).omega
    assert omega[0] == 0
    assert np.all(omega[1:] > 0)


@pytest.mark.parametrize("n_blades", [2, 3, 24])
def test_other_numbers_of_blades(n_blades):
    disk = make_disk(n_blades=n_blades, blade={"n_elements": 3})
    reduced = craig_bampton(disk, 10)
    modes = mistuned_modes(reduced, np.linspace(-0.04, 0.04, n_blades))
    assert modes.tangential.shape == (n_blades, 2 * n_blades + whole(10, n_blades))
    full = full_frequencies(disk)[0]
    tuned = mistuned_modes(reduced, np.zeros(n_blades)).omega[0]
    assert tuned == pytest.approx(full, rel=1e-2)
    assert tuned >= full * (1 - 1e-9)


@pytest.mark.parametrize("n_modes", [-1, 217])
def test_impossible_number_of_modes_is_refused(n_modes):
    with pytest.raises(ValueError, match=f"between 0 and 216, got {n_modes}"):
        craig_bampton(reference_disk(), n_modes)


def test_basis_of_the_tuned_disk_is_enough():
    """Against the full mistuned disk, the first family is off by about 2e-5 at 4 %."""
    disk, reduced = reference_disk(), reference_reduced(60)
    for sample in range(5):
        deviation = stiffness_deviation(1, 0, sample, 12, 0.04)
        found = mistuned_modes(reduced, deviation).omega[:12]
        exact = full_frequencies(mistune(disk, deviation))[:12]
        assert 1e-6 < np.abs(found / exact - 1).max() < 4e-5
