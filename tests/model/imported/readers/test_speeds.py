"""Matrices at speeds of rotation: K + B W^2 M raises the square of every frequency by B W^2."""

import numpy as np
import pytest

from evidence.truth.hexahedra import SMALL, matrix_of, sector, sector_arrays
from hpcrub.errors import InputError
from hpcrub.model.imported import assembly, cyclic, neutral
from hpcrub.model.imported.neutral import polynomial
from tests.model.imported.readers.test_readers import command, write_calculix

B = 1.8
ARRAYS = sector_arrays()
K, M = (matrix_of(ARRAYS, name) for name in ("K", "M"))


@pytest.mark.parametrize("kind", ["sector", "disk"])
def test_rise_of_the_first_frequency(kind):
    model = neutral.from_arrays(ARRAYS)
    model = model if kind == "sector" else assembly.assemble(model)
    speeds = 2 * np.pi * np.array([0.0, 400.0, 900.0])
    K0 = model.stiffness[0]
    at = polynomial([K0 + B * speed**2 * model.mass for speed in speeds], speeds)
    error, rises = cyclic.between_speeds(model._replace(stiffness=at), speeds)
    np.testing.assert_allclose(rises, B, rtol=1e-6)
    assert abs(error) < 1e-8


@pytest.fixture
def jobs(folder):
    """Jobs of CalculiX at rest, 400 and 900 Hz, in mm and t."""
    for speed in (0, 400, 900):
        stiffness = (K + B * (2 * np.pi * speed) ** 2 * M) / 1e3
        matrices = {"sti": stiffness, "mas": M / 1e3}
        write_calculix(folder, f"at_{speed}", matrices, ARRAYS["dof"], sector(SMALL))


def read(*speeds):
    sides = "--low", "LOW", "--high", "HIGH", "--sectors", SMALL.n_sectors, "--fixed", "BORE"
    stiffness = [word for speed in speeds for word in ("--stiffness", speed)]
    source = "at_0.inp", "--units", "mm t s", "--contact", "TIP"
    return command("calculix", *source, *sides, *stiffness)


@pytest.mark.parametrize(
    ("speeds", "rises"),
    [
        (("400=at_400.inp", "900=at_900.inp"), None),
        (("900=at_900.inp", "400=at_400.inp"), None),
        (("400=at_900.inp", "900=at_400.inp"), ("9.1 of that", "-1.8 from 400 to 900")),
        (("24000=at_400.inp", "54000=at_900.inp"), ("0.0005 of that", "0.0005 from 24000")),
    ],
)
def test_speeds_in_rpm_or_exchanged_are_warned_of(jobs, capsys, speeds, rises):
    assert read(*speeds) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert ("warning: the first frequency's square rises by" in said) == (rises is not None)
    for words in rises or ():
        assert words in said


@pytest.mark.parametrize(
    "speeds", [("400=at_0.inp", "900=at_900.inp"), ("400=at_900.inp", "900=at_900.inp")]
)
def test_a_file_that_stands_for_two_speeds_is_refused(jobs, capsys, speeds):
    assert read(*speeds) == 2
    assert "hold the same matrix, though one is of" in capsys.readouterr().err


def test_cyclic_constraints_are_refused(jobs, folder, capsys):
    """By the deck's own words, and where the rows of one side, whichever, are not there."""
    with (folder / "at_0.inp").open("a") as file:
        file.write("\n*CYCLIC SYMMETRY MODEL, N=5, TIE=SIDES\n0., 0., 0., 0., 0., 1.\n")
    assert read() == 2
    assert "*CYCLIC SYMMETRY MODEL takes the rows of one side out" in capsys.readouterr().err


@pytest.mark.parametrize("side", ["low", "high"])
def test_a_side_without_rows_is_refused(side):
    """The low side's were asked for only, and sectors that do not hang together were made."""
    free = np.setdiff1d(ARRAYS[side], sector(SMALL).sets["bore"])
    kept = np.flatnonzero(~np.isin(ARRAYS["dof"][:, 0], free))
    model = neutral.from_arrays(ARRAYS)
    fixed = np.flatnonzero(np.isin(kept, model.fixed))
    cut = model._replace(mass=model.mass[kept][:, kept], dof=model.dof[kept], fixed=fixed,
                         stiffness=(model.stiffness[0][kept][:, kept],), blade_stiffness=None,
                         stress=model.stress[:, kept])  # fmt: skip
    with pytest.raises(InputError, match="that its partner on the other side lacks; the matrices"):
        assembly.assemble(cut)
