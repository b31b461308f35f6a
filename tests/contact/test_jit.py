"""Compiled code that is kept is that of these sources, and of laws from elsewhere as they are."""

import shutil

import numba

from hpcrub.contact import jit
from hpcrub.contact.lanes import aligned_zeros
from hpcrub.contact.laws.rigid import Rigid
from tests.contact.spring_law import Spring
from tests.program import ROOT


def test_a_copy_of_the_program_and_a_change_have_their_own_compiled_code(tmp_path, monkeypatch):
    """numba looks at the file of the function alone: a change in ``lanes.py`` it would not see."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    folders = [jit._cache_folder()]
    shutil.copytree(ROOT / "hpcrub", tmp_path / "clone" / "hpcrub")
    monkeypatch.setattr(jit, "__file__", str(tmp_path / "clone" / "hpcrub" / "contact" / "jit.py"))
    folders.append(jit._cache_folder())
    with (tmp_path / "clone/hpcrub/contact/laws/rigid.py").open("a") as file:
        file.write("# changed\n")
    folders.append(jit._cache_folder())
    assert len(set(folders)) == 3


def test_no_folder_for_compiled_code_is_no_error(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert jit._cache_folder() == ""


def test_the_key_of_compiled_code_holds_the_source_of_a_law_from_elsewhere():
    """Else a law that was changed would go on as it was."""
    own, rigid = Spring(aligned_zeros((12, 8))), Rigid(*(aligned_zeros((12, 8)) for _ in range(3)))
    (spring, nothing) = (jit._foreign_sources((numba.typeof(law),)) for law in (own, rigid))
    assert spring == {(ROOT / "tests/contact/spring_law.py").read_text(encoding="utf-8")}
    assert nothing == set()
