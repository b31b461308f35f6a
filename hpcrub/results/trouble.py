"""What stands in the way of a result file, in one line: damage, a full disk, a lost name."""

import os
import re
from pathlib import Path

from hpcrub.errors import SYSTEM, HpcrubError, WriteError, reason


def unwritable(error: Exception, path: Path) -> str:
    """Why HDF5 cannot write, also where MPI-IO drops the system's words."""
    if re.search(SYSTEM, str(error)):
        return reason(error)
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
