"""Tables of measured values in CSV files: numbers, with or without a line of names above."""

import csv
import itertools
from pathlib import Path
from typing import Any

import numpy as np

from hpcrub.config.text import counted
from hpcrub.errors import InputError, reading

MOST_ROWS = 1_000_000


def read(path: str | Path, most: int = MOST_ROWS) -> tuple[tuple[str, ...], np.ndarray]:
    """Read the names of the columns, () if the file has none, and the values (rows, columns).

    Semicolons (then with decimal commas, too), commas or blanks separate the columns; lines that
    are empty or begin with # are left out. Raises InputError, which names the line, when the file
    cannot be read or has more than `most` rows.
    """
    with reading(path):
        with open(path, "rb") as file:  # count first: reading takes far longer
            full = (line for line in file if line.strip() and not line.lstrip().startswith(b"#"))
            too_many = any(itertools.islice(full, most + 1, None))  # one may have the names
        text = "" if too_many else Path(path).read_text("utf-8-sig")
    if too_many:
        raise InputError(f"{path}: more than {most:,} rows, the most that are allowed here")
    lines = _cells(text)
    first = lines[0][0] if lines else 0
    names: tuple[str, ...] = ()
    if lines and _number(lines[0][1][0]) is None:
        names = tuple(lines.pop(0)[1])
    if not lines:
        raise InputError(f"{path}: an empty table")
    width = len(names or lines[0][1])
    for number, cells in lines:
        if len(cells) != width:
            there = counted(len(cells), "value")
            raise InputError(f"{path}: line {number} has {there}, line {first} has {width}")
    rows = [_row(path, number, cells) for number, cells in lines]
    return names, np.array(rows).reshape(len(rows), width)


def _cells(text: str) -> list[tuple[int, list[str]]]:
    """Numbers and cells of the lines that are not empty and no comments."""
    full = {
        number: line.strip().replace("\t", " ")
        for number, line in enumerate(text.splitlines(), 1)
        if line.strip(" \t,;") and not line.lstrip().startswith("#")
    }
    mark = next((mark for mark in ";," if any(mark in line for line in full.values())), " ")
    plain = (line.replace(",", ".") if mark == ";" else line for line in full.values())
    rows = zip(full, csv.reader(plain, delimiter=mark, skipinitialspace=True), strict=False)
    return [(k, [cell.strip() for cell in row if cell or mark != " "]) for k, row in rows]


def columns(path: str | Path, names: tuple[str, ...], most: int) -> np.ndarray:
    """Read the values (rows, columns) of a table that has exactly the columns `names`."""
    columns, values = read(path, most)
    if sorted(columns) != sorted(names):
        there = ", ".join(columns) if columns else "a line of numbers"
        raise InputError(f"{path}: {there} instead of the names {', '.join(names)}")
    return values[:, [columns.index(name) for name in names]]


def _row(path: Any, number: int, cells: Any) -> Any:
    values = [_number(cell) for cell in cells]
    for value, cell in zip(values, cells, strict=True):
        if value is None or not np.isfinite(value):
            raise InputError(f"{path}: line {number}: {cell[:40]!r} is not a number")
    return values


def _number(text: str) -> Any:
    try:
        return float(text) if text.isascii() and "_" not in text else None
    except ValueError:
        return None
