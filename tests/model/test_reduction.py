"""Craig-Bampton against the full model it came from.

With all fixed-interface modes the reduced coordinates are only another basis: frequencies are
those of the full model, mistuned too. With none, static response to contact forces stays exact.
In between, reduced frequencies lie above the full ones and fall with every mode (Rayleigh-Ritz).

Fixed-interface modes come by whole families: the lowest modes of all may cut a double mode in two;
which half is kept is then a matter of rounding, and a blisk that is turned by a right angle, or
mirrored with its rotation reversed, is another one.
"""

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.linalg import eigh

from evidence.truth.disk import (
    earlier_reduced,
    make_disk,
    mistune,
    reference_disk,
    reference_reduced,
)
from evidence.truth.hexahedra import SMALL, disk_arrays, matrix_of, stored
from hpcrub.model import families
from hpcrub.model.families import whole
from hpcrub.model.imported import assembly, neutral, reduced
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import craig_bampton, mistuned_modes
from hpcrub.response.linear import linear_peak

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
    found = mistuned_modes(reference_reduced(ALL_MODES), deviation).omega
    np.testing.assert_allclose(found, exact, rtol=1e-8)


@pytest.mark.parametrize("n_modes", [0, 60])
def test_static_response_to_contact_forces_is_exact(n_modes):
    disk, reduced = reference_disk(), reference_reduced(n_modes)
    forces = np.random.default_rng(0).normal(size=24)
    full_load, reduced_load = np.zeros(240), np.zeros(24 + n_modes)
    full_load[disk.contact_dof.T.ravel()] = reduced_load[:24] = forces
    u = np.linalg.solve(disk.stiffness, full_load)
    q = np.linalg.solve(reduced.stiffness, reduced_load)
    np.testing.assert_allclose(reduced.basis @ q, u, rtol=1e-8, atol=1e-10 * np.abs(u).max())


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


def test_basis_of_the_tuned_disk_is_enough():
    """Against the full mistuned disk, the first family is off by about 2e-5 at 4 %."""
    disk, reduced = reference_disk(), reference_reduced(60)
    for sample in range(5):
        deviation = stiffness_deviation(1, 0, sample, 12, 0.04)
        found = mistuned_modes(reduced, deviation).omega[:12]
        exact = full_frequencies(mistune(disk, deviation))[:12]
        assert 1e-6 < np.abs(found / exact - 1).max() < 4e-5


N = 8
SHAPE = SMALL._replace(n_sectors=N)
PATTERN = stiffness_deviation(3, 0, 0, N, 0.01)


def seen_from(arrays, axes):
    """The same disk in other axes: axes (3, 3) turns old places into new ones."""
    node, direction = arrays["dof"].T
    T = sp.kron(sp.eye_array(len(node) // 3), axes).tocsr()
    assert (direction == np.tile([1, 2, 3], len(node) // 3)).all()
    fixed = arrays["fixed"]  # all directions of a node
    turned = dict(arrays, nodes=arrays["nodes"] @ axes.T, fixed=fixed)
    for name in ("K", "M", "K_blade"):
        turned |= stored(**{name: T @ matrix_of(arrays, name) @ T.T})
    return turned


def small(arrays, n_modes):
    disk = assembly.assemble(neutral.from_arrays(arrays))
    return reduced.reduced_model(reduced.reduce_disk(disk, n_modes)[0], 0.0)


def numbers(model):
    """Linear peaks of a mistuned disk under two engine orders, and what friction lifts."""
    modes = mistuned_modes(model, PATTERN)
    peaks = [linear_peak(modes, 1e-3, 1.0, n, model.interface, N)[0] for n in (2, 3)]
    face, K = model.interface, model.stiffness
    return np.array([*peaks, (face.normal @ np.linalg.solve(K, face.tangential.T)).trace()])


@pytest.mark.parametrize("n_modes", [3, 12, 21])
def test_a_disk_is_the_same_turned_or_mirrored(n_modes):
    arrays = disk_arrays(SHAPE, lean=0.4)
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    mirror = np.diag([1.0, -1.0, 1.0])
    first = numbers(small(arrays, n_modes))
    turned, image = (seen_from(arrays, axes) for axes in (quarter, mirror))
    image["turns"] = np.array(-1)
    np.testing.assert_allclose(numbers(small(turned, n_modes)), first, rtol=1e-6)
    np.testing.assert_allclose(numbers(small(image, n_modes)), first, rtol=1e-6)


def test_a_planar_disk_of_thick_sections_keeps_whole_families():
    """Of its 36 lowest modes some diameters have more than others: modes of the disk are among."""
    disk = make_disk(ring_thickness=0.03, blade={"thickness": 0.04})
    boundary = disk.contact_dof.T.ravel()
    inside = np.setdiff1d(np.arange(len(disk.mass)), boundary)
    parts = (a[np.ix_(inside, inside)] for a in (disk.stiffness, disk.mass))
    values, modes = eigh(*parts)
    sectors = modes.reshape(12, -1, len(inside))
    assert families.choose(values[:36], sectors[:, :, :36], 3, are_all=True) is None
    kept = craig_bampton(disk, 36).basis[inside, 24:]
    size = (np.abs(np.fft.fft(kept.reshape(12, -1, 36), axis=0)) ** 2).sum(axis=1)
    diameters = np.minimum(np.arange(12), 12 - np.arange(12))[size.argmax(axis=0)]
    assert np.bincount(diameters).tolist() == [3, 6, 6, 6, 6, 6, 3]


def test_modes_that_an_eigensolver_has_mixed_are_told_apart():
    """Three numbers of diameters at one frequency, in any combination."""
    angle = 2 * np.pi * np.arange(6) / 6
    pure = np.stack([np.ones(6), np.cos(2 * angle), np.sin(2 * angle), np.cos(3 * angle)], axis=1)
    pure /= np.linalg.norm(pure, axis=0)
    Q, _ = np.linalg.qr(np.random.default_rng(1).standard_normal((4, 4)))
    cosines = np.stack([np.cos(angle), np.sin(angle)], axis=1) / np.sqrt(3)
    sectors = np.hstack([cosines, pure @ Q])[:, None]  # one point of each sector
    values = np.array([1.0, 1.0, 2.0, 2.0, 2.0, 2.0])
    np.testing.assert_array_equal(families.choose(values, sectors, 1, are_all=True), np.eye(6))
    # with one number of diameters at a lower frequency, too, that one is left out of the three
    before = np.concatenate([np.ones((6, 1, 1)), sectors], axis=2)
    chosen = families.choose(np.append(0.5, values), before, 1, are_all=True)
    assert chosen.shape == (7, 6)
    waves = np.abs(np.fft.fft(before[:, 0] @ chosen, axis=0)) ** 2
    np.testing.assert_allclose(waves.max(axis=0) / waves.sum(axis=0), [1, 0.5, 0.5, 0.5, 0.5, 1])
