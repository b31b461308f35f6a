"""Nodes with directions of their own, and the rows of Ansys and Nastran: the sector stays the same.

Truth: the matrices of a sector turned here, node by node, by rotations of SciPy.
"""

import gzip
import re
import struct
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.spatial.transform import Rotation

from evidence.truth.hexahedra import SMALL, matrix_of, sector, sector_arrays
from hpcrub.errors import InputError
from hpcrub.model.imported import neutral
from hpcrub.model.imported.frames import to_cylindrical
from hpcrub.model.imported.readers import ansys, nastran
from hpcrub.model.imported.readers.nodal import cylindrical
from hpcrub.model.imported.readers.rows import Lists, Mesh, Rows, arrays_of
from tests.model.imported.readers.test_readers import first_family, same_model

ARRAYS, MESH = sector_arrays(), sector(SMALL)
NODES = ARRAYS["nodes"]
NUMBER = np.arange(1, 1 + len(NODES))
LISTS = Lists("TIP", "LOW", "HIGH", SMALL.n_sectors, "BORE")


def in_own(name, axes):
    """A matrix of the sector in the nodes' own directions, {node from 0: (3, 3), rows}."""
    blocks = [axes.get(node, np.eye(3)) for node in range(len(NODES))]
    T = sp.block_diag(blocks, format="csr")  # own from global
    return sp.csr_array(T @ matrix_of(ARRAYS, name) @ T.T)


def parts(axes, held=()):
    """Stiffness, mass and the blade's stiffness by number, without the rows `held`."""
    dof = np.column_stack([NUMBER[ARRAYS["dof"][:, 0]], ARRAYS["dof"][:, 1]])
    kept = np.setdiff1d(np.arange(len(dof)), held)
    return [Rows(in_own(name, axes), dof, name).of(kept) for name in ("K", "M", "K_blade")]


def mesh_of(axes):
    sets = {name.upper(): NUMBER[nodes] for name, nodes in MESH.sets.items()}
    own = {int(NUMBER[node]): R for node, R in axes.items()}
    return Mesh(NUMBER, NODES, lambda name: sets[name], [], own)


def turned_nodes(nodes, seed=1):
    """Random directions of some nodes."""
    rotations = Rotation.random(len(nodes), rng=np.random.default_rng(seed))
    return dict(zip(nodes.tolist(), rotations.as_matrix(), strict=True))


def test_any_directions_of_any_nodes(exact):
    axes = turned_nodes(np.arange(0, len(NODES), 2))
    K, M, K_blade = parts(axes)
    same_model(arrays_of(mesh_of(axes), LISTS, {0.0: K}, M, K_blade), exact)


def first_frequencies(arrays):
    return first_family(neutral.from_arrays(arrays | {"units": np.array("m kg s")}))


def test_huge_entries_hold_turned_nodes_too(exact):
    axes = turned_nodes(MESH.sets["bore"])
    K, M, K_blade = parts(axes)
    held = np.isin(K.dof[:, 0], NUMBER[MESH.sets["bore"]])
    K.matrix.setdiag(np.where(held, 1e36, K.matrix.diagonal()))
    found = arrays_of(mesh_of(axes), LISTS._replace(fixed=None), {0.0: K}, M, K_blade)
    np.testing.assert_allclose(first_frequencies(found), first_family(exact), rtol=1e-9)


@pytest.mark.parametrize("huge", [False, True])
def test_a_bore_that_is_held_tangentially_and_axially(exact, huge):
    """As Ansys writes it, without the rows, or Abaqus, by 1e36; truth: rows of a turned sector."""
    bore = MESH.sets["bore"]
    axes = {int(node): cylindrical(NODES[node]) for node in bore}
    held = np.concatenate([3 * bore + 1, 3 * bore + 2])
    K, M, K_blade = parts(axes, () if huge else held)
    if huge:
        K.matrix.setdiag(np.where(np.isin(np.arange(len(K.dof)), held), 1e36, K.matrix.diagonal()))
    found = arrays_of(mesh_of(axes), LISTS._replace(fixed=None), {0.0: K}, M, K_blade)
    assert str(found["frame"]) == "cylindrical"
    truth = neutral.to_arrays(to_cylindrical(exact)) | {"fixed": np.sort(held)}
    np.testing.assert_allclose(first_frequencies(found), first_frequencies(truth), rtol=1e-9)


def test_a_direction_that_no_frame_has_is_refused():
    axes = turned_nodes(MESH.sets["bore"])
    K, M, _ = parts(axes, 3 * MESH.sets["bore"])
    with pytest.raises(InputError, match=r"K: node \d+ is held in a direction of its own; such"):
        arrays_of(mesh_of(axes), LISTS, {0.0: K}, M)


