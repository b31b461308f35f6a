"""Compiled code that is kept: never that of others, and anew when it is damaged."""

import importlib.util
import os
import shutil
from types import SimpleNamespace

import numba
import pytest

from hpcrub.contact import jit
from tests.program import ROOT


@pytest.fixture
def small(tmp_path, monkeypatch):
    """Function: load and call a compiled function anew; whether it came from the cache."""
    source = tmp_path / "small.py"
    source.write_text(
        "from hpcrub.contact.jit import compiled\n@compiled\ndef f(x):\n    return x + 1.5\n"
    )
    monkeypatch.setattr(jit, "cache", SimpleNamespace(lost=""))

    def comes_from_cache():
        # every time: numba reads its settings anew when the environment has changed
        monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "cache"))
        spec = importlib.util.spec_from_file_location("small", source)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        assert module.f(1.0) == 2.5
        return sum(module.f.stats.cache_hits.values()) == 1

    return comes_from_cache


def test_a_damaged_cache_is_compiled_anew(tmp_path, small):
    """With any of its two files cut the code does not come from the cache, but the numbers are
    right, and the time after that it does again."""
    assert [small(), small()] == [False, True]
    for pattern in ("*.nbc", "*.nbi"):
        (entry,) = (tmp_path / "cache").rglob(pattern)
        content = entry.read_bytes()
        for harmed in (content[: len(content) // 2], b""):
            entry.write_bytes(harmed)
            assert [small(), small()] == [False, True], pattern


def test_a_full_disk_of_compiled_code_is_told(tmp_path, small, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("numba.core.caching.IndexDataCacheFile.save", full)
    assert not small()
    assert jit.cache.lost.endswith("No space left on device")


def cache_of(tmp_path, monkeypatch):
    """(folder of compiled code, why there is none) with this place for it."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(jit, "cache", SimpleNamespace(lost=""))
    return jit._cache_folder(), jit.cache.lost


def test_compiled_code_of_others_is_refused(tmp_path, monkeypatch):
    """numba executes what it finds: a folder into which others can write is no cache."""
    found, _ = cache_of(tmp_path, monkeypatch)
    assert os.stat(found).st_mode & 0o777 == 0o700
    os.chmod(found, 0o777)
    assert cache_of(tmp_path, monkeypatch) == ("", f"{found}: others may write there")
    os.chmod(found, 0o700)
    monkeypatch.setattr(os, "geteuid", lambda: 4711)
    assert cache_of(tmp_path, monkeypatch)[0] == ""


def test_a_copy_of_the_program_has_its_own_compiled_code(tmp_path, monkeypatch):
    """numba looks for code by the path and the time of its source: a mark that says that all is
    compiled must not be found by another clone, whose ranks would then all compile at once."""
    mine, _ = cache_of(tmp_path, monkeypatch)
    shutil.copytree(ROOT / "hpcrub", tmp_path / "clone" / "hpcrub")
    monkeypatch.setattr(jit, "__file__", str(tmp_path / "clone" / "hpcrub" / "contact" / "jit.py"))
    other, _ = cache_of(tmp_path, monkeypatch)
    assert other != mine
    os.utime(tmp_path / "clone" / "hpcrub" / "contact" / "kernel.py", (1, 1))
    assert cache_of(tmp_path, monkeypatch)[0] not in (mine, other)
