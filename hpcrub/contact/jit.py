"""One compilation policy for every numba kernel of the project.

Compiled code is cached in a folder named by the package's place and sources: numba itself only
looks at the file of the function it compiles, and would run stale code after a change in
``lanes.py``. It also takes a file for another one when its path or its time has changed: with both
in the name, a folder that is complete holds all that this program will look for.

numba executes what it finds, so nobody else may be able to write there.
"""

import hashlib
import os
import stat
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numba
from numba.core.caching import FunctionCache

from hpcrub.errors import reason

COMPILED_ROOMS = "contact", "model", "response"  # all that numba compiles
OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH

cache = SimpleNamespace(lost="")  # why this process's compiled code cannot be kept, "" when it can


def _cache_folder() -> str:
    """A folder for compiled code; "" where there can be none, and `cache.lost` says why."""
    try:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
        for folder in (base / "hpcrub", base / "hpcrub" / "jit"):
            _make_ours(folder)
        folder = base / "hpcrub" / "jit" / _name()
        folder.mkdir(mode=0o700, exist_ok=True)
        if not os.access(folder, os.W_OK):
            cache.lost = f"{folder}: no right to write there"
        elif not _is_ours(folder):
            cache.lost = f"{folder}: others may write there"
        else:
            return str(folder)
    except OSError as error:
        cache.lost = f"{error.filename}: {reason(error)}"
    except RuntimeError as error:  # no home at all
        cache.lost = reason(error)
    return ""


def _name():
    """Name of the cache of this copy of the sources: whatever numba asks for, and all texts."""
    digest = hashlib.sha256(numba.__version__.encode())
    package = Path(os.path.abspath(__file__)).parents[1]
    for room in COMPILED_ROOMS:
        for source in sorted((package / room).glob("*.py")):
            digest.update(f"{source} {source.stat().st_mtime_ns}\n".encode())
            digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def _make_ours(folder):
    """A folder into which only we can put others. Earlier versions left it to the umask."""
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    if folder.stat().st_uid == os.geteuid():
        folder.chmod(stat.S_IMODE(folder.stat().st_mode) & ~OTHERS_WRITE)


def _is_ours(folder):
    """Whether nobody else can write into a folder, or put another one in its place."""
    found = [path.stat() for path in (folder, *list(folder.parents)[:2])]
    return all(f.st_uid == os.geteuid() and not f.st_mode & OTHERS_WRITE for f in found)


if not numba.config.CACHE_DIR:  # type: ignore[attr-defined]
    numba.config.CACHE_DIR = _cache_folder()  # type: ignore[attr-defined]


class _Cache(FunctionCache):
    """numba's cache of one function, without which the program runs too."""

    def load_overload(self, sig, target_context):
        """The compiled code, None when there is none or it is damaged."""
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # whatever garbled bytes make of pickle
            return None

    def save_overload(self, sig, data):
        """Keep compiled code, when the disk lets us."""
        try:
            super().save_overload(sig, data)
        except Exception:  # a damaged index, which is read before it is extended
            try:
                self.flush()
                super().save_overload(sig, data)
            except OSError as error:
                cache.lost = f"{numba.config.CACHE_DIR}: {reason(error)}"


def compiled(
    function: Callable | None = None, *, inline: bool = False, allocates: bool = True
) -> Any:
    """``numba.njit`` with the project's options: NumPy division rules, no fast-math, cached.

    Parameters
    ----------
    function : Callable, optional
        To compile; without it a decorator is returned.
    inline : bool, optional
        Whether it becomes part of every function that calls it.
    allocates : bool, optional
        Whether it makes arrays. One that does not need not count the references to its arguments,
        which costs more than the work where it is called in every step with many arrays.

    Returns
    -------
    Any
        Dispatcher, whose ``py_func`` is the function in plain Python, or the decorator.
    """

    def decorate(f):
        dispatcher = numba.njit(
            f, error_model="numpy", nogil=True, forceinline=inline, _nrt=allocates
        )
        if numba.config.CACHE_DIR:
            dispatcher._cache = _Cache(f)
        return dispatcher

    return decorate if function is None else decorate(function)
