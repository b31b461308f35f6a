"""Model files in three dimensions, of the small disk of solid elements that the tests mesh.

Truth: the places of its nodes, the dense eigenvalue problem, and that held nodes do not move.
"""

import numpy as np
import pytest
from matplotlib import pyplot as plt
from scipy.linalg import eigh

import hpcrub
from evidence.truth.hexahedra import sector_arrays
from hpcrub.errors import InputError
from hpcrub.model.imported import assembly, neutral, reduced
from hpcrub.plot import models
from hpcrub.results import model_file


@pytest.fixture(scope="module")
def sector(tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "sector.h5"
    model_file.write(path, sector_arrays())
    return path


@pytest.fixture(scope="module")
def disk(sector):
    return assembly.assemble(neutral.from_arrays(model_file.read(sector)))


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def test_contact_nodes_are_drawn_at_their_places_blade_by_blade(sector, disk):
    axes = hpcrub.plot.model(sector)
    drawn = [np.transpose(line.get_data_3d()) for line in axes.get_lines()][-disk.n_blades :]
    for blade, points in enumerate(drawn):
        mine = disk.contact_node[disk.contact_blade == blade]
        np.testing.assert_allclose(points, 1e3 * disk.nodes[mine])
    assert [text.get_text() for text in axes.texts] == [
        str(blade + 1) for blade in range(disk.n_blades)
    ]


def test_a_shape_is_a_mode_of_the_disk(sector, disk):
    """It satisfies K u = w² M u on the free rows, in the frames of the nodes."""
    K, M = disk.stiffness[0].toarray(), disk.mass.toarray()
    exact = np.sqrt(eigh(K, M, eigvals_only=True)[:5]) / (2 * np.pi)
    frequency, moved = models.shape(disk, 3)
    assert frequency == pytest.approx(exact[2], rel=1e-6)
    assert np.linalg.norm(moved, axis=1).max() == pytest.approx(1.0)
    assert (moved[(disk.row < 0).all(axis=1)] == 0).all()  # held
    theta = np.arctan2(disk.nodes[:, 1], disk.nodes[:, 0])
    outward = np.stack([np.cos(theta), np.sin(theta), 0 * theta], axis=1)
    along = np.stack([-np.sin(theta), np.cos(theta), 0 * theta], axis=1)
    parts = (outward * moved).sum(axis=1), (along * moved).sum(axis=1), moved[:, 2]
    u = np.zeros(len(K))
    for rows, part in zip(disk.row.T, parts, strict=True):
        u[rows[rows >= 0]] = part[rows >= 0]
    force = K @ u
    left = np.abs(force - (2 * np.pi * frequency) ** 2 * (M @ u)).max()
    assert left < 1e-4 * np.abs(force).max()  # of an iterative solution
    assert f"mode 3: {frequency:.5g} Hz" in hpcrub.plot.model(sector, mode=3).get_title()


def test_axes_of_ones_own_and_what_cannot_be_drawn(sector, disk, tmp_path):
    axes = plt.figure().add_subplot(projection="3d")
    assert hpcrub.plot.model(sector, ax=axes) is axes
    with pytest.raises(InputError, match="needs axes with projection="):
        hpcrub.plot.model(sector, ax=plt.figure().add_subplot())
    small, _ = reduced.reduce_disk(disk, 4)
    path = tmp_path / "reduced.h5"
    model_file.write(path, neutral.to_arrays(small))
    assert len(hpcrub.plot.model(path).texts) == disk.n_blades
    with pytest.raises(InputError, match="no shape of mode 2 can be drawn"):
        hpcrub.plot.model(path, mode=2)
