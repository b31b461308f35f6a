"""A linear study of a disk that stiffens with the speed, against dense matrices of every speed."""

import numpy as np
import pytest
from scipy.linalg import eigh

from evidence.truth.hexahedra import disk_arrays
from hpcrub.model.imported import assembly, neutral, reduced
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
mistuning: {half_range_percent: [4], samples: 1, seed: 3}
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


def peak(small, blades, order):
    """Largest tangential amplitude of a tip per newton, of the matrices of every speed."""
    face = reduced.interface(small)
    force = face.share * np.exp(-1j * order * face.angle) @ face.normal
    K_blades = np.tensordot(blades, small.blade_stiffness, axes=1)

    def modes(hz):
        W = 2 * np.pi * hz
        K = sum(k * W ** (2 * p) for p, k in enumerate(small.stiffness)) + K_blades
        return eigh(K, small.mass)

    def size(hz):
        squared, shapes = modes(hz)
        w, omega = order * 2 * np.pi * hz, np.sqrt(squared)
        answer = (force @ shapes) / (squared - w * w + 2j * RATIO * omega * w)
        return np.abs(face.observed @ shapes @ answer).max()

    ends = np.array([500.0, 500.0])  # where the lowest and highest mode of the family are met
    for _ in range(40):
        squared = [modes(hz)[0][k] for hz, k in zip(ends, (0, len(blades) - 1), strict=True)]
        ends = np.sqrt(squared) / (2 * np.pi * order)
    at = np.linspace(0.97 * ends[0], 1.03 * ends[1], 201)
    for _ in range(2):
        sizes = [size(hz) for hz in at]
        near = at[np.argmax(sizes)]
        at = np.linspace(near - (at[1] - at[0]), near + (at[1] - at[0]), 21)
    return max(sizes)


@pytest.mark.parametrize("speeds", ["", "speeds: {from_hz: 150, to_hz: 160, step_hz: 5}"])
def test_amplifications_are_those_of_the_matrices_of_every_speed(spun, speeds, monkeypatch):
    """Whatever the speeds say, which a linear study does not use."""
    folder, small = spun
    found = contents(computed(folder, STUDY + speeds, "--overwrite"))["amplification"][0]
    monkeypatch.chdir(folder)
    config = resolved(load("study.yaml"))
    for row, order in enumerate(config.linear.n_diameters):
        tuned = peak(small, np.zeros(len(small.blade_stiffness)), order)
        expected = peak(small, deviation(config, 0, 0), order) / tuned
        assert found[row, 0] == pytest.approx(expected, rel=1e-3)
