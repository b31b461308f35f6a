"""The planar disk as a model file: written, read and reduced again, it is the built-in one."""

import numpy as np
import scipy.sparse as sp

from hpcrub.model.imported import assembly, neutral, reduced
from hpcrub.model.reduction import craig_bampton, mistuned_modes
from hpcrub.results import model_file
from tests.truth.disk import MATERIAL, disk_section

N_MODES = 60


def planar_arrays(disk):
    """Arrays of a model file of a planar Disk: the tips have directions, other dof are generalised.

    disk: Disk. Blades are known by the connected parts of their stiffness.
    """
    n, N = len(disk.mass), len(disk.contact_angle)
    dof = np.column_stack([np.full(n, -1), np.zeros(n, int)])
    for direction in (0, 1):
        dof[disk.contact_dof[:, direction]] = np.column_stack(
            [np.arange(N), np.full(N, direction + 1)]
        )
    blades = np.zeros((n, n))
    for rows, part in zip(disk.blade_dof, disk.blade_stiffness, strict=True):
        blades[np.ix_(rows, rows)] += part
    place = disk.contact_radius * np.array([np.cos(disk.contact_angle), np.sin(disk.contact_angle)])
    arrays = {
        "hpcrub_model": np.array(1),
        "kind": np.array("disk"),
        "frame": np.array("cylindrical"),
        "nodes": np.column_stack([*place, np.zeros(N)]),
        "dof": dof,
        "contact_node": np.arange(N),
        "contact_blade": np.arange(N),
    }
    for name, matrix in (("M", disk.mass), ("K", disk.stiffness), ("K_blade", blades)):
        rows = sp.csr_array(matrix)
        arrays |= {f"{name}/{part}": getattr(rows, part) for part in ("data", "indices", "indptr")}
    return arrays


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
