"""Random numbers for the figures; what has been drawn is closed."""

import numpy as np
import pytest
from matplotlib import pyplot as plt


@pytest.fixture
def random():
    yield np.random.default_rng(6)
    plt.close("all")
