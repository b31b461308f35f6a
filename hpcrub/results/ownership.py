"""Names of result files → who may write there: one job at a time, over nothing of somebody else."""

import contextlib
import errno
import fcntl
import os
import shutil
import stat
from pathlib import Path

from hpcrub.errors import HpcrubError, InputError, reason
from hpcrub.results import seal


class Lock:
    """Keeps a second job off the same result file, until release or the end of the process."""

    def __init__(self, path):
        """Raises InputError when another job holds it or the folder cannot be used."""
        self.path = Path(f"{os.path.realpath(path)}.hpcrub-lock")
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            while not self._locked(path):
                self._file.close()
        except OSError as error:
            raise InputError(f"cannot write {path}: {reason(error)}") from None

    def _locked(self, path):
        """Lock the file; False when its name has meanwhile passed to another file."""
        # neither emptied nor followed: nothing that somebody else has there is harmed
        opener = lambda name, flags: os.open(name, flags | os.O_NOFOLLOW, 0o666)  # noqa: E731
        self._file = open(self.path, "a", opener=opener)  # noqa: SIM115, stays open
        try:
            fcntl.lockf(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            if error.errno in (errno.EAGAIN, errno.EACCES):
                raise InputError(f"{path} is in use by another job") from None
            return True  # a file system without locks: go on without
        return self._is_named()

    def _is_named(self):
        """Whether the name is still that of the locked file."""
        try:
            return os.path.samestat(os.fstat(self._file.fileno()), os.stat(self.path))
        except FileNotFoundError:
            return False

    def release(self):
        """Let others have the file; a second time does nothing."""
        if self._file.closed:
            return
        with contextlib.suppress(OSError):  # a folder that has become read-only: leave it there
            if self._is_named():
                self.path.unlink()
        self._file.close()


def refuse_foreign(path):
    """Raises InputError unless a file can be replaced: none yet, an empty one, a result of ours."""
    path = Path(os.path.realpath(path))
    try:
        kind = path.stat().st_mode if os.path.lexists(path) else None
        if kind is None or (stat.S_ISREG(kind) and (not path.stat().st_size or seal.is_ours(path))):
            return
    except OSError as error:
        raise InputError(f"cannot replace {path}: {reason(error)}") from None
    raise InputError(
        f"{path} is not a result file of this hpcrub and is not replaced; "
        "move it away, or choose another output"
    )


def move(path, to):
    """Give a whole file its name in one step, once it is on the disk. Raises OSError."""
    with open(path, "rb") as file:
        os.fsync(file.fileno())
    os.replace(path, to)


def put_back(kept, path):
    """Copy an open file to its name, if somebody has removed or moved it, and close it.

    kept: descriptor to read it. Returns whether it was gone. Raises HpcrubError when another file
    has taken the name, or it cannot be written.
    """
    with open(kept, "rb") as file:
        try:
            there = os.stat(path) if os.path.lexists(path) else None
            if there and os.path.samestat(there, os.fstat(file.fileno())):
                return False
            target = _free_name(path) if there else path
            target.parent.mkdir(parents=True, exist_ok=True)
            with open(target, "xb") as copy:
                shutil.copyfileobj(file, copy)
                os.fsync(copy.fileno())
        except OSError as error:
            raise HpcrubError(f"cannot write {path}: {reason(error)}") from None
    if there:
        raise HpcrubError(
            f"{path} was replaced by another file while this job ran; "
            f"what it has computed is in {target}"
        )
    return True


def _free_name(path):
    """Where to rescue a file to: NAME.rescued.h5, NAME.rescued-2.h5 and so on."""
    names = (Path(f"{path}.rescued{n}.h5") for n in ("", *(f"-{i}" for i in range(2, 1000))))
    return next(name for name in names if not os.path.lexists(name))
