"""Nodes, elements and node sets of keyword decks, as CalculiX and Abaqus read them."""

from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hpcrub.errors import InputError
from hpcrub.model.imported.readers.text import content

MOST_NUMBERS = 10_000_000  # numbers that a line of a set may generate


class Deck(NamedTuple):
    """The mesh of a deck, with the numbers of the deck; names are in capitals."""

    node: np.ndarray  # (n,) numbers, increasing
    place: np.ndarray  # (n, 3) coordinates
    sets: dict  # {name: node numbers}
    elements: list  # (type, label, corner numbers) in the order of the deck


def read(path: str | Path) -> Deck:
    """Read a deck with its included files. Raises InputError: unreadable, or without nodes."""
    nodes: dict = {}
    sets: dict = defaultdict(set)
    elements: list = []
    for keyword, options, lines in _blocks(Path(path)):
        try:
            if keyword == "NODE":
                new = _nodes(lines)
                nodes |= new
                sets[options.get("NSET")].update(new)
            elif keyword == "NSET":
                sets[options.get("NSET")].update(_set(lines, sets, "GENERATE" in options))
            elif keyword == "ELEMENT":
                elements += _elements(options.get("TYPE", ""), lines)
        except (ValueError, IndexError):
            raise InputError(f"{path}: *{keyword} holds a line that cannot be read") from None
    if not nodes:
        raise InputError(f"{path}: no nodes (*NODE)")
    number = np.array(sorted(nodes), dtype=np.int64)
    unique = {name: np.array(sorted(numbers)) for name, numbers in sets.items() if name}
    return Deck(number, np.array([nodes[k] for k in number]), unique, elements)


def listed(lists: dict, name: str, what: str) -> np.ndarray:
    """Node numbers of the list `name`; the keys of `lists` are in capitals.

    what: f"{file}: there is no node set". Raises InputError, which names all lists of the file.
    """
    if name.upper() not in lists:
        there = ", ".join(sorted(lists)) or "none"
        raise InputError(f"{what} {name}; there are {there}")
    return lists[name.upper()]


def _blocks(path: Any) -> Iterator[Any]:
    """Yield (keyword, options, data lines) of every block of a deck."""
    keyword, options, lines = None, {}, []
    for line in (*_lines(path), "*"):  # "*" ends the last block
        if not line.startswith("*"):
            lines.append(line)
            continue
        if keyword:
            yield keyword, options, lines
        words = [word.strip() for word in line[1:].split(",")]
        keyword, lines = words[0].upper(), []
        pairs = (word.partition("=") for word in words[1:])
        options = {key.strip().upper(): value.strip().upper() for key, _, value in pairs}


def _lines(path: Any, outer: Any = ()) -> Iterator[Any]:
    if path in outer:
        raise InputError(f"{path}: includes itself")
    for line in map(str.strip, content(path).splitlines()):
        if line.upper().startswith("*INCLUDE"):
            name = line.partition("=")[2].strip().strip('"')
            yield from _lines(path.parent / name, (*outer, path))
        elif line and not line.startswith("**"):
            yield line


def _nodes(lines: Any) -> dict[Any, Any]:
    """{number: coordinates} of all nodes; those that a line leaves out are zero."""
    rows = (line.rstrip(",").split(",") for line in lines)
    return {int(number): [float(x) for x in (place + ["0"] * 3)[:3]] for number, *place in rows}


def _set(lines: Any, sets: Any, generate: Any) -> Any:
    words = [word.strip() for line in lines for word in line.split(",") if word.strip()]
    if generate:
        rows = [[int(word) for word in line.rstrip(",").split(",")] for line in lines]
        numbers = [range(first, last + 1, *step) for first, last, *step in rows]
        if any(row[MOST_NUMBERS:] for row in numbers):
            raise ValueError  # a typing error: so many nodes would fill the memory
        return set().union(*numbers)
    return set().union(*(sets.get(word.upper()) or [int(word)] for word in set(words)))


def _elements(kind: Any, lines: Any) -> Any:
    """List of (type, label, nodes); an element continues on the next line after a comma."""
    elements, row = [], []
    for line in lines:
        row += [int(word) for word in line.split(",") if word.strip()]
        if not line.endswith(","):
            elements.append((kind, row[0], row[1:]))
            row = []
    return elements
