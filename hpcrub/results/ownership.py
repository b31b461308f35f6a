"""Right to write an output file: one job at a time; what may go wrong with it, in one line."""

import contextlib
import errno
import fcntl
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hpcrub.errors import SYSTEM, HpcrubError, InputError, WriteError, reason

NO_LOCKS = errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP  # errors of a file system without locks


class Lock:
    """Keeps a second job off the same result file, until release or the end of the process.

    The library `filelock` does not do: it leaves its file beside every result. On a file system
    without locks the existence of this file is the lock; after kill -9 somebody has to delete it.
    """

    def __init__(self, path: str | Path) -> None:
        """Take the lock. Raises InputError when another job has it or the folder cannot be used."""
        self.path = Path(f"{os.path.realpath(path)}.hpcrub-lock")
        self._is_new = False
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            while not self._locked(path):
                self._file.close()
        except FileExistsError:
            raise InputError(f"cannot write {path}: {self.path.parent} is no folder") from None
        except OSError as error:
            raise InputError(f"cannot write {path}: {reason(error)}") from None

    def _locked(self, path: Any) -> Any:
        """Lock the file; returns False when its name has meanwhile passed to another file."""
        flags = os.O_RDWR | os.O_CREAT
        try:
            found = os.open(self.path, flags | os.O_EXCL, 0o666)
            self._is_new = True
        except FileExistsError:
            found = os.open(self.path, flags, 0o666)
        self._file = open(found, "r+b", buffering=0)  # noqa: SIM115, closed by release
        try:
            fcntl.lockf(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            if error.errno in (errno.EAGAIN, errno.EACCES):
                raise InputError(f"{path} is in use by another job") from None
            if not self._is_new:  # a file system without locks
                raise InputError(
                    f"{path} is in use by another job, or one was killed, which this file system "
                    f"without locks does not tell: if none runs, delete {self.path}"
                ) from None
        return self._is_named()

    def _is_named(self) -> Any:
        """Whether the name still belongs to the locked file."""
        try:
            return os.path.samestat(os.fstat(self._file.fileno()), os.stat(self.path))
        except FileNotFoundError:
            return False

    def release(self) -> None:
        """Release the lock and remove its file; a second call does nothing."""
        if self._file.closed:
            return
        with contextlib.suppress(OSError):  # in a folder that is read-only by now the file stays
            if self._is_named():
                self.path.unlink()
        self._file.close()


def reserve(path: str | Path, size: int, mode: str = "xb") -> None:
    """Allocate the space of a file of this size on its disk; mode: "xb" for a new file.

    HDF5, when it cannot write, leaves objects behind that crash the process. Raises OSError when
    the disk or a quota leaves no such space.
    """
    with open(path, mode) as file:
        if hasattr(os, "posix_fallocate"):
            os.posix_fallocate(file.fileno(), 0, size)


def move(path: str | Path, to: str | Path) -> None:
    """Rename a finished file in one step, once its content is on the disk. Raises OSError."""
    with open(path, "rb") as file:
        os.fsync(file.fileno())
    os.replace(path, to)


def part_of(path: str | Path) -> Path:
    """Name of a new file beside `path` until it replaces it; a kill may leave such a file."""
    return Path(f"{path}.hpcrub-part")


@contextlib.contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Yield a name beside `path` for a new file, which replaces it once the block has ended.

    After an error nothing is left of the new file. Raises OSError.
    """
    part = part_of(path)
    try:
        part.parent.mkdir(parents=True, exist_ok=True)
        part.unlink(missing_ok=True)  # left by a job that was killed
        yield part
        move(part, path)
    except BaseException:
        with contextlib.suppress(OSError):
            part.unlink(missing_ok=True)
        raise


def unwritable(error: Exception, path: Path) -> str:
    """Return why HDF5 cannot write, also where MPI-IO drops the operating system's words."""
    if re.search(SYSTEM, str(error)):
        return reason(error)
    try:
        with open(path, "r+b", buffering=0) as file:  # write again, without MPI-IO
            first = file.read(1)
            file.seek(0)
            file.write(first)
            os.fsync(file)
    except OSError as again:
        return reason(again)
    return reason(error)


def require_kept(path: Path) -> None:
    """Raise HpcrubError when a closed result file is gone, or the disk has lost its content."""
    try:
        with open(path, "rb") as file:
            os.fsync(file)  # a disk may fail after the last write, a server refuse it late
    except FileNotFoundError:
        raise HpcrubError(f"{path} was removed or moved while this job ran") from None
    except OSError as error:
        raise WriteError(f"cannot write {path}: {reason(error)}") from None
