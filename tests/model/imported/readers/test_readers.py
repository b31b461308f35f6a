"""Readers: a small sector written in the formats of other programs is the sector."""

import re

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp
from scipy.linalg import eigh

from evidence import calculix as ccx
from evidence.truth.hexahedra import (
    SMALL,
    matrix_of,
    sector,
    sector_arrays,
    stresses,
)
from hpcrub.__main__ import main as program
from hpcrub.errors import InputError
from hpcrub.model.imported import assembly, checks, craig_bampton, cyclic, neutral, reduced
from hpcrub.model.imported.frames import to_cartesian, to_cylindrical
from hpcrub.model.imported.readers import calculix, deck, matrix_market, rows
from hpcrub.model.imported.readers.rows import Lists
from hpcrub.results import model_file
from tests.model.test_reduction import seen_from

LISTS = Lists("TIP", "LOW", "HIGH", SMALL.n_sectors, "BORE")


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


def first_family(model):
    """First natural frequencies by the number of diameters, at rest [Hz]."""
    return cyclic.frequencies_by_diameter(model, 0.0)[:, 0]


def write_calculix(folder, name, matrices, dof, mesh, blade=False):
    """Files as ccx writes them: one triangle, rows counted from 1, `node.direction` by line."""
    for ending, matrix in matrices.items():
        lower = sp.coo_array(sp.tril(matrix))
        lines = zip(lower.row + 1, lower.col + 1, lower.data, strict=True)
        text = "".join(f"{i} {j} {value:.17e}\n" for i, j, value in lines)
        (folder / f"{name}.{ending}").write_text(text)
    (folder / f"{name}.dof").write_text("".join(f"{n + 1}.{d}\n" for n, d in dof))
    ccx.write(folder / f"{name}.inp", mesh, "** no steps", blade)


def test_calculix(tmp_path, exact):
    """Rows in another order than the nodes, the blade's matrix on its own rows, mm and t."""
    mesh, arrays = sector(SMALL), sector_arrays()
    order = np.random.default_rng(3).permutation(len(arrays["dof"]))
    K, M, K_blade = (matrix_of(arrays, name) for name in ("K", "M", "K_blade"))
    scaled = {"sti": K[order][:, order] / 1e3, "mas": M[order][:, order] / 1e3}  # N/mm, t
    write_calculix(tmp_path, "disk", scaled, arrays["dof"][order], mesh)
    own = np.flatnonzero(abs(K_blade).sum(axis=0))
    part = {"sti": K_blade[own][:, own] / 1e3, "mas": M[own][:, own]}
    write_calculix(tmp_path, "blade", part, arrays["dof"][own], mesh, blade=True)
    read = calculix.read(tmp_path / "disk.inp", LISTS, tmp_path / "blade.inp")
    model = same_model(read, exact, "mm t s")
    assert len(model.fixed) == len(exact.fixed)
    names = (tmp_path / "disk.dof").read_text().splitlines()
    (tmp_path / "disk.dof").write_text("\n".join(names[:50]))  # it was "index exceeds dimension"
    with pytest.raises(
        InputError, match=r"disk\.mas: has a row \d+, but .*disk\.dof names 50 rows"
    ):
        calculix.read(tmp_path / "disk.inp", LISTS)
    hidden = {tuple(sorted(face)) for face in model.surface.tolist()}
    assert len(hidden) == len(model.surface) == len(rows.skin(list(mesh.elements)))


def write_modes(path, moved, elements, stress):
    """Displacements and stresses of modes as ccx prints them, seven digits of each."""
    text = " E I G E N V A L U E   O U T P U T\n\n      1   0.1E+08   0.3E+04   0.5E+03   0.0E+00\n"
    for u, s in zip(moved, stress, strict=True):
        text += "\n displacements (vx,vy,vz) for set NALL and time  0.1000000E+01\n\n"
        text += "".join(f"{n:10d}" + "".join(f"{x:14.6E}" for x in row) + "\n"
                        for n, row in enumerate(u, 1))  # fmt: skip
        text += "\n stresses (elem, integ.pnt.,sxx,syy,szz,sxy,sxz,syz) for set ROOT\n\n"
        for e, of_points in zip(elements, s, strict=True):
            text += "".join(f"{e + 1:10d}{p:4d}" + "".join(f"{x:14.6E}" for x in row) + "\n"
                            for p, row in enumerate(of_points, 1))  # fmt: skip
    path.write_text(text)


