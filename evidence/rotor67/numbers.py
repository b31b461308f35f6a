"""The benchmark's numbers as a CSV file, and how another program's compare.

`python -m evidence.rotor67.numbers YOURS.csv` compares a file of the same columns; it may hold some
of the rows only, and needs neither `low` nor `high`.
"""

import csv
import math
import sys
from pathlib import Path
from typing import NamedTuple

TABLE = Path("inputs/rotor67/numbers.csv")
NONE = float("nan")


class Number(NamedTuple):
    """One number of the benchmark; low and high bound what repeats or intervals say of it."""

    quantity: str
    at: str
    value: float
    unit: str
    low: float = NONE
    high: float = NONE


def read(path: Path) -> dict:
    """Numbers of a CSV file by (quantity, at)."""
    found = {}
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            key = row["quantity"], row["at"]
            bounds = (float(row.get(name) or NONE) for name in ("low", "high"))
            found[key] = Number(*key, float(row["value"]), row.get("unit", ""), *bounds)
    return found


def write(path: Path, numbers: list[Number]) -> None:
    """Write numbers; those of other (quantity, at) that the file has are kept."""
    found = read(path) if path.exists() else {}
    found |= {number[:2]: number for number in numbers}
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(Number._fields)
        for row in found.values():
            cells = ("" if x != x else f"{x:.6g}" for x in (row.value, row.low, row.high))
            value, *bounds = cells
            writer.writerow([*row[:2], value, row.unit, *bounds])


def compare(theirs: dict, ours: dict) -> list[tuple]:
    """Rows (quantity, at, theirs, ours, difference in %, within our bounds) of common numbers.

    Numbers with bounds of their own, as those of fewer fans, are within where these meet ours.
    """
    rows = []
    for key, number in theirs.items():
        if key in ours:
            mine = ours[key]
            low, high = _bounds(mine)
            least, most = _bounds(number) if _bounded(number) else (number.value, number.value)
            within = low <= most and least <= high if _bounded(mine) else ""
            off = 100 * (number.value / mine.value - 1) if mine.value else NONE
            rows.append((*key, number.value, mine.value, off, within))
    return rows


def _bounded(number):
    return not (math.isnan(number.low) and math.isnan(number.high))


def _bounds(number):
    """Low and high; infinite where too few fans know an end."""
    low = -math.inf if math.isnan(number.low) else number.low
    return low, math.inf if math.isnan(number.high) else number.high


def show(rows: list[tuple]) -> None:
    """Print what `compare` found."""
    for quantity, at, value, mine, off, within in rows:
        verdict = {"": "", True: "  within", False: "  outside"}[within]
        difference = "" if math.isnan(off) else f", {off:+.2f} %"
        print(f"{quantity}, {at}: {value:.6g} beside {mine:.6g}{difference}{verdict}")


if __name__ == "__main__":
    show(compare(read(Path(sys.argv[1])), read(TABLE)))