def archive(angles):
    """A .cdb with the nodes, three angles of each [degrees], and components."""
    text = f"/PREP7\nNBLOCK,6,SOLID,{len(NODES):9d},{len(NODES):9d}\n(3i9,6e21.13e3)\n"
    for number, place, own in zip(NUMBER, NODES, angles, strict=True):
        text += f"{number:9d}{0:9d}{0:9d}" + "".join(f"{x:21.13e}" for x in (*place, *own)) + "\n"
    text += "N,R5.3,LOC,       -1,\n"
    for name, nodes in MESH.sets.items():
        text += f"CMBLOCK,{name.upper():8s},NODE,{len(nodes):8d}\n(8i10)\n"
        lines = [NUMBER[nodes][k : k + 8] for k in range(0, len(nodes), 8)]
        text += "".join("".join(f"{n:10d}" for n in line) + "\n" for line in lines)
    return text + "FINISH\n"


@pytest.fixture
def ansys_job(folder, monkeypatch):
    """Files of a sector whose nodes have three angles each; .full files as they are read."""
    pytest.importorskip("ansys.mapdl.reader")
    angles = np.random.default_rng(4).uniform(-180, 180, (len(NODES), 3))
    angles[::3] = 0.0
    (folder / "disk.cdb").write_text(archive(angles))
    own = Rotation.from_euler("ZXY", angles, degrees=True).as_matrix()
    axes = {k: own[k].T for k in range(len(NODES))}
    K, M, K_blade = parts(axes)
    names = {"disk.full": (K, M), "blade.full": (K_blade, None)}
    monkeypatch.setattr(ansys, "full_matrices", names.__getitem__)
    return axes


def test_angles_of_ansys(ansys_job, exact):
    same_model(ansys.read("disk.full", "disk.cdb", LISTS, "blade.full"), exact)


def test_a_full_file_without_mass_is_good_for_a_blade_alone(ansys_job):
    with pytest.raises(InputError, match=r"blade\.full: there is no mass in it; write it in a mod"):
        ansys.read("blade.full", "disk.cdb", LISTS)


def test_rows_of_a_full_file_that_are_held_are_not_there():
    """The package leaves them with zeros only, of which no mode can be found."""
    pytest.importorskip("ansys.mapdl.reader")
    from ansys.mapdl.reader import examples

    K, M = ansys.full_matrices(examples.fullfile)
    assert (K.dof == M.dof).all()
    assert K.matrix.diagonal().min() > 0.0


SYSTEMS = """\
CORD2C,7,,0.,0.,0.,0.,0.,1.
,1.,0.,0.
CORD2S,8,,0.01,0.,0.02,0.,1.,0.
,1.,0.,3.
CORD2R,9,,1.,2.,3.,1.,3.,5.
,7.,1.,1.
"""


def spherical(place):
    """Directions of system 8 at a place: along r, theta (from its z) and phi, by differences."""
    z = np.array([0.0, 1.0, 0.0]) - [0.01, 0.0, 0.02]
    z /= np.linalg.norm(z)
    y = np.cross(z, np.array([1.0, 0.0, 3.0]) - [0.01, 0.0, 0.02])
    y /= np.linalg.norm(y)
    base = np.array([np.cross(y, z), y, z])
    x = base @ (place - [0.01, 0.0, 0.02])
    theta, phi, r = np.arctan2(np.hypot(x[0], x[1]), x[2]), np.arctan2(x[1], x[0]), 1.0

    def at(r, t, p):
        return r * np.array([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)])

    h = 1e-6
    steps = [at(r + h, theta, phi), at(r, theta + h, phi), at(r, theta, phi + h)]
    rows = [(step - at(r, theta, phi)) / h for step in steps]
    return np.array([row / np.linalg.norm(row) for row in rows]) @ base


def rectangular():
    z = np.array([0.0, 1.0, 2.0]) / np.sqrt(5.0)
    y = np.cross(z, [6.0, -1.0, -2.0])
    y /= np.linalg.norm(y)
    return np.array([np.cross(y, z), y, z])


