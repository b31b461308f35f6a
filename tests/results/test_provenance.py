"""Which program computed a result: a change in any room that takes part is seen."""

import shutil

from hpcrub.results import provenance
from tests.test_architecture import PACKAGE, ROOMS


def test_a_change_in_any_room_that_computes_is_another_program(tmp_path, monkeypatch):
    """`--resume` and `merge` did not see changes in `setup` and `runs`."""
    copy = tmp_path / "hpcrub"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(provenance, "PACKAGE", copy)
    rooms = {path.parent.name for path in copy.glob("*/__init__.py")}
    assert rooms == {*ROOMS} - {"errors"}
    read = provenance.program_text.__wrapped__
    for room in rooms:
        before, last = read(), sorted((copy / room).rglob("*.py"))[-1]
        last.write_text(last.read_text("utf-8") + "# changed\n", "utf-8")
        assert (read() != before) == (room not in provenance.SHOWING), room
