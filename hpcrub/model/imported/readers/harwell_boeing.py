"""Harwell-Boeing files of real matrices, also of symmetric ones, which SciPy does not read."""

import re
from itertools import chain

import numpy as np
import scipy.sparse as sp

TYPE = re.compile(r"([RCP])([SUHZR])([AE])\s")  # of a matrix, at the beginning of the third line
FIELD = re.compile(r"(\d*)[IEDFG](\d+)")  # of a Fortran format: how many in a line, their width
N_HEADER = 4  # lines; a fifth one tells of right-hand sides


def is_one(text: str) -> bool:
    """Whether a text, in capitals, is a Harwell-Boeing file."""
    lines = text.split("\n", 3)
    return len(lines) > 2 and TYPE.match(lines[2]) is not None


def matrix(text: str) -> sp.csr_array:
    """Read the matrix of a file, in capitals, completed if it is symmetric. Raises ValueError."""
    lines = text.splitlines()
    _, n_pointers, n_indices, n_values, *right = map(int, lines[1].split())
    match = TYPE.match(lines[2])
    if not match or match[1] != "R" or match[2] not in "SUR" or match[3] != "A":
        raise ValueError(f"{lines[2][:3]} is no real, assembled matrix (RSA, RUA)")
    rows, columns, entries = map(int, lines[2].split()[1:4])
    formats = lines[3]
    at = N_HEADER + bool(right and right[0])
    parts = []
    for n_lines, count in ((n_pointers, columns + 1), (n_indices, entries), (n_values, entries)):
        field = FIELD.search(formats)
        if not field or len(lines) < at + n_lines:
            raise ValueError("it ends too early, or its formats cannot be understood")
        formats = formats[field.end() :]
        width = int(field[2])
        block = chain.from_iterable(_words(line, width) for line in lines[at : at + n_lines])
        parts.append(np.array(list(block), dtype=float))
        if len(parts[-1]) != count:
            raise ValueError(f"{len(parts[-1])} numbers where its head announces {count}")
        at += n_lines
    pointer, index = (part.astype(np.int64) - 1 for part in parts[:2])
    found = sp.csc_array((parts[2], index, pointer), shape=(rows, columns)).tocsr()
    found.check_format(full_check=True)
    return found + found.T - sp.diags_array(found.diagonal()) if match[2] == "S" else found


def _words(line: str, width: int) -> list[str]:
    """Numbers of a line in fields of a width, with exponents E."""
    fields = (line[k : k + width].strip() for k in range(0, len(line), width))
    return [word.replace("D", "E") for word in fields if word]
