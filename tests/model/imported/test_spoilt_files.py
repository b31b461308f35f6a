"""Files of other programs that are cut off, lie or never end: refused with one sentence."""

import h5py
import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp

from evidence.truth.hexahedra import SMALL, sector, sector_arrays
from hpcrub.model.imported.readers import matrix_market
from hpcrub.results import model_file
from tests.model.imported.test_readers import command, matrix_of


def one_line(capsys, words):
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1


def test_a_name_that_is_taken_is_kept(tmp_path, capsys):
    """Like a study: nothing is replaced unasked, and what is no model file never."""
    source, out = tmp_path / "sector.h5", tmp_path / "out.h5"
    model_file.write(source, sector_arrays())
    assert command("model", source, "--output", out) == 0
    before = out.read_bytes()
    assert command("model", source, "--output", out) == 2
    one_line(capsys, "out.h5 exists: --overwrite replaces it")
    assert out.read_bytes() == before
    assert command("model", source, "--output", out, "--overwrite") == 0
    for name in ("result.h5", "mine.npz"):
        foreign = tmp_path / name
        if name == "result.h5":
            with h5py.File(foreign, "w") as file:
                file["samples"] = 1.0
        else:
            foreign.write_text("my own notes")
        before = foreign.read_bytes()
        capsys.readouterr()
        assert command("model", source, "--output", foreign, "--overwrite") == 2
        assert name in capsys.readouterr().err
        assert foreign.read_bytes() == before


def market_folder(folder):
    """The sector as MatrixMarket files with CSV lists; returns the options that import it."""
    arrays, mesh = sector_arrays(), sector(SMALL)
    number = np.arange(1, len(arrays["nodes"]) + 1)
    for name in ("K", "M", "K_blade"):
        scipy.io.mmwrite(
            folder / f"{name}.mtx", matrix_of(arrays, name), symmetry="symmetric", precision=17
        )
    np.savetxt(folder / "nodes.csv", np.column_stack([number, arrays["nodes"]]), delimiter=",")
    rows = np.column_stack([number[arrays["dof"][:, 0]], arrays["dof"][:, 1]])
    np.savetxt(folder / "dof.csv", rows, "%d", ",")
    for name, nodes in (("low", "low"), ("high", "high"), ("contact", "tip"), ("fixed", "bore")):
        np.savetxt(folder / f"{name}.csv", number[mesh.sets[nodes]], "%d")
    return ("matrixmarket", folder, "--sectors", SMALL.n_sectors, "--units", "m kg s")


def _cut(folder):
    text = (folder / "K.mtx").read_bytes()
    (folder / "K.mtx").write_bytes(text[:-4])


def _huge_head(folder):
    lines = (folder / "K.mtx").read_text().splitlines(keepends=True)
    n = len((folder / "dof.csv").read_text().splitlines())
    at = next(k for k, line in enumerate(lines) if line.split()[:2] == [str(n)] * 2)
    lines[at] = f"{10**10} {10**10} {10**11}\n"
    (folder / "K.mtx").write_text("".join(lines))


def _twice(folder):
    with open(folder / "nodes.csv", "a") as file:
        file.write("3,0,0,0\n")


def _fraction(folder):
    with open(folder / "contact.csv", "a") as file:
        file.write("1.7\n")


def _held_tips(folder):
    (folder / "fixed.csv").write_text((folder / "contact.csv").read_text())


def _no_supports(folder):
    (folder / "fixed.csv").unlink()


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (_cut, "K.mtx: cannot be read (it ends in the middle of a line"),
        (_huge_head, "in its head, but"),
        (_twice, "nodes.csv: node 3 stands there twice"),
        (_fraction, "contact.csv: there is no node 1.7"),
        (_held_tips, "is held; the tips must move"),
        (_no_supports, "the disk is not held"),
    ],
)
def test_spoilt_matrix_market_folders_are_refused(tmp_path, capsys, spoil, words):
    options = market_folder(tmp_path)
    spoil(tmp_path)
    assert command(*options) == 2
    one_line(capsys, words)


def test_exponents_of_fortran(tmp_path):
    """1.2D-02 is 0.012; SciPy's reader stops at the D."""
    path = tmp_path / "A.mtx"
    path.write_text(
        "%%MatrixMarket matrix coordinate real symmetric\n2 2 2\n1 1 1.2D-02\n2 1 3d0\n"
    )
    found = matrix_market.matrix(path, 2).toarray()
    np.testing.assert_array_equal(found, [[0.012, 3.0], [3.0, 0.0]])


@pytest.mark.parametrize("symmetry", ["general", "symmetric"])
@pytest.mark.parametrize("sparse", [True, False])
def test_matrices_are_those_of_scipys_writer(tmp_path, symmetry, sparse):
    a = np.random.default_rng(5).standard_normal((4, 4))
    a = a + a.T if symmetry == "symmetric" else a
    scipy.io.mmwrite(tmp_path / "A.mtx", sp.coo_array(a) if sparse else a, symmetry=symmetry,
                     precision=17)  # fmt: skip
    np.testing.assert_array_equal(matrix_market.matrix(tmp_path / "A.mtx", 4).toarray(), a)


@pytest.mark.parametrize("text", ["*INCLUDE, INPUT=d.inp\n", f"*NODE\n{10**23},0,0,0\n"])
def test_a_deck_that_includes_itself_or_overflows_is_refused(folder, capsys, text):
    (folder / "d.inp").write_text("*NODE\n1,0,0,0\n" + text)
    assert command("calculix", "d.inp", "--contact", "A", "--units", "mm t s") == 2
    one_line(capsys, "d.inp: cannot be read")


def _far_blade(arrays):
    blade = np.zeros(len(arrays["contact_node"]), int)
    blade[0] = 2 * 10**9
    return {"kind": np.array("disk"), "contact_blade": blade}


def _no_word(arrays):
    return {"kind": np.array([["sector", "disk"]])}


def _light(arrays):
    return {"M/data": 1e-300 * arrays["M/data"]}


def _many_sectors(arrays):
    return {"n_sectors": np.array(10**12)}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (_far_blade, "contact_blade: blade 2 has no contact nodes; 1 is named nowhere"),
        (_no_word, "kind: one word is expected"),
        (_light, "no modes can be found"),
        (_many_sectors, "2 to 200"),
    ],
)
def test_spoilt_model_files_are_refused(tmp_path, capsys, changes, words):
    arrays = sector_arrays()
    model_file.write(tmp_path / "m.npz", arrays | changes(arrays))
    assert command("model", tmp_path / "m.npz") == 2
    one_line(capsys, words)


def _claims(path):
    with h5py.File(path, "w") as file:
        file.create_dataset("K", (10**6, 10**6), "f8", chunks=(1000, 1000))


def _deep(path):
    with h5py.File(path, "w") as file:
        file.create_group("/".join("a" * 3000))


def _empty(path):
    path.write_bytes(b"")


@pytest.mark.parametrize(
    ("name", "make", "words"),
    [
        ("m.h5", _claims, "cannot be read"),
        ("m.h5", _deep, "cannot be read"),
        ("m.npz", _empty, "cannot be read"),
    ],
)
def test_files_that_are_no_model_are_refused(tmp_path, capsys, name, make, words):
    make(tmp_path / name)
    assert command("model", tmp_path / name) == 2
    one_line(capsys, words)
