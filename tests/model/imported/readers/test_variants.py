"""Files as programs really write them: supports of 1e36, packed, semicolons, exponents D."""

import gzip
import re
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp

from evidence.truth.hexahedra import SMALL, matrix_of, sector_arrays
from hpcrub.errors import InputError
from hpcrub.model.imported import assembly, checks, frames, neutral
from hpcrub.model.imported.arrays import symmetric
from hpcrub.model.imported.readers import matrix_market
from tests.model.imported.readers.test_readers import (
    command,
    first_family,
    same_model,
    write_matrix_market,
)

SIDES = "--sectors", SMALL.n_sectors, "--units", "m kg s"


@pytest.fixture
def written(folder):
    """A folder of MatrixMarket files with CSV lists of the sector, the working folder."""
    write_matrix_market(folder, np.arange(1, 1 + len(sector_arrays()["nodes"])))


def read():
    return matrix_market.read(".", SMALL.n_sectors)


def huge_supports():
    """The stiffness as Abaqus writes it: 1e36 on the diagonals of held rows."""
    K = matrix_of(sector_arrays(), "K").tolil()
    for row in sector_arrays()["fixed"]:
        K[row, row] = 1e36
    return K.tocsr()


def test_1e36_on_the_diagonal_holds_a_row(written, exact):
    """Without fixed.csv; the first family was at 348,189 Hz."""
    Path("fixed.csv").unlink()
    scipy.io.mmwrite("K.mtx", huge_supports(), symmetry="symmetric", precision=17)
    model = neutral.from_arrays(read())
    np.testing.assert_array_equal(model.fixed, np.sort(exact.fixed))
    np.testing.assert_allclose(first_family(model), first_family(exact), rtol=1e-9)
    assert checks.check(model).rigid_residual < 1e-12


def test_1e36_hides_no_wrong_list_of_rows(written, capsys):
    """What is left by a rigid motion was compared with the largest entry of the matrix."""
    scipy.io.mmwrite("K.mtx", huge_supports(), symmetry="symmetric", precision=17)
    rows = Path("dof.csv").read_text().splitlines()
    Path("dof.csv").write_text("\n".join([rows[0], *np.roll(rows[1:], 5)]))
    assert command("matrixmarket", ".", *SIDES) == 2
    assert "K: a rigid motion causes forces at" in capsys.readouterr().err


@pytest.mark.parametrize("dense", [True, False])
def test_1e36_hides_no_asymmetry(dense):
    K = 1e9 * np.eye(4) + 1e8
    K[0, 0], K[1, 2] = 1e36, 2e8
    with pytest.raises(InputError, match=r"K: not symmetric, it differs .* by 9\.1e-02"):
        symmetric("K", K if dense else sp.csr_array(K))
    K[1, 2] = K[2, 1] * (1 + 1e-12)
    assert symmetric("K", K)[1, 2] == pytest.approx(1e8)


def test_a_penalty_between_two_nodes_is_no_support(exact):
    """It holds none of them: both keep their stiffness."""
    arrays = sector_arrays()
    i, j = exact.row[exact.contact_node[:2], 1]
    rows, columns = (i, j, i, j), (i, j, j, i)
    spring = sp.coo_array(
        (1e25 * np.array([1, 1, -1, -1]), (rows, columns)), shape=exact.mass.shape
    )
    K = (matrix_of(arrays, "K") + spring).tocsr()
    names = {f"K/{part}": getattr(K, part) for part in ("data", "indices", "indptr")}
    model = neutral.from_arrays(arrays | names)
    np.testing.assert_array_equal(model.fixed, exact.fixed)


@pytest.mark.parametrize("held", [[0], [1], [0, 2]])
def test_a_node_held_in_one_direction_of_the_plane_is_held_so(exact, held):
    """It was held in its radial direction in place of x; truth: rows taken out of the matrices."""
    arrays = sector_arrays()
    inside = np.setdiff1d(np.arange(len(exact.nodes)), [*arrays["low"], *arrays["high"]])
    node = inside[np.abs(np.cos(2 * frames.node_angle(exact.nodes)[inside])).argmin()]
    rows = exact.row[node, held]
    model = neutral.from_arrays(arrays | {"fixed": np.union1d(arrays["fixed"], rows)})
    K, M = (matrix_of(arrays, name).tolil() for name in ("K", "M"))
    for row in rows:
        K[row, row] = 1e11 * K[row, row]  # a spring that is stiff enough for nine digits
    spring = neutral.from_arrays(arrays)._replace(stiffness=(K.tocsr(),), mass=M.tocsr())
    np.testing.assert_allclose(first_family(model), first_family(spring), rtol=1e-7)


def test_a_node_of_a_side_held_in_one_direction_is_refused(exact):
    arrays = sector_arrays()
    rows = exact.row[arrays["high"][-1], :1]
    model = neutral.from_arrays(arrays | {"fixed": np.union1d(arrays["fixed"], rows)})
    with pytest.raises(InputError, match="is held in one of x and y only"):
        assembly.assemble(model)


def packed(name):
    with gzip.open(f"{name}.gz", "wt") as file:
        file.write(Path(name).read_text())
    Path(name).unlink()


def edited(name, change):
    Path(name).write_text(change(Path(name).read_text()))


def semicolons(lines):
    """As a German spreadsheet writes them."""
    return lines.replace(",", ";").replace(".", ",")


