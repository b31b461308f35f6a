"""Lanes, tiles and blocks that fit the registers and the first-level cache of this machine.

The rule is like that of BLIS for matrix products (Low, Igual, Smith, Quintana-Ortí, ACM
Transactions on Mathematical Software 43, 2016). Every shape gives the same bits. Tests and
benchmarks override the rule by the environment variable ``HPCRUB_SHAPE``: tile, lanes and block,
as in "6x8x60".
"""

import contextlib
import os
import platform
from pathlib import Path
from typing import NamedTuple

import numba
from llvmlite import binding

NUMBER = 8  # [bytes]
TILES = 12, 6, 4, 2, 1  # possible numbers of vectors in a tile
LANES = 4, 8, 16  # possible numbers of lanes
FEWEST_VECTORS = 4  # vectors of a tile: with fewer, the modes are read too often
MODES = 84  # modes of the reference disk, whose motion and coefficients should fit the cache
ROWS = 4  # numbers of a mode per lane: position, increment, decay and gain
SMALL_CACHE = 32 << 10  # size [bytes] where the system does not tell
CACHES = Path("/sys/devices/system/cpu/cpu0/cache")  # where Linux tells


class Machine(NamedTuple):
    """Registers and cache of a machine, which fix the shape of the kernel."""

    registers: int  # number of vector registers
    vector: int  # numbers in a register
    cache: int  # first-level data cache [bytes]


class Shape(NamedTuple):
    """Shape of a kernel: sizes of tiles, banks and blocks."""

    tile: int  # rows of a matrix whose sums stay in registers
    lanes: int
    block: int  # modes that stay in the first-level cache: a multiple of 12


def this_machine() -> Machine:
    """Machine that numba compiles for; numba's environment variables may change it."""
    if numba.config.CPU_FEATURES is not None:  # type: ignore[attr-defined]
        words = numba.config.CPU_FEATURES.split(",")  # type: ignore[attr-defined]
        has = {word[1:] for word in words if word.startswith("+")}
    else:
        has = {name for name, there in binding.get_host_cpu_features().items() if there}
    if "avx512f" in has:
        registers, vector = 32, 8
    elif platform.machine().lower() in ("arm64", "aarch64"):
        registers, vector = 32, 2
    else:
        registers, vector = 16, 4 if "avx" in has else 2
    return Machine(registers, vector, first_level_cache() or SMALL_CACHE)


def first_level_cache() -> int:
    """Size of the first-level data cache [bytes]; 0 where the system does not tell."""
    for cache in CACHES.glob("index*"):
        with contextlib.suppress(OSError, ValueError):
            level, kind, size = ((cache / name).read_text() for name in ("level", "type", "size"))
            if int(level) == 1 and kind.strip() != "Instruction":
                return int(size.strip().removesuffix("K")) << 10
    return 0


def shape_for(machine: Machine) -> Shape:
    """Shape of the kernel for a machine.

    The sums of a tile stay in registers, beside a row of the modes and one factor. The shape has
    the largest number of lanes that leaves room for FEWEST_VECTORS in a tile and keeps the modes in
    the first-level cache. A block of modes fills three quarters of this cache.
    """
    shapes = []
    for lanes in LANES:
        row = -(-lanes // machine.vector)
        tile = max(tile for tile in TILES if tile == 1 or (tile + 1) * row < machine.registers)
        shapes.append(shape_of(tile, lanes, machine))
    fitting = [
        s for s in shapes if s.tile >= FEWEST_VECTORS and MODES * size_of(s.lanes) <= machine.cache
    ]
    return fitting[-1] if fitting else shapes[0]


def shape_of(tile: int, lanes: int, machine: Machine) -> Shape:
    """Shape of this tile and these lanes; a block is a multiple of 12 modes."""
    return Shape(tile, lanes, max(3 * machine.cache // 4 // size_of(lanes) // 12, 1) * 12)


def size_of(lanes: int) -> int:
    """Size of the motion and coefficients of a mode [bytes]."""
    return ROWS * NUMBER * lanes


def shape() -> Shape:
    """Shape of the kernel on this machine, by the rule or from HPCRUB_SHAPE."""
    if forced := os.environ.get("HPCRUB_SHAPE"):
        return Shape(*map(int, forced.split("x")))
    return shape_for(this_machine())