@pytest.fixture(scope="module")
def job(tmp_path_factory):
    """A folder with CalculiX's job of the sector, in mm and t, and modes that it printed."""
    folder = tmp_path_factory.mktemp("job")
    mesh, arrays = sector(SMALL), sector_arrays()
    K, M = (matrix_of(arrays, name) for name in ("K", "M"))
    matrices = {"sti": K / 1e3, "mas": M / 1e3}
    write_calculix(folder, "disk", matrices, arrays["dof"], mesh)
    free = np.setdiff1d(np.arange(len(arrays["dof"])), arrays["fixed"])
    _, vectors = eigh(K[free][:, free].toarray(), M[free][:, free].toarray())
    moved = np.zeros((80, len(arrays["dof"])))
    moved[:, free] = vectors[:, :80].T
    moved = moved.reshape(80, -1, 3)
    stress = 1e-6 * stresses(arrays["nodes"], mesh.elements[mesh.blade_elements], 1e-3 * moved)
    write_modes(folder / "modes.dat", moved, mesh.blade_elements, stress)
    return folder


def read_stress(job, *options):
    command = "import", "calculix", str(job / "disk.inp"), "--units", "mm t s", "--contact", "TIP"
    sides = ("--low", "LOW", "--high", "HIGH", "--sectors", str(SMALL.n_sectors))
    return program([*command, *sides, "--fixed", "BORE", *options])


def test_rows_of_stress_of_printed_modes(job, tmp_path, capsys):
    """Of any motion each row is a tangent of von Mises' stress at one of the points printed.

    Its weights have no trace and the norm that makes it the largest such function below that
    stress. The first row's value is the largest in the mode with two diameters, of 200 instants.
    """
    path = tmp_path / "sector.h5"
    assert read_stress(job, "--stress", str(job / "modes.dat"), "--output", str(path)) == 0
    model = neutral.from_arrays(model_file.read(path))
    mesh, n = sector(SMALL), len(model.dof)
    blade = mesh.elements[mesh.blade_elements]
    moved = np.random.default_rng(0).standard_normal((30, n))
    moved[:, model.fixed] = 0.0
    ours = moved @ model.stress.T
    points = stresses(model.nodes, blade, moved.reshape(30, -1, 3)).reshape(30, -1, 6)
    for row in ours.T:
        fits = [np.linalg.lstsq(points[:, p], row) for p in range(points.shape[1])]
        weights = min(fits, key=lambda fit: fit[1].sum())[0]
        assert np.abs(points @ weights - row[:, None]).max(axis=0).min() < 1e-4 * np.ptp(row)
        xx, yy, zz, xy, xz, yz = weights * [1, 1, 1, 0.5, 0.5, 0.5]
        tangent = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        assert np.trace(tangent) == pytest.approx(0.0, abs=1e-3)
        assert (tangent**2).sum() == pytest.approx(1.5, rel=1e-3)
    P, K, M = cyclic.wave_matrices(to_cylindrical(model), 2, 0.0)
    shape = P @ eigh(K.toarray(), M.toarray(), subset_by_index=[0, 0])[1][:, 0]
    tips = shape.reshape(-1, 3)[model.contact_node]
    shape = to_cartesian(model.nodes, shape.reshape(-1, 3))
    instants = np.exp(1j * np.linspace(0, np.pi, 200))[:, None, None] * shape / np.abs(tips).max()
    xx, yy, zz, xy, xz, yz = np.moveaxis(stresses(model.nodes, blade, instants.real), -1, 0)
    mises = np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2
                    + 3 * (xy**2 + xz**2 + yz**2))  # fmt: skip
    said = float(capsys.readouterr().out.split("MPa per mm of the tip]:")[1].split(",")[0])
    assert said == pytest.approx(1e-9 * mises.max(), rel=6e-3)


