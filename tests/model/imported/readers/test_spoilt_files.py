"""Files of other programs that are cut off, lie or never end: refused with one sentence."""

import os
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp

from evidence.truth.hexahedra import sector_arrays
from hpcrub.errors import InputError
from hpcrub.model.imported.arrays import PARTS
from hpcrub.model.imported.readers import calculix, matrix_market
from hpcrub.results import model_file
from tests.model.imported.readers.test_readers import command, write_matrix_market


def one_line(capsys, words):
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1


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
    assert command(*arguments) == 2
    one_line(capsys, words)


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
    with h5py.File(tmp_path / "result.h5", "w") as file:
        file["samples"] = 1.0
    (tmp_path / "mine.hdf5").write_text("my own notes")
    for foreign in (tmp_path / "result.h5", tmp_path / "mine.hdf5"):
        before = foreign.read_bytes()
        capsys.readouterr()
        assert command("model", source, "--output", foreign, "--overwrite") == 2
        assert foreign.name in capsys.readouterr().err
        assert foreign.read_bytes() == before


@pytest.mark.parametrize("symmetry", ["general", "symmetric"])
@pytest.mark.parametrize("sparse", [True, False])
def test_matrices_are_those_of_scipys_writer(tmp_path, symmetry, sparse):
    a = np.random.default_rng(5).standard_normal((4, 4))
    a = a + a.T if symmetry == "symmetric" else a
    scipy.io.mmwrite(tmp_path / "A.mtx", sp.coo_array(a) if sparse else a, symmetry=symmetry,
                     precision=17)  # fmt: skip
    np.testing.assert_array_equal(matrix_market.matrix(tmp_path / "A.mtx", 4).toarray(), a)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("*INCLUDE, INPUT=d.inp\n", "d.inp: includes itself"),
        ("*INCLUDE, INPUT=/dev/zero\n", "/dev/zero: is neither a file nor a folder"),
        (f"*NODE\n{10**23},0,0,0\n", "d.inp: cannot be read"),
        (f"*NSET, NSET=A, GENERATE\n1, {10**11}, 1\n", "*NSET holds a line that cannot be read"),
    ],
)
def test_a_deck_that_never_ends_is_refused(folder, capsys, text, words):
    (folder / "d.inp").write_text("*NODE\n1,0,0,0\n" + text)
    assert command("calculix", "d.inp", "--contact", "A", "--units", "mm t s") == 2
    one_line(capsys, words)


FAR = np.array([2 * 10**9, 0])  # of two contact nodes


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (lambda a: {"kind": np.array("disk"), "contact_blade": FAR},
         "contact_blade: blade 2 has no contact nodes; 1 is named nowhere"),
        (lambda a: {"kind": np.array([1, 2])}, "kind: one word is expected"),
        (lambda a: {"fixed": np.zeros(0, int)}, "no modes can be found"),
        (lambda a: {f"K_blade/{p}": a[f"K/{p}"] for p in PARTS}, "K_blade: blades 0 and 1 hang"),
        (lambda a: {"n_sectors": np.array(10**12)}, "2 to 200"),
        (lambda a: {"kind": np.array("disk"), "n_sectors": np.array(-3)},
         "n_sectors: -3, and contact_blade names 1"),
    ],
)  # fmt: skip
def test_spoilt_model_files_are_refused(tmp_path, capsys, changes, words):
    arrays = sector_arrays()
    model_file.write(tmp_path / "m.h5", arrays | changes(arrays))
    assert command("model", tmp_path / "m.h5") == 2
    one_line(capsys, words)


def dataset(shape, **options):
    return lambda file: file.create_dataset("K", shape, "f8", **options)


@pytest.mark.parametrize(
    ("fill", "words"),
    [
        (dataset((10**6, 10**6), chunks=(1000, 1000)), "cannot be read"),
        (dataset(10**7, chunks=1000, compression="gzip"), "claims 80,000,000 bytes, and holds 0"),
        (dataset(3, external=[("other.h5", 0, 24)]), "m.h5: K is a link, or its data is stored"),
        (lambda f: f.update(K=h5py.ExternalLink("pipe", "K")), "m.h5: K is a link, or its data"),
        (lambda file: file.create_group("/".join("a" * 3000)), "cannot be read"),
        (lambda _: Path("m.h5").unlink() or Path("m.h5").touch(), "is empty"),
        (lambda _: Path("m.h5").unlink() or Path("m.h5").mkdir(),
         "hpcrub: error: m.h5: cannot be read (Is a directory)\n"),
    ],
)  # fmt: skip
def test_files_that_are_no_model_are_refused(folder, capsys, fill, words):
    with h5py.File("other.h5", "w") as other:
        other["K"] = np.ones(3)
    os.mkfifo("pipe")
    with h5py.File("m.h5", "w") as file:
        fill(file)
    assert command("model", "m.h5") == 2
    one_line(capsys, words)


def test_what_a_file_says_is_told_as_one_line_of_plain_text(folder, capsys):
    """Control characters reached the terminal, and a million characters were echoed."""
    arrays = sector_arrays() | {"frame": np.array("\x1b[2J" + 10**6 * "a")}
    model_file.write("m.h5", arrays)
    assert command("model", "m.h5") == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.isprintable()
    assert len(line) < 10_000


@pytest.mark.parametrize("ending", ["sti", "dof"])
def test_a_matrix_or_its_rows_that_never_end_are_refused(folder, ending):
    Path("d.dof").write_text("1.1\n")
    Path("d.sti").write_text("1 1 1.0\n")
    assert calculix.job_matrix("d.inp", "sti").dof.tolist() == [[1, 1]]
    Path(f"d.{ending}").unlink()
    os.mkfifo(f"d.{ending}")
    with pytest.raises(InputError, match=f"d.{ending}: is neither a file nor a folder"):
        calculix.job_matrix("d.inp", "sti")


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("dof.csv", "node,direction\n1,nan\n", "dof.csv: line 2: 'nan' is not a number"),
        ("nodes.csv", "\n", "nodes.csv: there are no numbers in it"),
    ],
)
def test_a_refused_file_is_one_line_without_warnings_of_libraries(
    folder, capsys, recwarn, name, text, words
):
    write_matrix_market(folder, 1 + np.arange(len(sector_arrays()["nodes"])))
    (folder / name).write_text(text)
    assert command("matrixmarket", ".", "--units", "m kg s") == 2
    assert capsys.readouterr().err == f"hpcrub: error: {words}\n"
    assert not recwarn.list


def test_a_matrix_has_whole_numbers_of_rows(folder):
    Path("d.dof").write_text("1.1\n1.2\n")
    Path("d.sti").write_text("1 1 1.0\n2 1.5 1.0\n")
    with pytest.raises(InputError, match=r"d\.sti: 1\.5 is no whole number"):
        calculix.job_matrix("d.inp", "sti")
