"""What stands in the way of a result file, in one line: nothing there, damage, a full disk."""

import os
import re
from pathlib import Path

from hpcrub.errors import HpcrubError, InputError, WriteError, reason

MAGIC = b"\x89HDF\r\n\x1a\n"


def require_file(path: Path) -> None:
    """Raises InputError unless a path leads to a file that begins as those of HDF5 do."""
    try:
        if not path.is_file():
            raise InputError(f"{path} is no file" if path.exists() else f"{path} does not exist")
        with open(path, "rb") as file:
            start = file.read(len(MAGIC))
    except OSError as error:
        raise InputError(f"cannot read {path}: {reason(error)}") from None
    if not start.startswith(MAGIC):
        raise InputError(f"{path} is not an HDF5 file" + (", it is empty" if not start else ""))


def unreadable(path: Path, error: OSError) -> str:
    """Why HDF5 cannot open a file."""
    if error.errno:
        return f"cannot open {path}: {reason(error)}"
    return f"{path} is " + (
        "truncated" if "truncated" in str(error) else f"damaged ({reason(error)})"
    )


def unwritable(error: Exception, path: Path) -> str:
    """Why HDF5 cannot write: it buries the system's own words, and MPI-IO drops them."""
    said = re.search(r"error message = '([^']*)'", str(error))
    if said:
        return said[1]
    try:
        with open(path, "r+b", buffering=0) as file:  # the same again, without MPI-IO
            first = file.read(1)
            file.seek(0)
            file.write(first)
            os.fsync(file)
    except OSError as again:
        return reason(again)
    return reason(error)


def require_kept(path: Path) -> None:
    """Raises HpcrubError when a closed result file has lost its name, or the disk its content."""
    try:
        with open(path, "rb") as file:
            os.fsync(file)  # a disk may fail after the last write, a server refuse it late
    except FileNotFoundError:
        raise HpcrubError(f"{path} was removed or moved while this job ran") from None
    except OSError as error:
        raise WriteError(f"cannot write {path}: {reason(error)}") from None
