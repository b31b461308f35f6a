"""Errors that end the program with one clear line and a distinct exit code."""


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
    """One line of what went wrong."""
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    lines = str(error).splitlines() or [type(error).__name__]
    return lines[0]
