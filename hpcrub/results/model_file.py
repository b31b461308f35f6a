"""Model files: arrays by name in HDF5, and checksums, which identify a file."""

import hashlib
import os
from pathlib import Path

from hpcrub.errors import InputError, reading, reason
from hpcrub.results.ownership import replacing
from hpcrub.results.storage import read_arrays, write_arrays

SUFFIXES = ".h5", ".hdf5"
MARK = "hpcrub_model"  # name of an array that every model file has


def read(path: str | Path) -> dict:
    """Arrays of a model file by name; text is a scalar of str. Raises InputError for damage."""
    with reading(path):
        return read_arrays(path)


def require_free(path: str | Path, overwrite: bool = False) -> None:
    """Raise InputError for a wrong suffix, and for a file that exists and must not be replaced."""
    if Path(path).suffix not in SUFFIXES:
        raise InputError(f"{path}: a model file ends with {', '.join(SUFFIXES)}")
    if not os.path.lexists(path):
        return
    if not overwrite:
        raise InputError(f"{path} exists: --overwrite replaces it")
    if os.path.getsize(path) and MARK not in read(path):
        raise InputError(f"{path} is no model file, and is not replaced; choose another output")


def write(path: str | Path, arrays: dict, overwrite: bool = False) -> None:
    """Write a model file; with `overwrite` it replaces one of that name in a single step.

    Raises InputError as `require_free` does, and when the file cannot be written.
    """
    require_free(path, overwrite)
    try:
        with replacing(path) as part:
            write_arrays(part, arrays)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({reason(error)})") from None


def checksum(path: str | Path) -> str:
    """SHA-256 of a file in hexadecimal digits. Raises InputError when it cannot be read."""
    with reading(path), open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def require(key: str, path: str | Path, sha256: str) -> None:
    """Raise InputError, which names the key, unless the file has this checksum."""
    if checksum(path) != sha256:
        raise InputError(f"{key}: {path} is not the file that this configuration was made of")
