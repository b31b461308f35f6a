"""Reasons in one line why a result file cannot be written or kept: a full disk, a lost name."""

import os
import re
from pathlib import Path

from hpcrub.errors import SYSTEM, HpcrubError, WriteError, reason


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
