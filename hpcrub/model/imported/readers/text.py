"""Text and tables as people and programs write them: packed or not, with many separators."""

import gzip
import math
from pathlib import Path
from typing import Any

import numpy as np

from hpcrub.errors import InputError, reading

PACKED = b"\x1f\x8b"  # the first bytes of a file of gzip
MOST_ROWS = 10_000_000  # of a table


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


def table(
    path: str | Path, most: int = MOST_ROWS, width: int = 0
) -> tuple[tuple[str, ...], np.ndarray]:
    """Read the names of a table's columns, () without any, and its numbers (rows, columns).

    Commas, semicolons (then with decimal commas, too) or blanks separate; exponents are written
    with E or D. The names may stand in the first line; empty lines and comments (# or *) are left
    out. most: rows that are allowed; width: number of columns, 0 for any.
    Raises InputError, which names the line.
    """
    names, rows = _rows(path, most)
    width = width or len(rows[0][1])
    for number, values in rows:
        if len(values) != width:
            raise InputError(
                f"{path}: line {number} has {len(values)} numbers, {width} numbers per line are "
                "expected"
            )
    return names, np.array([values for _, values in rows])


def columns(path: str | Path, names: tuple[str, ...], most: int = MOST_ROWS) -> np.ndarray:
    """Read the numbers (rows, columns) of a table that has exactly the columns `names`."""
    there, values = table(path, most)
    if sorted(there) != sorted(names):
        found = ", ".join(there) if there else "a line of numbers"
        raise InputError(f"{path}: {found} instead of the names {', '.join(names)}")
    if len(there) != values.shape[1]:
        raise InputError(f"{path}: {values.shape[1]} columns for {len(there)} names")
    return values[:, [there.index(name) for name in names]]


def numbers(path: str | Path) -> np.ndarray:
    """Read a list of numbers, one or several in a line, as a table (any,). Raises InputError."""
    return np.array([value for _, values in _rows(path, MOST_ROWS)[1] for value in values])


def _rows(path: Any, most: int) -> tuple[tuple[str, ...], list[tuple[int, list[float]]]]:
    """Names of the columns, numbers of the lines and the values in them. Raises InputError."""
    lines = [
        (number, line.rstrip(",; \t"))
        for number, line in enumerate(content(path).splitlines(), 1)
        if line.strip(",; \t") and line.lstrip()[0] not in "#*"
    ]
    if len(lines) > most + 1:  # one may have the names
        raise InputError(f"{path}: more than {most:,} rows, the most that are allowed here")
    separator = next((mark for mark in ";," if any(mark in line for _, line in lines)), None)
    rows = [
        (number, [cell.strip(' "') for cell in line.split(separator)]) for number, line in lines
    ]
    names = tuple(rows.pop(0)[1]) if rows and _number(rows[0][1][0], separator) is None else ()
    if not rows:
        raise InputError(f"{path}: there are no numbers in it")
    found = [(number, [_number(cell, separator) for cell in cells]) for number, cells in rows]
    for (number, cells), (_, values) in zip(rows, found, strict=True):
        if None in values:
            lost = cells[values.index(None)]
            raise InputError(f"{path}: line {number}: {lost[:40]!r} is not a number")
    return names, found


def _number(cell: str, separator: str | None) -> Any:
    """Number that a cell of a table holds; None if it holds none."""
    plain = cell.replace(",", ".") if separator == ";" else cell
    try:
        value = float(plain.upper().replace("D", "E"))
    except ValueError:
        return None
    return value if math.isfinite(value) and cell.isascii() and "_" not in cell else None
