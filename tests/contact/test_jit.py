"""Compiled code: kept by the sources that it was made of, mended where it is damaged."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np
import pytest
from numba.core.caching import IndexDataCacheFile

from hpcrub.contact import jit
from hpcrub.contact.groups import passed_by_reference
from tests.program import ROOT


@pytest.mark.parametrize("variable", ["XDG_CACHE_HOME", "NUMBA_CACHE_DIR"])
def test_a_copy_of_the_program_and_a_change_have_their_own_compiled_code(
    variable, tmp_path, monkeypatch
):
    """numba looks at the file of the function alone: a change in ``lanes.py`` it would not see."""
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv(variable, str(tmp_path))
    folders = [jit._cache_folder()]
    shutil.copytree(ROOT / "hpcrub", tmp_path / "clone" / "hpcrub")
    monkeypatch.setattr(jit, "__file__", str(tmp_path / "clone" / "hpcrub" / "contact" / "jit.py"))
    folders.append(jit._cache_folder())
    with (tmp_path / "clone/hpcrub/contact/laws/planar.py").open("a") as file:
        file.write("# changed\n")
    folders.append(jit._cache_folder())
    assert len(set(folders)) == 3
    assert all(Path(folder).is_relative_to(tmp_path / "hpcrub") for folder in folders)


def test_no_folder_for_compiled_code_is_no_error(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert jit._cache_folder() == ""


PROGRAM = """\
import sys
from hpcrub.contact.jit import compiled
if sys.argv[1] == "own":
    from mine import Own as Kind
else:
    Kind = tuple

@compiled
def first(values):
    return values[0] + 1.0

assert first(Kind((2.0,))) == 3.0
"""


def started(tmp_path, who):
    """A program that compiles a function; returns the files of its compiled code."""
    home = os.environ | {"XDG_CACHE_HOME": str(tmp_path), "PYTHONPATH": str(ROOT)}
    home.pop("NUMBA_CACHE_DIR", None)
    (tmp_path / "program.py").write_text(PROGRAM)
    subprocess.run([sys.executable, tmp_path / "program.py", who], env=home, check=True)
    return {file: file.read_bytes() for file in (tmp_path / "hpcrub").rglob("*.nb?")}


@pytest.mark.long
def test_code_compiled_for_a_law_from_elsewhere_does_not_bar_who_lacks_that_law(tmp_path):
    mine = tmp_path / "mine.py"
    mine.write_text(
        "from typing import NamedTuple\n\n\nclass Base(NamedTuple):\n    value: float\n\n\n"
        "def Own(values):\n    return Base(*values)\n"
    )
    started(tmp_path, "own")
    mine.unlink()
    kept = started(tmp_path, "other")
    assert sum(file.suffix == ".nbi" for file in kept) == 2


def test_programs_that_compile_at_the_same_time_keep_the_code_of_each(tmp_path, monkeypatch):
    """Each has read the list of what is kept before the other one writes."""

    def half(x):
        return x / 2

    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    with monkeypatch.context() as read_before:
        read_before.setattr(IndexDataCacheFile, "_load_index", lambda self: {})
        for x in (3, 3.0):
            assert jit.compiled(half)(x) == 1.5
    later = jit.compiled(half)
    assert later(3) == later(3.0) == 1.5
    assert later.stats.cache_hits.total() == 2


@jit.compiled(inner=True)
def next_of(n):
    return n + 1


@jit.compiled
def counted(n):
    last = 0
    for _ in range(n):
        last = next_of(last)
    return last


def test_a_function_is_compiled_once_for_a_number_that_begins_with_zero():
    """By itself numba compiles it for the value 0 as well, and so all that it calls."""
    assert counted(3) == 3
    counted.recompile()  # code that is loaded from the cache asks for no `next_of`
    assert len(next_of.signatures) == 1


def test_code_of_an_inner_function_is_kept_for_callers_that_come_later(tmp_path, monkeypatch):
    def third(x):
        return x / 3

    def caller(inner, added):
        return jit.compiled(lambda x: inner(x) + added)

    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    for n_kept in (0, 1):
        inner = jit.compiled(third, inner=True)
        assert caller(inner, n_kept)(6.0) == 2.0 + n_kept
        assert inner.stats.cache_hits.total() == n_kept


class Halving(NamedTuple):
    """A law with a helper of its own."""

    share: float

    @staticmethod
    @jit.compiled(inner=True)
    def half_of_it(law, x):
        return 0.5 * law.share * x

    @staticmethod
    @jit.compiled(inner=True)
    def forces(law, x):
        return law.half_of_it(law, x) + 1.0


def test_every_compiled_method_of_a_law_can_be_called_by_any_name():
    @jit.compiled
    def called(law, x):
        return law.forces(law, x)

    assert called(Halving(4.0), 10.0) == 21.0


class Inside(NamedTuple):
    """A group within a group."""

    values: np.ndarray


@passed_by_reference
class Group(NamedTuple):
    """A group with an array, a group and nothing."""

    values: np.ndarray
    inside: Inside
    nothing: None


@jit.compiled(inner=True)
def total(group):
    return group.values[0] + group.inside.values[0]


@jit.compiled
def grown(group):
    """Add to an array of a group and of the group within; returns the sum of both."""
    group.values[0] += 1.0
    kept = group.inside.values
    kept[0] += 10.0
    return total(group) if group.nothing is None else -1.0


def test_a_group_goes_by_reference_and_its_arrays_are_let_go():
    arrays = np.zeros(2), np.zeros(2)
    held = [sys.getrefcount(array) for array in arrays]
    for n in range(1, 4):
        assert grown(Group(arrays[0], Inside(arrays[1]), None)) == 11.0 * n
    assert (arrays[0][0], arrays[1][0]) == (3.0, 30.0)
    assert [sys.getrefcount(array) for array in arrays] == held


class Foreign(NamedTuple):
    """A tuple of somebody who knows nothing of contact laws, with fields of the same names."""

    wear: np.ndarray
    predict: float


def test_fields_of_other_named_tuples_are_what_they_were():
    """Also counted references to arrays: without them the array is freed too early."""

    @numba.njit
    def summed(n):
        mine = Foreign(np.arange(n), 0.5)
        kept = mine.wear
        return kept, mine.predict + kept.sum()

    for _ in range(100):
        kept, value = summed(1000)
        np.testing.assert_array_equal(kept, np.arange(1000))
        assert value == 499500.5


@pytest.mark.long
def test_damaged_compiled_code_is_compiled_anew_and_mended(tmp_path):
    before = started(tmp_path, "other")
    for kind, share in (("nbc", 0.5), ("nbi", 0.0)):
        for file, content in before.items():
            if file.suffix == f".{kind}":
                file.write_bytes(content[: int(share * len(content))])
        after = started(tmp_path, "other")
        assert before.keys() == after.keys()
        assert all(len(content) > 0.9 * len(before[file]) for file, content in after.items())
