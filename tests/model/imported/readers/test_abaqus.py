"""Jobs of Abaqus: the sector written as *MATRIX GENERATE writes it, with supports of 1e36."""

import gzip
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.linalg import eigh

from evidence import calculix as ccx
from evidence.truth.hexahedra import SMALL, matrix_of, sector, sector_arrays
from hpcrub.errors import InputError
from hpcrub.model.imported import cyclic, neutral
from hpcrub.model.imported.readers import abaqus, deck
from hpcrub.model.imported.readers.nodal import cylindrical
from hpcrub.model.imported.readers.rows import Lists
from tests.model.imported.readers.test_own_directions import in_own
from tests.model.imported.readers.test_readers import command, first_family, same_model

ARRAYS, MESH = sector_arrays(), sector(SMALL)
LISTS = Lists("TIP", "LOW", "HIGH", SMALL.n_sectors)


def write_matrix(name, matrix, without=()):
    """Lines of node, direction, node, direction, value of the lower triangle."""
    lower, dof = sp.coo_array(sp.tril(matrix)), ARRAYS["dof"] + [1, 0]
    with open(name, "w") as file:
        for i, j, value in zip(lower.row, lower.col, lower.data, strict=True):
            if value and not np.isin([i, j], without).any():
                (a, c), (b, d) = dof[i], dof[j]
                file.write(f"{a},{c}, {b},{d}, {value:.16e}\n")


def write_job(name, axes=None, step=1, supports=True, scale=1.0, blade=False):
    """Deck and matrices in N/mm and t; held nodes have 1e36 in the stiffness, and no mass."""
    K = 1e-3 * scale * in_own("K_blade" if blade else "K", axes or {})
    held = ARRAYS["fixed"] if supports else []
    K.setdiag(np.where(np.isin(np.arange(K.shape[0]), held), 1e36, K.diagonal()))
    write_matrix(f"{name}_STIF{step}.mtx", K)
    if not blade:
        write_matrix(f"{name}_MASS{step}.mtx", 1e-3 * in_own("M", axes or {}), held)
    ccx.write(Path(f"{name}.inp"), MESH, "** no steps\n", blade)


def read(**options):
    arrays = abaqus.read("disk.inp", LISTS, **options)
    return neutral.from_arrays(arrays | {"units": np.array("mm t s")})


@pytest.fixture
def job(folder):
    write_job("disk")
    write_job("blade", supports=False, blade=True)


def test_a_job_with_supports(job, exact):
    found = read(blade="blade.inp")
    np.testing.assert_allclose(first_family(found), first_family(exact), rtol=1e-9)
    assert set(map(tuple, found.dof[found.fixed])) == set(map(tuple, exact.dof[exact.fixed]))
    a, b = (m.blade_stiffness[np.lexsort(m.dof.T[::-1])].toarray() for m in (found, exact))
    np.testing.assert_allclose(np.abs(a).sum(axis=1), np.abs(b).sum(axis=1), rtol=1e-9, atol=1.0)


def test_the_command(job, capsys):
    sides = "--low", "LOW", "--high", "HIGH", "--sectors", SMALL.n_sectors
    assert command("abaqus", "disk.inp", "--units", "mm t s", "--contact", "TIP", *sides) == 0
    said = capsys.readouterr().out
    assert "held: 30 of the rows" in said
    assert f"0: {first_family(neutral.from_arrays(ARRAYS))[0]:11.4f}" in said


def test_without_supports_it_is_the_same_model(folder, exact):
    write_job("disk", supports=False)
    write_job("blade", supports=False, blade=True)
    arrays = abaqus.read("disk.inp", LISTS._replace(fixed="BORE"), "blade.inp")
    same_model(arrays, exact, "mm t s")


def test_nodes_that_a_transformation_turns(folder, exact):
    """Of a cylinder about z for one side, and of three points for the other; the deck tells."""
    low, high = MESH.sets["low"], MESH.sets["high"]
    third = np.cross([1.0, 2.0, 0.5], [0.0, 1.0, 3.0])
    base = np.array([[1.0, 2.0, 0.5], np.cross(third, [1.0, 2.0, 0.5]), third])
    base /= np.linalg.norm(base, axis=1)[:, None]
    axes = {int(node): cylindrical(ARRAYS["nodes"][node]) for node in low}
    axes |= {int(node): base for node in high}
    write_job("disk", axes)
    with Path("disk.inp").open("a") as file:
        file.write("*TRANSFORM, NSET=LOW, TYPE=C\n0., 0., 0., 0., 0., 7.\n")
        file.write('*Transform, nset="High"\n1., 2., 0.5, 0., 1., 3.\n')
    np.testing.assert_allclose(first_family(read()), first_family(exact), rtol=1e-9)


def test_packed_files_of_another_step_and_capitals(folder, exact):
    write_job("disk", step=2)
    for name in ("disk_STIF2.mtx", "disk_MASS2.mtx"):
        Path(f"{name}.gz").write_bytes(gzip.compress(Path(name).read_bytes()))
        Path(name).unlink()
    np.testing.assert_allclose(first_family(read()), first_family(exact), rtol=1e-9)


