"""One compilation policy for every numba kernel of the project.

Compiled code is cached in a folder named by the package's sources: numba itself only looks at the
file of the function it compiles, and would run stale code after a change in ``lanes.py``.

numba loads what it finds. A damaged entry would end the program, or run as other machine code, so
every entry carries a checksum here, and one that does not fit is compiled anew.
"""

import hashlib
import os
import pickle
from pathlib import Path
from types import SimpleNamespace

import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.serialize import dumps

from hpcrub.errors import reason

COMPILED_ROOMS = "contact", "model", "response", "statistics"  # all that numba compiles

# What `warmup` has to say of this process's compiled code:
# lost: why it cannot be kept, "" when it can; damaged: some that was kept was of no use
cache = SimpleNamespace(lost="", damaged=False)


def _cache_folder():
    """A folder for compiled code; "" where none can be written, and `cache.lost` says why."""
    digest = hashlib.sha256(numba.__version__.encode())
    package = Path(__file__).parents[1]
    for room in COMPILED_ROOMS:
        for source in sorted((package / room).glob("*.py")):
            digest.update(source.read_bytes())
    try:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
        folder = base / "hpcrub" / "jit" / digest.hexdigest()[:16]
        folder.mkdir(parents=True, exist_ok=True)
        if os.access(folder, os.W_OK):
            return str(folder)
        cache.lost = f"{folder}: no right to write there"
    except OSError as error:
        cache.lost = f"{error.filename}: {reason(error)}"
    except RuntimeError as error:  # no home at all
        cache.lost = reason(error)
    return ""


if not numba.config.CACHE_DIR:
    numba.config.CACHE_DIR = _cache_folder()


class _Entry(CompileResultCacheImpl):
    """Compiled code ↔ (checksum, bytes)."""

    def reduce(self, cres):
        content = dumps(super().reduce(cres))
        return hashlib.sha256(content).digest(), content

    def rebuild(self, target_context, payload):
        checksum, content = payload
        if hashlib.sha256(content).digest() != checksum:
            raise ValueError("damaged")
        return super().rebuild(target_context, pickle.loads(content))


class _Cache(FunctionCache):
    """numba's cache of one function, without which the program runs too."""

    _impl_class = _Entry

    def load_overload(self, sig, target_context):
        """The compiled code, None when there is none or it is damaged."""
        try:
            found = super().load_overload(sig, target_context)
        except Exception:  # whatever garbled bytes make of pickle
            cache.damaged = True
            return None
        return found if found is not None and found.signature.args == tuple(sig) else None

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


def compiled(function=None, *, inline=False):
    """``numba.njit`` with the project's options: NumPy division rules, no fast-math, cached."""

    def decorate(f):
        dispatcher = numba.njit(f, error_model="numpy", nogil=True, forceinline=inline)
        if numba.config.CACHE_DIR:
            dispatcher._cache = _Cache(f)
        return dispatcher

    return decorate if function is None else decorate(function)