@pytest.fixture
def nastran_job(folder):
    """Bulk data whose grid points have directions of systems 0, 7, 8 and 9; functions to write."""
    pytest.importorskip("pyNastran")
    axes, cards = {}, ["SOL 103", "CEND", "BEGIN BULK", *SYSTEMS.splitlines(), "SPOINT,900,901"]
    for node, place in enumerate(NODES):
        system = (0, 7, 8, 9)[node % 4]
        x, y, z = place.tolist()
        cards.append(f"GRID*,{NUMBER[node]},,{x:.12f},{y:.12f},*\n*,{z:.12f},{system}")
        if system:
            axes[node] = {7: cylindrical, 8: spherical, 9: lambda _: rectangular()}[system](place)
    Path("mesh.bdf").write_text("\n".join([*cards, "ENDDATA", ""]))
    for name, nodes in MESH.sets.items():
        np.savetxt(f"{name.upper()}", NUMBER[nodes], "%d", header=f"{name} nodes", comments="")
    return axes


def of_grid(matrix, n_scalars=2):
    """Six rows of each grid point, and one of each scalar point."""
    rows = 6 * ARRAYS["dof"][:, 0] + ARRAYS["dof"][:, 1] - 1
    n = 6 * len(NODES) + n_scalars
    entries = sp.coo_array(matrix)
    padded = sp.coo_array((entries.data, (rows[entries.row], rows[entries.col])), shape=(n, n))
    return padded.tolil()


def binary_op4(path, matrices):
    """Columns from their first to their last entry, each in a record of Fortran."""

    def record(*parts):
        data = b"".join(parts)
        return struct.pack("<i", len(data)) + data + struct.pack("<i", len(data))

    with path.open("wb") as file:
        for name, matrix in matrices.items():
            n = len(matrix)
            file.write(record(struct.pack("<4i8s", n, n, 6, 2, name.ljust(8).encode())))
            for column, values in enumerate(matrix.T, 1):
                if len(rows := np.flatnonzero(values)):
                    own = values[rows[0] : rows[-1] + 1]
                    file.write(record(struct.pack("<3i", column, rows[0] + 1, 2 * len(own)),
                                      own.astype("<f8").tobytes()))  # fmt: skip
            file.write(record(struct.pack("<3id", n + 1, 1, 2, 1.0)))


def write_op4(axes, how):
    from pyNastran.op4.op4 import OP4

    for file, names in (("disk", {"KGG": "K", "MGG": "M"}), ("blade", {"KGG": "K_blade"})):
        path, matrices = Path(f"{file}.op4"), {}
        for key, name in names.items():
            matrix = of_grid(in_own(name, axes))
            if name != "K_blade":  # a scalar point that hangs on nothing
                matrix[-2, -2] = {"K": 1e7, "M": 1.0}[name]
            matrices[key] = matrix.toarray()
        if "binary" in how:
            binary_op4(path, matrices)
            continue
        kind = sp.coo_matrix if "sparse" in how else np.array
        written = {key: (6, kind(matrix)) for key, matrix in matrices.items()}
        OP4(debug=None).write_op4(str(path), written, is_binary=False)
        data = path.read_bytes()
        if "exponents D" in how:
            data = re.sub(rb"(\d)E([+-]\d)", rb"\1D\2", data).replace(b"1P,3E23.16", b"3D23.16")
            path.write_bytes(data)
        if "packed" in how:
            path.unlink()
            Path(f"{file}.op4.gz").write_bytes(gzip.compress(data))


HOW = "text, packed", "binary", "text, sparse, exponents D"


@pytest.mark.parametrize("how", HOW)
def test_coordinate_systems_and_scalar_points_of_nastran(nastran_job, exact, how):
    write_op4(nastran_job, how)
    arrays = nastran.read("disk.op4", "mesh.bdf", LISTS, "blade.op4")
    assert (arrays["dof"][:, 1] == 0).sum() == 1  # the scalar point
    model = neutral.from_arrays(arrays | {"units": np.array("m kg s")})
    rows = np.flatnonzero(model.dof[:, 1] > 0)
    order = rows[np.lexsort(model.dof[rows].T[::-1])]
    assert (model.dof[order] == exact.dof).all()
    for a, b in ((model.mass, exact.mass), (model.stiffness[0], exact.stiffness[0]),
                 (model.blade_stiffness, exact.blade_stiffness)):  # fmt: skip
        assert abs(a[order][:, order] - b).max() < 1e-6 * abs(b).max()
    assert set(model.dof[model.fixed, 0]) == set(exact.dof[exact.fixed, 0])


def test_matrices_of_other_points_are_refused_with_what_is_expected(nastran_job):
    write_op4(nastran_job, "text")
    text = Path("mesh.bdf").read_text()
    Path("mesh.bdf").write_text(text.replace("SPOINT,900,901\n", ""))
    n = 6 * len(NODES)
    with pytest.raises(InputError, match=rf"KGG has {n + 2} rows; {n} rows are expected, 6 for"):
        nastran.read("disk.op4", "mesh.bdf", LISTS)
