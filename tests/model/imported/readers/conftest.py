"""The sector that every file of another program stands for."""

import pytest

from evidence.truth.hexahedra import sector_arrays
from hpcrub.model.imported import neutral


@pytest.fixture(scope="session")
def exact():
    """Its model."""
    return neutral.from_arrays(sector_arrays())
