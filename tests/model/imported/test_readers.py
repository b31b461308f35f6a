"""Readers: a small sector written in the formats of other programs is the sector."""

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp

from evidence.truth.hexahedra import DENSITY, POISSON, SMALL, YOUNG, sector, sector_arrays
from hpcrub.__main__ import main as program
from hpcrub.errors import InputError
from hpcrub.model.imported import checks, cyclic, neutral
from hpcrub.model.imported.readers import calculix, deck, matrix_market, rows
from hpcrub.model.imported.readers.rows import Lists
from hpcrub.results import model_file

LISTS = Lists("TIP", "LOW", "HIGH", SMALL.n_sectors, "BORE")


@pytest.fixture(scope="module")
def exact():
    return neutral.from_arrays(sector_arrays())


def same_model(arrays, exact, units="m kg s"):
    model = neutral.from_arrays(arrays | {"units": np.array(units)})
    checks.check(model)
    order = np.lexsort(model.dof.T[::-1])  # rows by node and direction
    assert (model.dof[order] == exact.dof).all()
    for a, b in (
        (model.mass, exact.mass),
        (model.stiffness[0], exact.stiffness[0]),
        (model.blade_stiffness, exact.blade_stiffness),
    ):
        assert abs(a[order][:, order] - b).max() < 1e-9 * abs(b).max()
    np.testing.assert_allclose(model.nodes, exact.nodes, atol=1e-9)
    for name in ("contact_node", "low", "high"):
        assert set(getattr(model, name)) == set(getattr(exact, name))
    f = (cyclic.sector_frequencies(m, 2, 3) for m in (model, exact))
    np.testing.assert_allclose(next(f), next(f), rtol=1e-8)
    return model


def matrix_of(arrays, name):
    parts = (arrays[f"{name}/{part}"] for part in ("data", "indices", "indptr"))
    n = len(arrays["dof"])
    return sp.csr_array(tuple(parts), shape=(n, n))


def write_calculix(folder, name, matrices, dof, elements, mesh):
    """Files as ccx writes them: one triangle, rows counted from 1, `node.direction` by line."""
    for ending, matrix in matrices.items():
        lower = sp.coo_array(sp.tril(matrix))
        lines = zip(lower.row + 1, lower.col + 1, lower.data, strict=True)
        (folder / f"{name}.{ending}").write_text(
            "".join(f"{i} {j} {value:.17e}\n" for i, j, value in lines)
        )
    (folder / f"{name}.dof").write_text("".join(f"{n + 1}.{d}\n" for n, d in dof))
    places = enumerate(mesh.nodes.tolist(), 1)
    nodes = "".join(f"{n}, {x:.15g}, {y:.15g}, {z:.15g}\n" for n, (x, y, z) in places)
    text = f"** a comment\n*NODE, NSET=NALL\n{nodes}*ELEMENT, TYPE=C3D8, ELSET=EALL\n"
    for e in elements:
        first, second = mesh.elements[e, :5] + 1, mesh.elements[e, 5:] + 1
        text += f"{e + 1}, {', '.join(map(str, first))},\n {', '.join(map(str, second))}\n"
    for key in ("low", "tip", "bore"):
        text += f"*NSET, NSET={key}\n{', '.join(map(str, mesh.sets[key] + 1))}\n"
    high = np.sort(mesh.sets["high"]) + 1
    text += "*NSET, NSET=HIGH, GENERATE\n" + "".join(f"{n}, {n}\n" for n in high)
    (folder / f"{name}.inp").write_text(text)


def test_calculix(tmp_path, exact):
    """Rows in another order than the nodes, the blade's matrix on its own rows, mm and t."""
    mesh, arrays = sector(SMALL), sector_arrays()
    order = np.random.default_rng(3).permutation(len(arrays["dof"]))
    K, M, K_blade = (matrix_of(arrays, name) for name in ("K", "M", "K_blade"))
    scaled = {"sti": K[order][:, order] / 1e3, "mas": M[order][:, order] / 1e3}  # N/mm, t
    everything = range(len(mesh.elements))
    write_calculix(tmp_path, "disk", scaled, arrays["dof"][order], everything, mesh)
    own = np.flatnonzero(abs(K_blade).sum(axis=0))
    part = {"sti": K_blade[own][:, own] / 1e3, "mas": M[own][:, own]}
    write_calculix(tmp_path, "blade", part, arrays["dof"][own], mesh.blade_elements, mesh)
    read = calculix.read(tmp_path / "disk.inp", LISTS, tmp_path / "blade.inp")
    model = same_model(read, exact, "mm t s")
    assert len(model.fixed) == len(exact.fixed)
    hidden = {tuple(sorted(face)) for face in model.surface.tolist()}
    assert len(hidden) == len(model.surface) == len(rows.skin(list(mesh.elements)))


