"""Nodes, elements and node sets of keyword decks, as CalculiX and Abaqus read them."""

import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hpcrub.errors import InputError
from hpcrub.model.imported.readers.text import content

FLAT = (
    "write the deck flat, with all nodes in x, y, z (Abaqus/CAE: Model, Edit attributes, Do not "
    "use parts and assemblies in input files)"
)
UNREAD = "SYSTEM", "NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY"  # make nodes and elements
INPUT = re.compile(
    r"\*(INCLUDE|NODE|NSET|ELEMENT)\s*(,.*)?,\s*INPUT\s*=([^,]*)(,.*)?", re.IGNORECASE
)
MOST_NUMBERS = 10_000_000  # numbers that a line of a set may generate


class Deck(NamedTuple):
    """The mesh of a deck, with the numbers of the deck; names are in capitals."""

    node: np.ndarray  # (n,) numbers, increasing
    place: np.ndarray  # (n, 3) coordinates
    sets: dict  # {name: node numbers}
    elements: list  # (type, label, corner numbers) in the order of the deck
    keywords: set  # all that stand in it
    transforms: list  # (node numbers, "R" or "C", two points (2, 3)) of *TRANSFORM, see Abaqus


def read(path: str | Path) -> Deck:
    """Read a deck with its included files. Raises InputError: unreadable, or without nodes."""
    nodes: dict = {}
    sets: dict = defaultdict(set)
    elements: list = []
    transforms, keywords = [], []
    for keyword, options, lines in _blocks(Path(path)):
        keywords.append(keyword)
        _require_flat(path, keyword, options, lines)
        try:
            if keyword == "NODE":
                new = _nodes(lines)
                nodes |= new
                sets[options.get("NSET")].update(new)
            elif keyword == "NSET":
                sets[options.get("NSET")].update(_set(lines, sets, "GENERATE" in options))
            elif keyword == "ELEMENT":
                elements += _elements(options.get("TYPE", ""), lines)
            elif keyword == "TRANSFORM":
                points = [float(word) for word in ",".join(lines).split(",") if word.strip()]
                kind = options.get("TYPE", "R")
                transforms.append((options["NSET"], kind, np.reshape(points, (2, 3))))
        except (KeyError, ValueError, IndexError):
            raise InputError(f"{path}: *{keyword} holds a line that cannot be read") from None
    if not nodes:
        raise InputError(f"{path}: no nodes (*NODE)")
    if lost := [word for word in ("PART", "INSTANCE") if keywords.count(word) > 1]:
        raise InputError(f"{path}: more than one *{lost[0]}, whose numbers repeat; {FLAT}")
    number = np.array(sorted(nodes), dtype=np.int64)
    unique = {name: np.array(sorted(numbers)) for name, numbers in sets.items() if name}
    turned = [(listed(unique, name, f"{path}: *TRANSFORM of the set"), *how)
              for name, *how in transforms]  # fmt: skip
    return Deck(
        number, np.array([nodes[k] for k in number]), unique, elements, set(keywords), turned
    )


def _require_flat(path: Any, keyword: str, options: Any, lines: Any) -> None:
    """Refuse what would move or make nodes and elements that this reader does not know."""
    if keyword in UNREAD or (keyword == "INSTANCE" and lines):
        raise InputError(f"{path}: *{keyword} is not read; {FLAT}")
    if keyword == "NODE" and options.get("SYSTEM", "R") != "R":
        raise InputError(f"{path}: *NODE, SYSTEM={options['SYSTEM']} is not read; {FLAT}")
    if keyword == "NSET" and "ELSET" in options:
        raise InputError(f"{path}: *NSET, ELSET={options['ELSET']} is not read; list the nodes")
    if keyword == "TRANSFORM" and options.get("TYPE", "R") not in ("R", "C"):
        raise InputError(f"{path}: *TRANSFORM, TYPE={options['TYPE']} is not read; take R or C")


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
        options = {key.strip().upper(): _name(value) for key, _, value in pairs}


def _name(text: str) -> str:
    """Name in capitals; quotes, in which Abaqus keeps small letters, are left out."""
    return text.strip().strip('"').strip().upper()


def _lines(path: Any, outer: Any = ()) -> Iterator[Any]:
    if path in outer:
        raise InputError(f"{path}: includes itself")
    for line in map(str.strip, content(path).splitlines()):
        if match := INPUT.fullmatch(line):
            keyword, before, name, after = match.groups()
            if keyword.upper() != "INCLUDE":  # a file with the lines of this block
                yield f"*{keyword}{before or ''}{after or ''}"
            yield from _lines(path.parent / name.strip().strip('"'), (*outer, path))
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
    return set().union(*(sets.get(_name(word)) or [int(word)] for word in set(words)))


def _elements(kind: Any, lines: Any) -> Any:
    """List of (type, label, nodes); an element continues on the next line after a comma."""
    elements, row = [], []
    for line in lines:
        row += [int(word) for word in line.split(",") if word.strip()]
        if not line.endswith(","):
            elements.append((kind, row[0], row[1:]))
            row = []
    return elements
