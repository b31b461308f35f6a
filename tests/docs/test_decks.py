"""The tutorial's script makes decks of a sector, of its blade alone, and at speeds, of one deck."""

import re
from pathlib import Path

import numpy as np
import pytest

from docs import decks
from evidence.blisk.mesh import BLISK, sector
from evidence.truth.hexahedra import SMALL
from hpcrub.model.imported.readers import deck as reader

NAMES = ("--blade", "Blade", "--fixed", "BORE", "--low", "LOW", "--high", "HIGH", "--sectors", "5")
MODEL = """\
*MATERIAL, NAME=TI
*ELASTIC
113800., 0.33
*DENSITY
4.43e-9
*ELSET, ELSET=WHOLE
DISK, BLADE
*SOLID SECTION, ELSET=WHOLE, MATERIAL=TI
*BOUNDARY
BORE, 1, 3
*STEP
*FREQUENCY
10
*END STEP
"""


@pytest.fixture
def mesh(folder):
    """Mesh of a sector, whose deck lies in the working folder as it may be delivered: two files."""
    mesh = sector(SMALL)
    text = "*HEADING\nmy fan\n*NODE\n"
    text += "".join(f"{n}, {x}, {y}, {z}\n" for n, (x, y, z) in enumerate(mesh.nodes.tolist(), 1))
    rest = np.setdiff1d(np.arange(len(mesh.elements)), mesh.blade_elements)
    for name, labels in (("DISK", rest), ("BLADE", mesh.blade_elements)):
        text += f"*ELEMENT, TYPE=C3D8, ELSET={name}\n"
        for k in labels:
            words = [str(n) for n in (k + 1, *(mesh.elements[k] + 1))]
            text += f"{', '.join(words[:5])},\n {', '.join(words[5:])}\n"
    sets = "".join(
        f"*NSET, NSET={name.upper()}\n" + "".join(f"{n + 1},\n" for n in nodes)
        for name, nodes in mesh.sets.items()
    )
    Path("sets.inp").write_text(sets)
    Path("fan.inp").write_text(f"{text}*INCLUDE, INPUT=sets.inp\n** the rest\n{MODEL}")
    return mesh


def test_decks_hold_what_each_job_needs(mesh):
    decks.main(["fan.inp", *NAMES, "--speeds", "80"])
    names = "sector", "blade_alone", "state_80"
    disk, blade, state = (reader.read(f"{name}.inp") for name in names)
    assert {label for _, label, _ in disk.elements} == set(range(1, len(mesh.elements) + 1))
    assert {label for _, label, _ in blade.elements} == set(mesh.blade_elements + 1)
    corners = {label: nodes for _, label, nodes in disk.elements}
    assert corners[3] == (mesh.elements[2] + 1).tolist()
    held = np.setdiff1d(mesh.sets["bore"], mesh.sets["low"]) + 1
    np.testing.assert_array_equal(state.sets["HELD"], held)
    assert "BOUNDARY" not in Path("blade_alone.inp").read_text()
    load = re.search(r"CENTRIF, ([\d.]+)", Path("sector_80.inp").read_text())
    assert float(load[1]) == pytest.approx((2 * np.pi * 80.0) ** 2)


def test_the_page_names_the_blade_of_the_sector_to_try_it_with():
    page = (Path(decks.__file__).parent / "tutorial_own_disk.md").read_text("utf-8")
    first, last = map(int, re.search(r"GENERATE\\n(\d+), (\d+)", page).groups())
    np.testing.assert_array_equal(sector(BLISK).blade_elements + 1, np.arange(first, last + 1))


def test_a_set_that_is_not_there_is_named(mesh):
    with pytest.raises(SystemExit, match="no element set LEAF; there are DISK, BLADE, WHOLE"):
        decks.main(["fan.inp", "--blade", "LEAF", *NAMES[2:]])
    with pytest.raises(SystemExit, match="no node set RIM; there are"):
        decks.main(["fan.inp", *NAMES[:2], "--fixed", "RIM", *NAMES[4:]])


LOST = "would be lost; take it out if"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("*EQUATION\n2\n1, 1, 1., 2, 1, -1.\n", rf"fan\.inp: \*EQUATION {LOST}"),
        ("*SHELL SECTION, ELSET=A\n2.\n", rf"\*SHELL SECTION {LOST}"),
        ("*NODE, SYSTEM=C\n999, 1, 30, 0\n", rf"\*NODE, SYSTEM {LOST}"),
        ("*INSTANCE, NAME=A\n1., 0., 0.\n*END INSTANCE\n", rf"\*INSTANCE {LOST}"),
        ("*ELEMENT, TYPE=S4, ELSET=SKIN\n999, 1, 2, 3, 4\n", r"element 999 has no \*SOLID SECT"),
        ("*SOLID SECTION, ELSET=NONE, MATERIAL=TI\n", r"set of a \*SOLID SECTION: NONE; there are"),
        ("*ELSET, ELSET=A\nLEAVES\n", "no set that another set names LEAVES; there are"),
        ("*NSET, NSET=A, ELSET=BLADE\n", r"\*NSET, ELSET=BLADE is not read; list the nodes"),
    ],
)
def test_no_part_of_a_model_is_lost_without_a_word(mesh, text, words):
    """They were dropped, or ended in a traceback."""
    deck = Path("fan.inp").read_text()
    Path("fan.inp").write_text(deck.replace("*BOUNDARY", text + "*BOUNDARY"))
    with pytest.raises(SystemExit, match=words):
        decks.main(["fan.inp", *NAMES])


def test_names_in_quotes_and_what_is_left_out(mesh, capsys):
    """As Abaqus/CAE writes them, with blanks, which CalculiX does not read."""
    deck = Path("fan.inp").read_text().replace("NAME=TI", 'NAME="My Titanium"')
    deck = deck.replace("MATERIAL=TI", 'material="My Titanium"').replace("=BLADE", '="The Blade"')
    deck = deck.replace("DISK, BLADE", 'DISK, "The Blade"').replace("*NODE\n", "*Node, nset=All\n")
    Path("fan.inp").write_text(deck.replace("*DENSITY", "*CONDUCTIVITY\n7.\n*DENSITY"))
    decks.main(["fan.inp", "--blade", "the blade", *NAMES[2:]])
    assert "left out: *HEADING, *CONDUCTIVITY, *BOUNDARY, and all steps" in capsys.readouterr().out
    text = Path("sector.inp").read_text()
    assert text.count("MY_TITANIUM") == 2
    assert '"' not in text
    blade = reader.read("blade_alone.inp")
    assert {label for _, label, _ in blade.elements} == set(mesh.blade_elements + 1)
    np.testing.assert_array_equal(blade.sets["ALL"], np.arange(1, 1 + len(mesh.nodes)))
