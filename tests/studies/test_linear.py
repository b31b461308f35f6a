"""A linear study of a disk that stiffens with the speed: its peaks have the shapes of their speed.

`tests.response.test_spinning` holds such peaks against dense matrices of every speed.
"""

from functools import partial

import numpy as np
import pytest

from evidence.truth.hexahedra import disk_arrays
from hpcrub.model.imported import assembly, neutral, reduced
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.linear import linear_peak
from hpcrub.results import model_file
from hpcrub.setup.disks import deviation
from hpcrub.setup.imported import resolved
from tests.program import computed, contents, load

RATIO, TOP = 0.004, 2 * np.pi * 500.0
STUDY = """\
study: linear
disk: {model: spun.h5}
material: {damping_ratio: 0.004}
linear: {n_diameters: [5, 6]}
mistuning: {half_range_percent: [0, 4], samples: 56, seed: 3}
"""


@pytest.fixture(scope="module")
def spun(tmp_path_factory):
    """A model file whose blades stiffen by 40 % up to 500 Hz, and the rest of the disk by 20 %."""
    folder = tmp_path_factory.mktemp("spun")
    disk = assembly.assemble(neutral.from_arrays(disk_arrays()))
    K0, blades = disk.stiffness[0], disk.blade_stiffness
    K1 = (0.2 * K0 + 0.2 * blades) / TOP**2
    small, _ = reduced.reduce_disk(disk._replace(stiffness=(K0, K1, -0.1 / TOP**2 * K1)), 20)
    model_file.write(folder / "spun.h5", neutral.to_arrays(small))
    return folder, small


@pytest.mark.parametrize("speeds", ["", "speeds: {from_hz: 150, to_hz: 160, step_hz: 5}"])
def test_amplifications_are_those_of_the_shapes_at_the_peaks(spun, speeds, monkeypatch):
    """Whatever the speeds say, which a linear study does not use; a disk of the second chunk."""
    folder, small = spun
    found = contents(computed(folder, STUDY + speeds, "--overwrite"))["amplification"]
    np.testing.assert_allclose(found[0], 1.0, atol=1e-9)  # no mistuning
    monkeypatch.chdir(folder)
    config = resolved(load("study.yaml"))
    model = reduced.reduced_model(small, TOP)
    disks = np.zeros(model.interface.n_blades), deviation(config, 1, 55)
    for row, order in enumerate(config.linear.n_diameters):
        tuned, mistuned = (
            linear_peak(at(TOP), RATIO, 1.0, order, model.interface, len(disks[0]), at)[0]
            for at in (partial(mistuned_modes, model, blades) for blades in disks)
        )
        assert found[1, row, 55] == pytest.approx(mistuned / tuned, rel=1e-3)
