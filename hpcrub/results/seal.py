"""Bytes of a result file ↔ a seal that shows whether they are those that were laid out.

HDF5 trusts what it reads: one changed byte outside the data can crash the library, or make it take
other bytes for the data and write over the rest of the file. Once a result file is laid out, only
data changes. Its first bytes, which HDF5 leaves to the program (the user block), therefore hold
one line that says where the data lie, and a checksum of all other bytes. Nothing opens a file
whose seal is broken. It guards against damage; it is no signature.
"""

import hashlib
import json
import os

from hpcrub.errors import InputError

BLOCK = 4096  # bytes, a length that HDF5 allows for a user block
MAGIC = b'{"program": "hpcrub"'
HDF5 = b"\x89HDF\r\n\x1a\n"
CHUNK = 1 << 20


def write(path, version, data):
    """Seal a file that is laid out.

    Args:
        path: a file that begins with `BLOCK` bytes to write to.
        version: of the program.
        data: (offset, length) of every stretch of bytes that may change.

    Raises:
        OSError: it cannot be written.
    """
    data = sorted((int(offset), int(length)) for offset, length in data)
    with open(path, "r+b") as file:
        size = os.fstat(file.fileno()).st_size
        about = {"program": "hpcrub", "version": version, "size": size, "data": data}
        line = json.dumps(about).encode()
        text = line + b"\n" + _checksum(file, line, data, size) + b"\n"
        if len(text) > BLOCK:
            raise ValueError(f"a seal of {len(text)} bytes")
        file.seek(0)
        file.write(text.ljust(BLOCK, b"\0"))


def is_ours(path):
    """Whether a file bears a seal, sound or not. Raises OSError when it cannot be read."""
    with open(path, "rb") as file:
        return file.read(len(MAGIC)) == MAGIC


def check(path, version):
    """Refuse a file that is not as this version of the program laid it out, its data aside.

    Raises:
        InputError: says what is wrong.
        OSError: it cannot be read.
    """
    with open(path, "rb") as file:
        block = file.read(BLOCK)
        if not block.startswith(MAGIC):
            raise InputError(f"{path} {_foreign(block)}")
        try:
            line, checksum, end = block.rstrip(b"\0").split(b"\n")
            about = json.loads(line)
            size, data, written_by = about["size"], about["data"], about["version"]
            stretches = [(offset, length) for offset, length in data]
            sound = end == b"" and type(size) is int and _is_ordered(stretches, size)
        except (ValueError, TypeError, KeyError, RecursionError):
            sound = False
        if not sound:
            raise InputError(f"{path} is damaged: its first bytes cannot be read")
        if written_by != version:
            raise InputError(f"{path} was written by hpcrub {written_by!s:.20}, this is {version}")
        found = os.fstat(file.fileno()).st_size
        if found < size:
            raise InputError(f"{path} is truncated: it has {found:,} of {size:,} bytes")
        if _checksum(file, line, stretches, size) != checksum:
            raise InputError(
                f"{path} is damaged: bytes outside its data are not those that were written"
            )


def _foreign(block):
    if block.startswith(HDF5):
        return "is not a result file of hpcrub, or one of an earlier state of it"
    return "is not an HDF5 file" + (", it is empty" if not block else "")


def _is_ordered(stretches, size):
    """Whether all are within the file behind the seal, one after the other."""
    at = BLOCK
    for offset, length in stretches:
        if type(offset) is not int or type(length) is not int or offset < at or length < 0:
            return False
        at = offset + length
    return at <= size


def _checksum(file, line, data, size):
    """Of the seal's line and of all bytes behind it that are not data, in hexadecimal digits."""
    digest = hashlib.sha256(line)
    at = BLOCK
    for offset, length in [*data, (size, 0)]:
        file.seek(at)
        while at < offset:
            part = file.read(min(CHUNK, offset - at))
            if not part:
                break
            digest.update(part)
            at += len(part)
        at = offset + length
    return digest.hexdigest().encode()
