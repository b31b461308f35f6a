"""Model files: arrays by name in HDF5 or NPZ, and what identifies a file."""

import hashlib
import os
import zipfile
from pathlib import Path

import numpy as np

from hpcrub.errors import InputError, reason
from hpcrub.results.storage import read_arrays, write_arrays

SUFFIXES = ".h5", ".hdf5", ".npz"


def read(path: str | Path) -> dict:
    """Arrays of a model file by name; text is a scalar of str.

    Raises InputError when it cannot be read.
    """
    if os.path.isdir(path):
        raise InputError(f"{path}: a folder, and no model file")
    try:
        if Path(path).suffix == ".npz":
            with np.load(path, allow_pickle=False) as file:
                return {name: file[name] for name in file.files}
        return read_arrays(path)
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        raise InputError(f"{path}: no model file that can be read ({reason(error)})") from None


def write(path: str | Path, arrays: dict) -> None:
    """Write a model file, replacing one of that name in a single step.

    Raises InputError when its name has no known ending or it cannot be written.
    """
    path = Path(path)
    if path.suffix not in SUFFIXES:
        raise InputError(f"{path}: a model file ends with {', '.join(SUFFIXES)}")
    part = path.with_name(path.name + ".hpcrub-part")
    try:
        part.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix == ".npz":
            with open(part, "wb") as file:
                np.savez_compressed(file, **arrays)
        else:
            write_arrays(part, arrays)
        os.replace(part, path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({reason(error)})") from None


def checksum(path: str | Path) -> str:
    """SHA-256 of a file in hexadecimal digits. Raises InputError when it cannot be read."""
    try:
        with open(path, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({reason(error)})") from None


def require(key: str, path: str | Path, sha256: str) -> None:
    """Raise InputError, which names the key, unless a file is the one with this checksum."""
    if checksum(path) != sha256:
        raise InputError(f"{key}: {path} is not the file that this configuration was made of")
