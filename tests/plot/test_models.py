"""Model files in three dimensions, of the small disk of solid elements that the tests mesh."""

import numpy as np
import pytest
from matplotlib import pyplot as plt

import hpcrub
from evidence.truth.hexahedra import sector_arrays
from hpcrub.errors import InputError
from hpcrub.model.imported import assembly, neutral, reduced
from hpcrub.results import model_file


@pytest.fixture(scope="module")
def sector(tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "sector.h5"
    model_file.write(path, sector_arrays())
    return path


@pytest.fixture(scope="module")
def disk(sector):
    return assembly.assemble(neutral.from_arrays(model_file.read(sector)))


def test_contact_nodes_are_drawn_at_their_places(sector, disk):
    axes = hpcrub.plot.model(sector)
    (drawn,) = [np.transpose(line.get_data_3d()) for line in axes.get_lines()]
    np.testing.assert_allclose(drawn, 1e3 * disk.nodes[disk.contact_node])
    assert [text.get_text() for text in axes.texts] == [
        str(blade + 1) for blade in range(disk.n_blades)
    ]


def test_axes_of_ones_own_and_what_cannot_be_drawn(sector, disk, tmp_path):
    axes = plt.figure().add_subplot(projection="3d")
    assert hpcrub.plot.model(sector, ax=axes) is axes
    with pytest.raises(InputError, match="needs axes with projection="):
        hpcrub.plot.model(sector, ax=plt.figure().add_subplot())
    small, _ = reduced.reduce_disk(disk, 4)
    path = tmp_path / "reduced.h5"
    model_file.write(path, neutral.to_arrays(small))
    assert len(hpcrub.plot.model(path).texts) == disk.n_blades