def write_matrix_market(folder, number):
    """The sector as MatrixMarket files with CSV lists; number: of every node."""
    arrays, mesh = sector_arrays(), sector(SMALL)
    for name in ("K", "M", "K_blade"):
        scipy.io.mmwrite(
            folder / f"{name}.mtx", matrix_of(arrays, name), symmetry="symmetric", precision=17
        )
    np.savetxt(folder / "nodes.csv", np.column_stack([number, arrays["nodes"]]), delimiter=",")
    rows = np.column_stack([number[arrays["dof"][:, 0]], arrays["dof"][:, 1]])
    np.savetxt(folder / "dof.csv", rows, "%d", ",", header="node,direction", comments="")
    for name, nodes in (("low", "low"), ("high", "high"), ("contact", "tip"), ("fixed", "bore")):
        np.savetxt(folder / f"{name}.csv", number[mesh.sets[nodes]], "%d")


def test_matrix_market(tmp_path, exact):
    """Symmetric MatrixMarket files, node numbers that are not in order, headed CSV lists."""
    number = 7 + 3 * np.arange(len(exact.nodes))[::-1]
    write_matrix_market(tmp_path, number)
    read = matrix_market.read(tmp_path, SMALL.n_sectors)
    read["nodes"] = read["nodes"][::-1]  # numbers fall here where those of the truth rise
    for name in ("contact_node", "low", "high"):
        read[name] = len(number) - 1 - read[name]
    read["dof"][:, 0] = len(number) - 1 - read["dof"][:, 0]
    assert set(neutral.from_arrays(read).fixed) == set(exact.fixed)
    same_model(read, exact)


def test_nastran(tmp_path, exact):
    """Six rows for every grid point, of which solid elements leave three without stiffness."""
    pytest.importorskip("pyNastran")
    from pyNastran.op4.op4 import OP4

    from hpcrub.model.imported.readers import nastran

    arrays, mesh = sector_arrays(), sector(SMALL)
    n = len(mesh.nodes)
    node, direction = arrays["dof"].T
    rows = 6 * node + direction - 1

    def padded(name):
        entries = sp.coo_array(matrix_of(arrays, name))
        place = (rows[entries.row], rows[entries.col])
        return sp.coo_array((entries.data, place), shape=(6 * n, 6 * n)).toarray()

    for file, names in (("disk", {"KGG": "K", "MGG": "M"}), ("blade", {"KGG": "K_blade"})):
        matrices = {key: (6, padded(name)) for key, name in names.items()}
        OP4(debug=None).write_op4(str(tmp_path / f"{file}.op4"), matrices, is_binary=False)
    cards = ["BEGIN BULK"]
    cards += [f"GRID,{k},,{x:.9f},{y:.9f},{z:.9f}" for k, (x, y, z) in enumerate(exact.nodes, 1)]
    cards += [f"MAT1,1,{YOUNG:.5g},,{POISSON},{DENSITY}", "PSOLID,1,1", "ENDDATA"]
    (tmp_path / "mesh.bdf").write_text("\n".join(["SOL 103", "CEND", *cards]))
    for name, nodes in mesh.sets.items():
        np.savetxt(tmp_path / f"{name}.csv", nodes + 1, "%d")
    lists = Lists(*(str(tmp_path / f"{k}.csv") for k in ("tip", "low", "high")), SMALL.n_sectors,
                  str(tmp_path / "bore.csv"))  # fmt: skip
    read = nastran.read(tmp_path / "disk.op4", tmp_path / "mesh.bdf", lists, tmp_path / "blade.op4")
    same_model(read, exact)


def test_ansys():
    """The beam that comes with the reader: its rows feel no rigid motion but at its supports."""
    pytest.importorskip("ansys.mapdl.reader")
    from ansys.mapdl.reader import examples

    from hpcrub.model.imported.readers import ansys

    read = ansys.read(examples.fullfile, examples.hexarchivefile, Lists("NCOMP2"))
    model = neutral.from_arrays(read | {"contact_blade": np.zeros(98, int)})
    share = checks.unbalanced(model.stiffness[0], checks.rigid_motions(model))
    held = (share > 1e-6).reshape(-1)
    assert 0 < held.sum() < 0.2 * len(held)
    assert np.ptp(model.nodes[model.dof[held, 0], 2]) < np.ptp(model.nodes[:, 2])
    assert len(model.surface) == 4 * (2 * 10) + 2 * (2 * 2)  # of 2 x 2 x 10 elements


