"""Errors that end the program with one clear line and a distinct exit code."""

import contextlib
import os
import re
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TextIO

SYSTEM = r"error message = '([^']*)'"  # the operating system's words as HDF5 quotes them


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
    """Return the cause of an error in one line, in the operating system's words if it has them."""
    if "unable to lock file" in str(error):  # HDF5's words
        return "another program has it open"
    if system := re.search(SYSTEM, str(error)):
        return system[1]
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    return (str(error).splitlines() or [type(error).__name__])[0]


def refuse_endless(path: str | Path) -> None:
    """Raise InputError for a device or a pipe, whose content may never end.

    Empty files are refused, too: files of the kernel have size zero, and reading them may block.
    """
    # methods of Path raise OSError for a name that is too long, or in a folder of somebody else
    if os.path.exists(path) and not (os.path.isfile(path) or os.path.isdir(path)):
        raise InputError(f"{path}: is neither a file nor a folder")
    if os.path.isfile(path) and os.path.getsize(path) == 0:
        raise InputError(f"{path}: is empty")


def complain(line: str) -> None:
    """Print a line to standard error; where that cannot be written, nobody can be told.

    Its end is written with it, so that what mpirun says of an abort begins a line of its own.
    """
    try:
        print(f"{line}\n", end="", file=sys.stderr, flush=True)
    except OSError:
        _leave_off(sys.stderr)


def flush() -> None:
    """Flush standard output."""
    try:
        if sys.stdout:
            sys.stdout.flush()
    except OSError as error:
        print_no_more(error)


def print_no_more(error: OSError) -> None:
    """Leave off printing to standard output, which has failed, and say why.

    A reader that has left, as `head` does, is no failure.
    """
    _leave_off(sys.stdout)
    if not isinstance(error, BrokenPipeError):
        complain(f"hpcrub: nothing is printed any more: {reason(error)}")


def _leave_off(stream: TextIO) -> None:
    """Send what a stream still holds, and what is printed to it from now on, to nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


@contextlib.contextmanager
def reading(path: str | Path) -> Iterator[None]:
    """Turn whatever goes wrong in reading a user's file into an InputError that names the file.

    Warnings of libraries are not shown: what cannot be used is refused in one line.
    """
    refuse_endless(path)
    try:
        with warnings.catch_warnings():
            if not sys.warnoptions:  # as `python -W default` sets them
                warnings.simplefilter("ignore")
            yield
    except HpcrubError:
        raise
    except Exception as error:  # a reader may raise anything on damage that nobody foresaw
        raise InputError(f"{path}: cannot be read ({reason(error)})") from None