def test_rows_of_stress_turn_with_their_blades(job, tmp_path):
    """A motion of the disk, and the same one blade further on, have the same stresses so."""
    path = tmp_path / "sector.h5"
    read_stress(job, "--stress", str(job / "modes.dat"), "--output", str(path))
    disk = assembly.assemble(neutral.from_arrays(model_file.read(path)))
    small, basis = reduced.reduce_disk(disk, 10)
    found = reduced.reduced_model(small, 0.0)
    N, rows = SMALL.n_sectors, found.interface.stress
    assert (found.interface.stress_blade == np.repeat(np.arange(N), len(rows) // N)).all()
    np.testing.assert_allclose(rows, disk.stress @ basis)
    like = craig_bampton.like_rows(disk)  # rows of like nodes of all sectors
    moved = np.zeros((N, disk.mass.shape[0]))
    part = np.random.default_rng(1).standard_normal(like.shape)
    for turn in range(N):
        moved[turn, np.maximum(like, 0)] = np.where(like >= 0, np.roll(part, turn, axis=0), 0.0)
    by_blade = (moved @ disk.stress.T).reshape(N, N, -1)  # turn, blade, place
    scale = np.abs(by_blade).max()
    for turn in range(N):
        turned = np.roll(by_blade[0], turn, axis=0)
        np.testing.assert_allclose(by_blade[turn], turned, atol=1e-9 * scale)


def noisy(text):
    """The last stress of every line up to 30 % larger."""
    lines, drawn = text.splitlines(), np.random.default_rng(0)
    for i, line in enumerate(lines):
        *words, last = line.split() or [""]
        if len(words) == 7:
            lines[i] = " ".join([*words, f"{float(last) * (1 + 0.3 * drawn.random()):.6E}"])
    return "\n".join(lines)


def without_motion(text):
    """Zeros for the last mode, as ccx 2.20 prints them when it is asked for too many."""
    head, _, last = text.rpartition("displacements")
    return f"{head}displacements{re.sub(r'-?[0-9.]+E[-+][0-9]+', '0.000000E+00', last)}"


def imaginary(text):
    """A negative eigenvalue, in the table as ccx prints it."""
    row = "   0.1E+08   0.3E+04   0.5E+03   0.0E+00\n"
    return text.replace(row, row + "      2  -0.4E+10   0.0E+00   0.0E+00   0.6E+05\n", 1)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda text: text.replace("stresses", "strains"), "in several modes are expected"),
        (lambda text: text.rsplit("\n", 3)[0], "in several modes are expected"),
        (lambda text: text.replace(" 5   1 ", "99   1 "), "element 99 is not one of"),
        (noisy, "is predicted by the others"),
        (without_motion, "mode 80 has no motion: ccx was asked for more modes than it can find"),
        (imaginary, "mode 2 has a negative eigenvalue: ccx was asked for more modes than it can"),
    ],
)
def test_modes_without_a_stress_that_can_be_used(job, tmp_path, capsys, spoil, message):
    """Also a stress that is no linear function of the displacements of its element's nodes."""
    (tmp_path / "spoilt.dat").write_text(spoil((job / "modes.dat").read_text()))
    assert read_stress(job, "--stress", str(tmp_path / "spoilt.dat")) == 2
    assert message in " ".join(capsys.readouterr().err.split())


def write_matrix_market(folder, number):
    """The sector as MatrixMarket files with CSV lists; number: of every node."""
    arrays, mesh = sector_arrays(), sector(SMALL)
    how = {"symmetry": "symmetric", "precision": 17}
    for name in ("K", "M", "K_blade"):
        scipy.io.mmwrite(folder / f"{name}.mtx", matrix_of(arrays, name), **how)
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
        "** a comment\n*HEADING\nwords\n*NODE\n1,0,0,0\n3,1,0,0\n5,1,1\n*INCLUDE, INPUT=more.inp\n"
        "*Nset, nset=b\nA, 5\n"
    )
    found = deck.read(tmp_path / "d.inp")
    assert found.node.tolist() == [1, 3, 5]
    assert found.sets["A"].tolist() == found.sets["B"].tolist() == [1, 3, 5]
    with pytest.raises(InputError, match="there is no node set tips; there are A, B"):
        deck.listed(found.sets, "tips", "d.inp: there is no node set")


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


def command(*arguments):
    return program(["import", *map(str, arguments)])


def test_the_other_sense_of_rotation_is_that_of_the_mirror_image():
    """Friction lifts the tips of one as it lowers those of the other; turns: -1 gives it back."""
    exact = neutral.from_arrays(sector_arrays(lean=0.6))
    arrays = seen_from(sector_arrays(lean=0.6), np.diag([1.0, -1.0, 1.0]))
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
