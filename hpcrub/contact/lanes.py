"""Vectors of one number per lane, for numba kernels that integrate several speeds at once.

Several angular speeds of one sample advance together, one per *lane*. A lane vector is one hardware
vector that holds a quantity of every lane, and a *tile* is a tuple of vectors that stays in
registers. numba alone keeps neither in registers (a loop over lanes loads and stores its
accumulators at every pass), which costs a factor of three to five here.

Every function below is plain Python, in which a lane vector is a NumPy row and a tile a matrix; so
``kernel.py_func`` runs unchanged in plain Python. Compiled, each function becomes a few LLVM vector
instructions (`simd`), as do sums, differences, products and comparisons of vectors, and of vectors
and numbers.

Lane arrays have shape (rows, width) and are C-contiguous. ``lanes`` is a tuple of ``width`` zeros
whose *length* tells the compiler the vector width; the length of a tuple ``tile`` tells the size of
a tile. Functions that work lane by lane take a number in place of a vector for all lanes, and some
of them a tile. Modules that use many of these functions import this one as ``v``.
"""

import functools
from typing import Any

import numpy as np

from hpcrub.contact import machine

MACHINE = machine.this_machine()
TILE, WIDTH, BLOCK = machine.shape()
WIDTHS = (*(n for n in machine.LANES if n < WIDTH), WIDTH)  # numbers of lanes on this machine
TIPS, PAIR, ONE = (0,) * TILE, (0,) * 2, (0,)  # tiles of different sizes
PLACES = (0,) * 8  # width of a vector that holds eight stresses of one lane


def lane_arrays(width: int, **rows: int) -> dict[str, np.ndarray]:
    """Dictionary of lane arrays of zeros; rows: the number of rows of each, by name."""
    return {name: np.zeros((n, width)) for name, n in rows.items()}


def splat(lanes: tuple, x: float) -> np.ndarray:
    """The number ``x`` in every lane."""
    return np.full(len(lanes), x)


def load(lanes: tuple, array: np.ndarray, rows: Any) -> Any:
    """Row of a lane array (rows, L), or entry of an array that lanes share.

    rows: a row, or a tuple of rows, which gives a tile.
    """
    return array[np.asarray(rows)].copy()


def store(array: np.ndarray, rows: Any, vectors: Any) -> None:
    """Write a vector to a row of a lane array (modified), or a tile to a tuple of rows."""
    array[np.asarray(rows)] = vectors


def fma(a: Any, b: Any, c: Any) -> np.ndarray:
    """a·b + c, fused where the machine has the instruction."""
    return a * b + c


def larger(a: Any, b: Any) -> np.ndarray:
    """The larger of a and b in every lane; b where a is NaN."""
    return np.where(a > b, a, b)


def magnitude(a: Any) -> np.ndarray:
    """|a| in every lane."""
    return np.abs(a)


def inverse(a: np.ndarray) -> np.ndarray:
    """1/a in every lane; 0 where a is not positive."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(a > 0.0, 1.0 / a, 0.0)


def length(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """√(a² + b²) in every lane."""
    return np.sqrt(a * a + b * b)


def select(mask: np.ndarray, a: Any, b: Any) -> np.ndarray:
    """``a`` where the mask holds, ``b`` elsewhere."""
    return np.where(mask, a, b)


def any_lane(mask: np.ndarray) -> bool:
    """Whether the mask holds in any lane."""
    return bool(np.any(mask))


def tile_splat(tile: tuple, vector: np.ndarray) -> Any:
    """A tile whose members are all ``vector``."""
    return np.array([vector for _ in tile])


def tile_add(tile: Any, matrix: np.ndarray, row: int, columns: tuple, vector: Any) -> Any:
    """Tile plus, in member i, ``matrix[row, columns[i]]`` times the vector."""
    return tile + matrix[row, np.array(columns), None] * vector


def tile_advance(
    force: tuple, first: int, state: Any, scheme: Any, before: Any, external: Any,
    step: int | None, late: Any,
) -> None:  # fmt: skip
    """Corrector and predictor of consecutive modes, as in `passes` (state is modified).

    force: tile of modal forces (L,), one for each mode from ``first`` on [N/√kg].
    before: array for the increments between the two, or None.
    external: modal forces of a load (P, K) [N/√kg], or None.
    step: row of ``external``; None for the corrector alone.
    late: tile of modal forces that the predictor adds, or None.
    """
    for i, f in enumerate(force):
        k = first + i
        gain = scheme.gain[k]
        q, d = state.position[k] + f * gain, state.increment[k] + f * gain
        if before is not None:
            before[k] = d
        if step is not None:
            d = scheme.decay[k] * d - (gain * scheme.omega2[k]) * q
            if external is not None:
                d = d + external[step, k] * gain
            if late is not None:
                d = d + late[i] * gain
            q = q + d
        state.increment[k], state.position[k] = d, q


def tile_relax(
    coupling: np.ndarray, n_rows: int, rows: tuple, penetration: np.ndarray, x: Any
) -> Any:
    """One sweep of projected Gauss–Seidel for x_i = max(p_i − Σ C_ij x_j, 0).

    coupling: (n_rows², L) matrix C with zero diagonal, entry (i, j) in row i·n_rows + j [-].
    n_rows: number of rows of C.
    rows: row of C and p for each member of the tile.
    penetration: p (≥ n_rows, L) [m].
    x: (L,) tile of unknowns before the sweep [m].
    Returns the tile of unknowns after the sweep [m].

    A sum begins after its own point and ends with the point before, which is the last to be known.
    """
    new = list(x)
    for a, row in enumerate(rows):
        depth = penetration[row]
        for b in (*range(a + 1, len(new)), *range(a)):
            depth = depth - coupling[row * n_rows + rows[b]] * new[b]
        new[a] = larger(depth, 0.0)
    return np.array(new)


def tile_largest(tile: Any) -> np.ndarray:
    """Largest member of a tile, lane by lane."""
    return functools.reduce(lambda largest, one: larger(one, largest), tile)


def indices(tile: tuple, array: np.ndarray, first: int) -> tuple:
    """Tuple as long as ``tile`` with the entries of an integer array from ``first`` on."""
    return tuple(int(array[first + i]) for i in range(len(tile)))


def consecutive(tile: tuple, first: int) -> tuple:
    """Tuple as long as ``tile`` with the integers from ``first`` on."""
    return tuple(range(first, first + len(tile)))