def test_jobs_at_two_speeds(folder):
    """The stiffness doubles with the square of the speed; so does that of the model."""
    for name, scale in (("disk", 1.0), ("at_100", 1.5), ("at_200", 3.0)):
        write_job(name, scale=scale)
    model = read(stiffness={100.0: "at_100.inp", 200.0: "at_200.inp"})
    found = cyclic.frequencies_by_diameter(model, 2 * np.pi * 100.0)[:, 0]
    np.testing.assert_allclose(found, np.sqrt(1.5) * first_family(model), rtol=1e-8)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda: Path("disk_MASS1.mtx").unlink(),
         r"there is no disk_MASS1\.mtx beside it .* \*MATRIX GENERATE, STIFFNESS, MASS"),
        (lambda: Path("disk_STIF2.mtx").write_text("1,1,1,1,1.\n"),
         r"there are disk_STIF1\.mtx and disk_STIF2\.mtx; leave that"),
        (lambda: Path("disk_STIF1.mtx").write_text("1 1 2.5\n2 2 2.5\n"),
         "3 numbers in a line; node, direction, node, direction, value are expected, as FORMAT"),
    ],
)  # fmt: skip
def test_files_that_are_not_those_of_one_state(job, change, words):
    change()
    with pytest.raises(InputError, match=words):
        read()


INSTANCES = "*INSTANCE, NAME=A, PART=P\n{}*END INSTANCE\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            INSTANCES.format("") * 2,
            r"more than one \*INSTANCE, whose numbers repeat; write the deck",
        ),
        (INSTANCES.format("1., 0., 0.\n"), r"\*INSTANCE is not read; write the deck flat"),
        ("*NGEN\n1, 3, 1\n", r"\*NGEN is not read"),
        ("*NODE, SYSTEM=C\n9, 1., 30., 0.\n", r"\*NODE, SYSTEM=C is not read"),
        ("*NSET, NSET=A, ELSET=EALL\n", r"\*NSET, ELSET=EALL is not read; list the nodes"),
        ("*TRANSFORM, NSET=LOW, TYPE=S\n0,0,0,0,0,1\n", "TYPE=S is not read; take R or C"),
        ("*TRANSFORM, NSET=NONE\n0,0,0,0,0,1\n", "TRANSFORM of the set NONE; there are"),
        ("*TRANSFORM, TYPE=C\n0,0,0,0,0,1\n", r"\*TRANSFORM holds a line that cannot be read"),
    ],
)
def test_nothing_of_a_deck_is_left_out_without_a_word(job, text, words):
    with Path("disk.inp").open("a") as file:
        file.write(text)
    with pytest.raises(InputError, match=words):
        read()


def test_blocks_of_other_files_and_names_in_quotes(folder):
    """As Abaqus/CAE writes them: *NODE, INPUT=, sets in quotes, one instance that does not move."""
    Path("nodes.inp").write_text("1, 0., 0., 0.\n2, 1., 0., 0.\n")
    Path("set.inp").write_text("1,\n")
    Path("d.inp").write_text(
        '*PART, NAME="My Part"\n*Node, input=nodes.inp, nset="All Nodes"\n*END PART\n'
        '*INSTANCE, NAME=A, PART="My Part"\n*END INSTANCE\n*AMPLITUDE, NAME=A, INPUT=none.txt\n'
        '*NSET, NSET="Tip", INTERNAL, INPUT = set.inp\n*NSET, NSET=B\n"Tip", 2\n'
    )
    found = deck.read("d.inp")
    assert found.node.tolist() == [1, 2]
    sets = {name: nodes.tolist() for name, nodes in found.sets.items()}
    assert sets == {"ALL NODES": [1, 2], "TIP": [1], "B": [1, 2]}


def test_matrices_are_whole_or_a_triangle(folder):
    a = np.array([[2.0, -1.0], [-1.0, 3.0]])
    Path("d_STIF1.mtx").write_text("1,1, 1,1, 2.\n1,1, 5,3, -1.\n5,3, 1,1, -1.\n5,3, 5,3, 3.\n")
    found = abaqus.job_matrix("d.inp", "STIF")
    assert found.dof.tolist() == [[1, 1], [5, 3]]
    np.testing.assert_array_equal(found.matrix.toarray(), a)


def test_one_blade_alone_is_a_disk_of_one_blade(folder, capsys):
    """A rig: its root is held, and its own stiffness is that of the blade."""
    write_job("blade", supports=False, blade=True)
    used = np.flatnonzero(abs(matrix_of(ARRAYS, "K_blade")).sum(axis=0))
    radius = np.hypot(*ARRAYS["nodes"][:, :2].T)[used // 3]
    root = np.unique(used[radius < radius.min() + 1e-6] // 3)
    others = np.setdiff1d(np.arange(len(ARRAYS["dof"])), used)
    write_matrix("blade_MASS1.mtx", 1e-3 * matrix_of(ARRAYS, "M"), others)
    Path("blade.inp").write_text(
        Path("blade.inp").read_text() + "\n*NSET, NSET=ROOT\n" + "".join(f"{n + 1}\n" for n in root)
    )
    options = "--units", "mm t s", "--contact", "TIP", "--fixed", "ROOT"
    assert command("abaqus", "blade.inp", "--blade", "blade.inp", *options) == 0
    said = capsys.readouterr().out
    free = used[~np.isin(used // 3, root)]
    K, M = (matrix_of(ARRAYS, name)[free][:, free].toarray() for name in ("K_blade", "M"))
    first = np.sqrt(eigh(K, M, eigvals_only=True)[0]) / (2 * np.pi)
    assert "disk: 72 dof, 1 blade, 2 to 2 contact nodes" in said
    assert f"  0: {first:11.4f}" in said
