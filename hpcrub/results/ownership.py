"""Who may write an output file: one job at a time, over nothing of somebody else."""

import contextlib
import errno
import fcntl
import os
import stat
from pathlib import Path
from typing import IO

from hpcrub.errors import InputError, reason


def open_to_append(path: str | Path) -> IO[str]:
    """Open a text file to append to, made when it is not there.

    Never waits (for the other end of a FIFO), follows no link, and empties nothing, so that nothing
    that somebody else has under this name is harmed.

    Raises
    ------
    OSError
        It cannot be opened, or is no regular file.
    """

    def opener(name, flags):
        number = os.open(name, flags | os.O_NOFOLLOW | os.O_NONBLOCK, 0o666)
        if not stat.S_ISREG(os.fstat(number).st_mode):
            os.close(number)
            raise OSError(errno.EINVAL, "not a regular file", str(name))
        return number

    return open(path, "a", encoding="utf-8", opener=opener)


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
        except OSError as error:
            raise InputError(f"cannot write {path}: {_named(error)}") from None

    def _locked(self, path):
        """Lock the file; False when its name has meanwhile passed to another file."""
        self._file = open_to_append(self.path)
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


def _named(error):
    """What went wrong, with the name of the file that is in the way when it is no regular one."""
    return f"{error.filename} is {reason(error)}" if error.errno == errno.EINVAL else reason(error)


def move(path: str | Path, to: str | Path) -> None:
    """Give a whole file its name in one step, once it is on the disk. Raises OSError."""
    with open(path, "rb") as file:
        os.fsync(file.fileno())
    os.replace(path, to)