VARIANTS = {
    "packed": lambda: [packed(name) for name in ("K.mtx", "M.mtx", "nodes.csv", "fixed.csv")],
    "no last line break": lambda: [edited(f"{name}.mtx", str.rstrip) for name in "KM"],
    "semicolons": lambda: edited("nodes.csv", semicolons),
    "blanks": lambda: edited("nodes.csv", lambda lines: lines.replace(",", "  ")),
    "tabs": lambda: edited("dof.csv", lambda lines: lines.replace(",", "\t")),
    "exponents D": lambda: [
        edited(name, lambda lines: re.sub(r"(\d)[eE]([-+]\d)", r"\1D\2", lines))
        for name in ("K.mtx", "nodes.csv")
    ],
    "line of names": lambda: [
        edited(f"{name}.csv", lambda lines: f"node number\n{lines}") for name in ("low", "contact")
    ],
    "commented": lambda: edited("nodes.csv", lambda lines: f"# number, x, y, z\n\n{lines}"),
    "byte order mark": lambda: edited("nodes.csv", lambda lines: f"\ufeff{lines}"),
    "other line breaks": lambda: edited("nodes.csv", lambda lines: lines.replace("\n", "\r\n")),
    "several in a line": lambda: edited("high.csv", lambda lines: lines.replace("\n", ", ")),
    "commas at the ends": lambda: edited("nodes.csv", lambda lines: lines.replace("\n", ",\n")),
}


@pytest.mark.parametrize("how", VARIANTS)
def test_variants_of_a_folder_are_the_same_sector(written, exact, how):
    VARIANTS[how]()
    same_model(read(), exact)


def huge_head(text):
    """It announces more rows than there is memory for."""
    lines = text.splitlines(keepends=True)
    at = next(k for k, line in enumerate(lines) if not line.startswith("%"))
    lines[at] = f"{10**10} {10**10} {10**11}\n"
    return "".join(lines)


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("K.mtx", lambda _: "1,1, 1,1, 1.5e5\n",
         'those of Abaqus, which "hpcrub import abaqus" reads'),
        ("K.mtx", lambda _: "my matrix\n1 2\n3\n", "begins neither with %%MatrixMarket nor"),
        ("K.mtx", None, "there is no K.mtx or K0.mtx or K_at_1.mtx"),
        ("nodes.csv", lambda lines: lines + "7,8\n", "nodes.csv: line 39 has 2 numbers, 4 numbers"),
        ("nodes.csv", lambda lines: lines + "99,a,0,0\n", "line 39: 'a' is not a number"),
        ("fixed.csv", lambda lines: lines + "999\n", "fixed.csv: there is no node 999"),
        ("contact.csv", lambda _: "1,0,0,0\n", "4 numbers in a line, 3 at most expected"),
        ("K.mtx", lambda text: text[:-4], "K.mtx: cannot be read (it ends in the middle of a line"),
        ("K.mtx", huge_head, "in its head, but"),
        ("nodes.csv", lambda text: text + "3,0,0,0\n", "nodes.csv: node 3 stands there twice"),
        ("contact.csv", lambda text: text + "1.7\n", "contact.csv: there is no node 1.7"),
        ("fixed.csv", lambda text: text + "34\n", "is held; the tips must move"),
        ("fixed.csv", None, "the disk is not held"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_said_with_what_to_do(written, capsys, name, change, words):
    lines = Path(name).read_text()
    Path(name).unlink()
    if change:
        Path(name).write_text(change(lines))
    assert command("matrixmarket", ".", *SIDES) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1


def harwell_boeing(matrix, kind, exponent, right=0):
    """Text of a file, as Ansys's HBMAT writes it; of a symmetric matrix the lower triangle."""
    A = sp.csc_array(sp.tril(matrix) if kind == "RSA" else matrix)
    blocks = []
    for values, many, form in (
        (A.indptr + 1, 8, "{:10d}"), (A.indices + 1, 8, "{:10d}"), (A.data, 3, "{:24.16E}"),
    ):  # fmt: skip
        words = [form.format(value).replace("E", exponent) for value in values.tolist()]
        blocks.append(["".join(words[k : k + many]) for k in range(0, len(words), many)])
    sizes = [len(block) for block in blocks]
    head = ["stiffness".ljust(72) + "K", "".join(f"{n:14d}" for n in (sum(sizes), *sizes, right))]
    head += [kind.ljust(14) + "".join(f"{n:14d}" for n in (*A.shape, A.nnz, 0))]
    head += ["(8I10)".ljust(16) * 2 + f"(1P,3{exponent}24.16)".ljust(20) * 2]
    head += ["F" + " " * 13 + f"{1:14d}{0:14d}"] * bool(right)
    return "\n".join([*head, *sum(blocks, []), *["0.0"] * right, ""])


@pytest.mark.parametrize(("kind", "exponent", "right"), [("RSA", "E", 0), ("RUA", "D", 1)])
def test_harwell_boeing(written, exact, kind, exponent, right):
    Path("K.mtx").unlink()
    K = matrix_of(sector_arrays(), "K")
    Path("K.hb").write_text(harwell_boeing(K, kind, exponent, right))
    same_model(read(), exact)


def test_harwell_boeing_as_scipy_writes_it(written, exact):
    Path("M.mtx").unlink()
    scipy.io.hb_write("M.hb", sp.csc_matrix(matrix_of(sector_arrays(), "M")))
    same_model(read(), exact)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda lines: lines.replace("RSA", "PSA"), "PSA is no real, assembled matrix"),
        (lambda lines: lines[: len(lines) // 2], "K.hb: cannot be read"),
        (lambda lines: lines.replace("RSA", "RSE"), "RSE is no real, assembled matrix"),
    ],
)
def test_other_harwell_boeing_files_are_refused(folder, change, words):
    Path("K.hb").write_text(change(harwell_boeing(sp.csr_array(np.eye(9)), "RSA", "E")))
    with pytest.raises(InputError, match=words):
        matrix_market.matrix(Path("K.hb"), 9)
