"""Text of files as programs write them: packed or not, with many separators and exponents."""

import gzip
from pathlib import Path
from typing import Any

import numpy as np

from hpcrub.errors import InputError, reading

PACKED = b"\x1f\x8b"  # the first bytes of a file of gzip


def existing(path: str | Path) -> Path:
    """Return the path of a file, or that of NAME.gz if only this is there."""
    packed = Path(f"{path}.gz")
    return packed if packed.is_file() and not Path(path).exists() else Path(path)


def content(path: str | Path) -> str:
    """Read a text file, packed by gzip or not. Raises InputError."""
    path = existing(path)
    with reading(path):
        return unpacked(path).decode("utf-8-sig", errors="replace")


def unpacked(path: Path) -> bytes:
    """Read the bytes of a file, packed by gzip or not."""
    data = path.read_bytes()
    return gzip.decompress(data) if data.startswith(PACKED) else data


def table(path: str | Path, columns: int = 0) -> np.ndarray:
    """Read the numbers of a table, a row in each line, (rows, columns).

    Commas, semicolons (then with decimal commas, too) or blanks separate; exponents are written
    with E or D. A first line of names, empty lines and comments (# or *) are left out.
    columns: their number, 0 for any. Raises InputError, which names the line.
    """
    rows = _rows(path)
    width = columns or len(rows[0][1])
    for number, words in rows:
        if len(words) != width:
            raise InputError(
                f"{path}: line {number} has {len(words)} numbers, {width} numbers per line are "
                "expected"
            )
    return np.array([words for _, words in rows], dtype=float)


def numbers(path: str | Path) -> np.ndarray:
    """Read a list of numbers, one or several in a line, as a `table` (any,). Raises InputError."""
    return np.array([word for _, words in _rows(path) for word in words], dtype=float)


def _rows(path: Any) -> list[tuple[int, list[str]]]:
    """Numbers of the lines and the words in them, which are numbers. Raises InputError."""
    lines = [
        (number, line.rstrip(",; \t"))
        for number, line in enumerate(content(path).splitlines(), 1)
        if line.strip() and line.lstrip()[0] not in "#*"
    ]
    separator = next((mark for mark in ";," if any(mark in line for _, line in lines)), None)
    rows = [(number, _plain(line, separator).split(separator)) for number, line in lines]
    if rows and not _is_number(rows[0][1][0]):
        rows = rows[1:]
    if not rows:
        raise InputError(f"{path}: there are no numbers in it")
    for number, words in rows:
        if lost := [word for word in words if not _is_number(word)]:
            raise InputError(f"{path}: line {number}: {lost[0].strip()[:40]!r} is not a number")
    return rows


def _plain(line: str, separator: Any) -> str:
    """Line with decimal points and exponents E; the D of words such as NODE changes as well."""
    line = line.replace(",", ".") if separator == ";" else line
    return line.replace("D", "E").replace("d", "e")


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
