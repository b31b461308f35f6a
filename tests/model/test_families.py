"""Fixed-interface modes by whole families: a blisk is the same however it is turned or seen.

The lowest modes of all may cut a double mode in two; which half is kept is then a matter of
rounding, and a blisk that is turned by a right angle, or mirrored with its rotation reversed, is
another one.
"""

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.linalg import eigh

from evidence.truth.disk import make_disk
from evidence.truth.hexahedra import SMALL, disk_arrays
from hpcrub.model import families
from hpcrub.model.imported import assembly, craig_bampton, neutral, reduced
from hpcrub.model.mistuning import stiffness_deviation
from hpcrub.model.reduction import craig_bampton as reduce_planar
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.linear import linear_peak

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
        parts = tuple(arrays[f"{name}/{part}"] for part in ("data", "indices", "indptr"))
        matrix = T @ sp.csr_array(parts, shape=T.shape) @ T.T
        for part in ("data", "indices", "indptr"):
            turned[f"{name}/{part}"] = getattr(matrix.tocsr(), part)
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


@pytest.mark.parametrize("n_modes", [3, 9, 12, 16, 21, 30])
def test_a_disk_is_the_same_turned_or_mirrored(n_modes):
    arrays = disk_arrays(SHAPE, lean=0.4)
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    mirror = np.diag([1.0, -1.0, 1.0])
    first = numbers(small(arrays, n_modes))
    np.testing.assert_allclose(
        numbers(small(seen_from(arrays, quarter), n_modes)), first, rtol=1e-6
    )
    image = seen_from(arrays, mirror) | {"turns": np.array(-1)}
    np.testing.assert_allclose(numbers(small(image, n_modes)), first, rtol=1e-6)


@pytest.mark.parametrize("n_modes", [8, 12, 24, 40])
def test_every_number_of_diameters_has_as_many_modes(n_modes):
    """Of the modes with the tips held, by the harmonics of like rows."""
    disk = assembly.assemble(neutral.from_arrays(disk_arrays(SHAPE)))
    basis, boundary = craig_bampton.basis(disk, n_modes)
    modes = basis[:, len(boundary) :]
    k = modes.shape[1] // N
    assert modes.shape[1] == families.whole(n_modes, N) == k * N
    size = (np.abs(np.fft.fft(modes[craig_bampton.like_rows(disk)], axis=0)) ** 2).sum(axis=1)
    share = size / size.sum(axis=0)
    folded = np.array([share[h] + (share[-h] if 0 < 2 * h < N else 0.0) for h in range(N // 2 + 1)])
    assert (folded.max(axis=0) > 1 - 1e-6).all()
    counts = np.bincount(folded.argmax(axis=0))
    assert counts.tolist() == [k, *[2 * k] * (N // 2 - 1), k]


def test_a_planar_disk_of_thick_sections_keeps_whole_families():
    """Of its 36 lowest modes some diameters have more than others: modes of the disk are among."""
    disk = make_disk(ring_thickness=0.03, blade={"thickness": 0.04})
    boundary = disk.contact_dof.T.ravel()
    inside = np.setdiff1d(np.arange(len(disk.mass)), boundary)
    parts = (a[np.ix_(inside, inside)] for a in (disk.stiffness, disk.mass))
    values, modes = eigh(*parts)
    sectors = modes.reshape(12, -1, len(inside))
    assert families.choose(values[:36], sectors[:, :, :36], 3, are_all=True) is None
    kept = reduce_planar(disk, 36).basis[inside, 24:]
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
