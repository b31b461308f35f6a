"""Random numbers for the figures; what has been drawn is closed."""

import numpy as np
import pytest
from matplotlib import pyplot as plt


@pytest.fixture
def random():
    return np.random.default_rng(6)


@pytest.fixture(autouse=True)
def _closed():
    yield
    plt.close("all")
