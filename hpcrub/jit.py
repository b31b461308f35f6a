"""One compilation policy for every numba kernel of the project.

Compiled code is cached in a folder named by the package's sources: numba itself only looks at the
file of the function it compiles, and would run stale code after a change in ``lanes.py``.
"""

import hashlib
import os
from pathlib import Path

import numba


def _cache_folder():
    """A folder for compiled code, or None where none can be written."""
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.read_bytes())
    try:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
        folder = base / "hpcrub" / "jit" / digest.hexdigest()[:16]
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):  # not writable, or no home at all
        return None
    return str(folder) if os.access(folder, os.W_OK) else None


if not numba.config.CACHE_DIR:
    numba.config.CACHE_DIR = _cache_folder() or ""


def compiled(function=None, *, inline=False):
    """``numba.njit`` with the project's options: NumPy division rules, no fast-math, cached."""

    def decorate(f):
        return numba.njit(
            f,
            cache=bool(numba.config.CACHE_DIR),
            error_model="numpy",
            nogil=True,
            forceinline=inline,
        )

    return decorate if function is None else decorate(function)
