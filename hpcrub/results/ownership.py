"""Who may write an output file: one job at a time, over nothing of somebody else."""

import contextlib
import errno
import fcntl
import os
from pathlib import Path

from hpcrub.errors import InputError, reason


class Lock:
    """Keeps a second job off the same result file, until release or the end of the process.

    Not by the library `filelock`: that one leaves its file beside every result, and where a file
    system has no locks it makes do with the existence of the file, so that after kill -9 nobody
    could go on.
    """

    def __init__(self, path: str | Path) -> None:
        """Raises InputError when another job holds it or the folder cannot be used."""
        self.path = Path(f"{os.path.realpath(path)}.hpcrub-lock")
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            while not self._locked(path):
                self._file.close()
        except FileExistsError:
            raise InputError(f"cannot write {path}: {self.path.parent} is no folder") from None
        except OSError as error:
            raise InputError(f"cannot write {path}: {reason(error)}") from None

    def _locked(self, path):
        """Lock the file; False when its name has meanwhile passed to another file."""
        self._file = open(self.path, "a", encoding="utf-8")  # noqa: SIM115, closed by release
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

    def release(self) -> None:
        """Let others have the file; a second time does nothing."""
        if self._file.closed:
            return
        with contextlib.suppress(OSError):  # a folder that has become read-only: leave it there
            if self._is_named():
                self.path.unlink()
        self._file.close()


def reserve(path: str | Path, size: int, mode: str = "xb") -> None:
    """Take the place of a file of this size on its disk, now; mode: "xb" for a new file.

    HDF5, when it cannot write, leaves objects behind that crash the process. Raises OSError when
    there is no such place, as by a quota.
    """
    with open(path, mode) as file:
        if hasattr(os, "posix_fallocate"):
            os.posix_fallocate(file.fileno(), 0, size)


def move(path: str | Path, to: str | Path) -> None:
    """Give a whole file its name in one step, once it is on the disk. Raises OSError."""
    with open(path, "rb") as file:
        os.fsync(file.fileno())
    os.replace(path, to)
