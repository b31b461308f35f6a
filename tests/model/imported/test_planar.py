"""The planar disk as a model file: written, read and reduced again, it is the built-in one."""

import numpy as np

from evidence.truth.disk import MATERIAL, disk_section
from evidence.truth.planar import planar_arrays
from hpcrub.model.imported import assembly, neutral, reduced
from hpcrub.model.reduction import craig_bampton, mistuned_modes
from hpcrub.results import model_file

N_MODES = 60


def test_planar_disk_imported_again_has_the_modes_of_the_built_in_one(tmp_path):
    """To rounding: frequencies and, but for their sign, what the contact kernel sees."""
    from hpcrub.model.disk import build_disk

    disk = build_disk(disk_section(), MATERIAL)
    model_file.write(tmp_path / "planar.h5", planar_arrays(disk))
    model = neutral.from_arrays(model_file.read(tmp_path / "planar.h5"))
    small, _ = reduced.reduce_disk(assembly.assemble(model), N_MODES)
    deviation = np.random.default_rng(1).uniform(-0.04, 0.04, len(disk.contact_angle))
    ours = mistuned_modes(craig_bampton(disk, N_MODES), deviation)
    theirs = mistuned_modes(reduced.reduced_model(small, 0.0), deviation)
    assert theirs.axial.shape == (0, len(ours.omega))
    np.testing.assert_allclose(theirs.omega, ours.omega, rtol=1e-9)
    sign = np.sign(np.einsum("ik,ik->k", ours.normal, theirs.normal))
    for name in ("normal", "tangential", "observed"):
        a, b = getattr(ours, name), getattr(theirs, name) * sign
        np.testing.assert_allclose(b, a, atol=1e-6 * np.abs(a).max())
