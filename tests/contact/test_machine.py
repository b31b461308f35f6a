"""Lanes, tiles and blocks: what fits a machine, and that no choice of them changes a bit."""

import hashlib
import itertools
import os
import subprocess
import sys

import numpy as np
import pytest

from evidence.truth.disk import STEEL
from evidence.truth.motion import spatial
from hpcrub.contact.bank import allocate
from hpcrub.contact.integrate import run
from hpcrub.contact.machine import LANES, ROWS, TILES, Machine, first_level_cache, shape_for
from hpcrub.contact.observers import Record
from hpcrub.model.casing_modes import ring_modes
from hpcrub.model.reduction import Modes
from hpcrub.response.revolution import Grid
from tests.contact.laws.test_solid import made_up
from tests.contact.laws.thrown import HARD, MASS, ready
from tests.program import ROOT

SPEEDS = np.linspace(29.0, 31.0, 4)
N_STEPS = 6
KIB = 1 << 10


def test_the_cache_is_that_which_the_c_library_tells():
    told = int(subprocess.check_output(["getconf", "LEVEL1_DCACHE_SIZE"]))
    if told == 0:
        pytest.skip("the C library does not tell the cache of this processor")
    assert first_level_cache() == told


def test_arrays_of_a_bank_lie_one_after_the_other_on_cache_lines():
    """Also those of the surface within its law, and of a bank with fewer lanes."""
    bank, _ = ready(MASS, 1.0, 1e-5, kind=spatial, coating=HARD)
    bank.law.surface.weights[:] = np.arange(bank.width)
    narrow = bank.take([5, 2])
    np.testing.assert_array_equal(narrow.law.surface.weights[0], [5.0, 2.0])
    np.testing.assert_array_equal(narrow.scheme.normal, bank.scheme.normal)
    assert narrow.law.axial.flags.f_contiguous
    for one in (bank, narrow):
        places = np.array(sorted(
            (array.ctypes.data, array.nbytes) for group in (*one, one.law.surface)
            for array in group if isinstance(array, np.ndarray)
        ))  # fmt: skip
        lines, rest = np.divmod(places[:, 0], 64)
        assert (rest == 0).all()
        np.testing.assert_array_equal(np.diff(lines), -(-places[:-1, 1] // 64))


@pytest.mark.parametrize("registers", [8, 16, 32])
@pytest.mark.parametrize("vector", [1, 2, 4, 8])
@pytest.mark.parametrize("cache", [4 * KIB, 16 * KIB, 32 * KIB, 192 * KIB])
def test_any_shape_fits_registers_and_cache(registers, vector, cache):
    shape = shape_for(Machine(registers, vector, cache))
    row = max(shape.lanes // vector, 1)
    fits = (shape.tile + 1) * row + 1 <= registers
    assert fits or (shape.tile, shape.lanes) == (1, LANES[0])
    assert shape.block % shape.tile == shape.block % 2 == 0  # pairs are not cut
    assert shape.block == 12 or shape.block * ROWS * 8 * shape.lanes <= 0.75 * cache


def digest():
    """Digest of the motions of disks in a casing that vibrates, in 4 and 8 lanes."""
    solid, scene = made_up(0, 5, 3)  # 15 points: tiles that are full and one that is not
    names = "normal", "tangential"
    planar = Modes.planar(solid.omega[:30], *(getattr(solid, name)[:, :30] for name in names))
    pairs = ring_modes(STEEL, np.arange(2, 5), 0.01).seen_from(scene.interface.angle)
    scene = scene._replace(ramp_time=1e-4, clearance=1.0e-3)
    seen = hashlib.sha256()
    for disk, width in itertools.product((planar, solid), (4, 8)):
        modes = disk._replace(pairs=pairs)
        bank = allocate(modes, scene, Grid(240, 1, 1), width, SPEEDS)
        bank = bank._replace(scheme=bank.scheme._replace(bump=bank.scheme.bump[:N_STEPS]))
        record = Record.allocate(bank, 1, 1)
        run(bank, 1, record)
        assert (bank.state.multiplier > 0.0).any(axis=0)[: len(SPEEDS)].all()  # all rub
        n = len(modes.observed)
        history = record.history.reshape(N_STEPS, -1, width)[:, :n]
        for array in (history, record.peak[:n], bank.state.position, bank.state.increment):
            seen.update(np.ascontiguousarray(array[..., : len(SPEEDS)]).tobytes())
    return seen.hexdigest()


@pytest.mark.long
def test_no_shape_changes_a_bit():
    """By other processes, which compile nothing."""
    code = "from tests.contact.test_machine import digest; print(digest())"
    plain = os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)}
    started = [
        subprocess.Popen(
            [sys.executable, "-c", code], stdout=subprocess.PIPE, text=True,
            env=plain | {"HPCRUB_SHAPE": f"{tile}x8x{block}"},
        )
        for tile, block in ((TILES[0], 12), (TILES[-2], 36))
    ]  # fmt: skip
    first, other = (process.communicate()[0].strip() for process in started)
    assert len(first) == 64
    assert other == first