def test_sets_of_decks(tmp_path):
    """Included files, sets of sets, numbers generated."""
    (tmp_path / "more.inp").write_text("*NSET, NSET=A, GENERATE\n1, 5, 2\n")
    (tmp_path / "d.inp").write_text(
        "*HEADING\nwords\n*NODE\n1,0,0,0\n3,1,0,0\n5,1,1\n*INCLUDE, INPUT=more.inp\n"
        "*Nset, nset=b\nA, 5\n"
    )
    found = deck.read(tmp_path / "d.inp")
    assert found.node.tolist() == [1, 3, 5]
    assert found.sets["A"].tolist() == found.sets["B"].tolist() == [1, 3, 5]
    with pytest.raises(InputError, match="there is no node set tips; there are A, B"):
        deck.node_set(found, "tips", "d.inp")


def test_skin_of_two_hexahedra_hides_the_face_between_them():
    cube = [0, 1, 2, 3, 4, 5, 6, 7]
    above = [4, 5, 6, 7, 8, 9, 10, 11]
    assert len(rows.skin([cube])) == 6
    faces = {tuple(sorted(face)) for face in rows.skin([cube, above]).tolist()}
    assert len(faces) == 10
    assert (4, 5, 6, 7) not in faces


def test_import_command_reduces_and_says_what_it_found(tmp_path, capsys):
    source, small = str(tmp_path / "sector.h5"), str(tmp_path / "small.h5")
    model_file.write(source, sector_arrays())
    assert program(["import", "model", source, "--reduce", "10", "--output", small]) == 0
    said = capsys.readouterr().out
    for words in ("5 blades", "mass: 4.958", "pairs miss by at most", "highest frequency"):
        assert words in said
    assert program(["import", "model", small]) == 0
    assert "reduced: 40 dof" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["model", "none.h5"], "none.h5"),
        (["calculix", "none.inp", "--contact", "TIP", "--units", "mm t s"], "none.inp: cannot be"),
        (["calculix", "none.inp", "--contact", "TIP", "--low", "A"], "a sector needs all three"),
        (["matrixmarket", ".", "--units", "m kg s"], "nodes.csv"),
    ],
)
def test_import_command_stops_with_one_sentence(folder, capsys, arguments, words):
    assert program(["import", *arguments]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1


def command(*arguments):
    return program(["import", *map(str, arguments)])


def mirrored(arrays):
    """The mirror image of a sector: y is -y, of places and of directions."""
    sign = np.where(arrays["dof"][:, 1] == 2, -1.0, 1.0)
    turned = dict(arrays, nodes=arrays["nodes"] * [1.0, -1.0, 1.0])
    for name in ("K", "M", "K_blade"):
        turned |= dict_of(
            name, sp.diags_array(sign) @ matrix_of(arrays, name) @ sp.diags_array(sign)
        )
    return turned


def dict_of(name, matrix):
    matrix = sp.csr_array(matrix)
    return {f"{name}/{part}": getattr(matrix, part) for part in ("data", "indices", "indptr")}


def test_the_other_sense_of_rotation_is_that_of_the_mirror_image():
    """Friction lifts the tips of one as it lowers those of the other; turns: -1 gives it back."""
    exact, arrays = neutral.from_arrays(sector_arrays(lean=0.6)), mirrored(sector_arrays(lean=0.6))
    image = neutral.from_arrays(arrays)
    back = neutral.from_arrays(arrays | {"turns": np.array(-1)})
    lift = cyclic.friction_lift(exact)
    assert lift > 0.1  # the tips lie ahead, and rise when they are held back
    assert cyclic.friction_lift(image) == pytest.approx(-lift, rel=1e-9)
    assert cyclic.friction_lift(back) == pytest.approx(lift, rel=1e-9)
    np.testing.assert_allclose(back.nodes, exact.nodes * [1.0, 1.0, -1.0], atol=1e-12)
    f = (cyclic.sector_frequencies(m, 2, 3) for m in (back, exact))
    np.testing.assert_allclose(next(f), next(f), rtol=1e-9)
    with pytest.raises(InputError, match="turns: 2 is neither 1 nor -1"):
        neutral.from_arrays(arrays | {"turns": np.array(2)})


def test_import_says_which_way_the_disk_turns(tmp_path, capsys):
    """Written once turned, the file is of a disk that turns counter-clockwise."""
    model_file.write(tmp_path / "m.h5", sector_arrays(lean=0.6))
    said = []
    for file, options in (("m.h5", ()), ("m.h5", ("--turns", "-1", "--output", tmp_path / "n.h5")),
                          ("n.h5", ())):  # fmt: skip
        assert command("model", tmp_path / file, *options) == 0
        said.append(capsys.readouterr().out)
    assert ["warning: so friction presses" in text for text in said].count(True) == 1
    assert "rotation: counter-clockwise, seen from +z\n" in said[0]
    assert "whose axes are x, -y, -z here" in said[1]
    lines = [[x for x in text.splitlines() if x.startswith("friction on")] for text in said]
    assert lines[0] != lines[1] == lines[2]
