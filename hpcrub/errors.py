"""Errors that end the program with one clear line and a distinct exit code."""

import contextlib
import re
from collections.abc import Iterator
from pathlib import Path

SYSTEM = r"error message = '([^']*)'"  # what HDF5 quotes of the operating system


class HpcrubError(Exception):
    """A failure that the user can act on; its message is one line."""

    exit_code = 1


class WriteError(HpcrubError):
    """A result file cannot be written any more.

    HDF5 would try again when the file is closed, and end the process with a crash: nothing must
    touch the file after this, not even the end of Python.
    """


class InputError(HpcrubError):
    """Bad input, found before any work starts."""

    exit_code = 2


class Interrupted(HpcrubError):
    """Stopped on request (Ctrl-C, SIGTERM, SIGUSR1); the study can be resumed."""

    exit_code = 75


def reason(error: BaseException) -> str:
    """One line of what went wrong, in the operating system's words where HDF5 quotes them."""
    if system := re.search(SYSTEM, str(error)):
        return system[1]
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    lines = str(error).splitlines() or [type(error).__name__]
    return lines[0]


def refuse_endless(path: str | Path) -> None:
    """Raise InputError for a name whose content may never end: that of a device or a pipe.

    Files of the kernel say that they are empty, and may wait for ever: empty files are refused.
    """
    place = Path(path)
    if place.exists() and not (place.is_file() or place.is_dir()):
        raise InputError(f"{path}: is neither a file nor a folder")
    if place.is_file() and place.stat().st_size == 0:
        raise InputError(f"{path}: is empty")


@contextlib.contextmanager
def reading(path: str | Path) -> Iterator[None]:
    """Around all work on a file of somebody else: whatever goes wrong in it is one InputError."""
    refuse_endless(path)
    try:
        yield
    except HpcrubError:
        raise
    except Exception as error:  # of any reader, for what nobody foresaw
        raise InputError(f"{path}: cannot be read ({reason(error)})") from None
