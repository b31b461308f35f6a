"""A contact law that hpcrub does not know, in a sweep and in a history.

A mass of 1 kg on a spring (ω) stands at rest inside a casing that is a spring (k = 4 ω²), reaching
C beyond it all around. Theory: let go, it moves as q = −4C/5 (1 − cos √5 ωt) until q = −C, flies
on as an oscillation of ω whose amplitude, as energy stays, is √(k/ω²) C = 2C, and comes back.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np
import pytest

from evidence.validation.report import SCHEMES, fitted_order
from hpcrub.config.schema import Config
from hpcrub.contact import jit
from hpcrub.contact.laws.hard import Hard
from hpcrub.contact.laws.planar import Planar
from hpcrub.contact.status import STEADY
from hpcrub.model.casing import CasingShape
from hpcrub.model.interface import planar_interface
from hpcrub.model.reduction import Modes
from hpcrub.response import history
from hpcrub.response.scene import Scene
from hpcrub.response.steady import SteadyCriteria
from hpcrub.response.sweep import run_sweep
from hpcrub.setup.laws import law_of
from inputs.spring_law import Spring
from tests.program import ROOT

OMEGA, C = 2.0 * np.pi * 20.0, 1e-3
TOUCHING = np.arccos(-0.25) / (np.sqrt(5.0) * OMEGA)  # [s] from rest until it leaves
PERIOD = 2.0 * (TOUCHING + np.pi / 3.0 / OMEGA)
MODES = Modes.planar(np.full(1, OMEGA), np.ones((1, 1)), np.ones((1, 1)))
TWO_TURNS = SteadyCriteria(first_check=0.0, window_revolutions=1, max_time=2.5 * PERIOD)
STEPS = PERIOD / np.array([2000, 4000, 8000, 16000])
CACHES = ["XDG_CACHE_HOME", "NUMBA_CACHE_DIR"]
Spring.k = 4.0 * OMEGA**2


def scene_of(**changes):
    face = planar_interface(np.zeros(1), 1.0)
    scene = Scene(face, 0.0, CasingShape(1, 0.0), -C, 0.0, 0.0, law=Spring)
    return scene._replace(record_interval=0.0, steady=TWO_TURNS, **changes)


def exact(t):
    """q of the motion [m]."""
    since = np.abs(np.mod(t + PERIOD / 2.0, PERIOD) - PERIOD / 2.0)  # of the nearest rest inside
    pressed = -0.8 * C * (1.0 - np.cos(np.sqrt(5.0) * OMEGA * since))
    free = -2.0 * C * np.cos(OMEGA * (PERIOD / 2.0 - since))
    return np.where(since < TOUCHING, pressed, free)


@pytest.mark.parametrize("name", SCHEMES)
def test_a_sweep_with_a_law_from_elsewhere_converges_to_its_exact_amplitude(name):
    errors = []
    for step in STEPS:
        scene = scene_of(scheme=name, step=step)
        result = run_sweep(MODES, scene, [1.0 / PERIOD], width=8)
        assert result.point_status[0] == STEADY
        errors.append(abs(result.amplitude[0] / (2.0 * C) - 1.0))
    assert errors[-1] < 2e-3
    assert 0.99 < fitted_order(STEPS, np.array(errors)) < 1.01  # the force is that of a step's end


@pytest.mark.parametrize("name", SCHEMES)
def test_a_history_has_its_motion_and_its_forces(name):
    errors = []
    for step in STEPS:
        pieces = history.integrate(MODES, scene_of(scheme=name, step=step), [1.0 / PERIOD], PERIOD)
        (piece,) = pieces
        q, t = piece.position[:, 0, 0], piece.time[:, 0]
        errors.append(np.abs(q - exact(t)).max() / C)
        expected = Spring.k * np.maximum(q + C, 0.0)
        np.testing.assert_allclose(piece.normal_force[:, 0, 0], expected, atol=1e-9 * Spring.k * C)
        assert not piece.tangential_force.any()
    assert errors[-1] < 2e-3
    assert 0.99 < fitted_order(STEPS, np.array(errors)) < 1.01


@pytest.mark.parametrize("variable", CACHES)
def test_a_copy_of_the_program_and_a_change_have_their_own_compiled_code(
    variable, tmp_path, monkeypatch
):
    """numba looks at the file of the function alone: a change in ``lanes.py`` it would not see."""
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv(variable, str(tmp_path))
    folders = [jit._cache_folder()]
    shutil.copytree(ROOT / "hpcrub", tmp_path / "clone" / "hpcrub")
    monkeypatch.setattr(jit, "__file__", str(tmp_path / "clone" / "hpcrub" / "contact" / "jit.py"))
    folders.append(jit._cache_folder())
    with (tmp_path / "clone/hpcrub/contact/laws/planar.py").open("a") as file:
        file.write("# changed\n")
    folders.append(jit._cache_folder())
    assert len(set(folders)) == 3
    assert all(Path(folder).is_relative_to(tmp_path / "hpcrub") for folder in folders)


def test_no_folder_for_compiled_code_is_no_error(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert jit._cache_folder() == ""


def test_the_key_of_compiled_code_holds_the_source_of_a_law_from_elsewhere():
    """Else a law that was changed would go on as it was."""
    own, arrays = Spring(np.zeros((12, 8))), [np.zeros((12, 8))] * 3
    rigid = Planar(*arrays, Hard())
    (spring, nothing) = (jit._foreign_sources((numba.typeof(law),)) for law in (own, rigid))
    source = (ROOT / "inputs/spring_law.py").read_text(encoding="utf-8")
    assert spring == {f"inputs.spring_law\n{source}"}
    assert nothing == set()


def test_the_same_law_by_another_name_has_compiled_code_of_its_own():
    """A study loads it by a name that another program cannot import (`ModuleNotFoundError`)."""
    config = Config.from_yaml(f"contact: {{own_law: '{ROOT}/inputs/spring_law.py:Spring'}}")
    loaded = law_of(config)
    keys = [jit._foreign_sources((numba.typeof(kind(np.zeros((12, 8)))),))
            for kind in (Spring, loaded)]  # fmt: skip
    assert loaded is not Spring
    assert keys[0].isdisjoint(keys[1])


PROGRAM = """\
import sys
from hpcrub.contact.jit import compiled
if sys.argv[1] == "own":
    from mine import Own as Kind
else:
    from collections import namedtuple
    Kind = tuple

@compiled
def first(values):
    return values[0] + 1.0

assert first(Kind((2.0,))) == 3.0
"""


@pytest.mark.parametrize("variable", CACHES)
def test_code_compiled_for_a_law_from_elsewhere_does_not_bar_who_lacks_that_law(
    variable, tmp_path, monkeypatch
):
    (tmp_path / "program.py").write_text(PROGRAM)
    mine = tmp_path / "mine.py"
    mine.write_text(
        "from typing import NamedTuple\n\n\nclass Base(NamedTuple):\n    value: float\n\n\n"
        "def Own(values):\n    return Base(*values)\n"
    )
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    home = os.environ | {variable: str(tmp_path), "PYTHONPATH": str(ROOT)}
    for who in ("own", "other"):
        command = [sys.executable, str(tmp_path / "program.py"), who]
        assert subprocess.run(command, env=home, check=False).returncode == 0
        mine.unlink(missing_ok=True)
    kept = list(tmp_path.rglob("*.nbi"))
    assert len(kept) == 2
    assert all(index.is_relative_to(tmp_path / "hpcrub") for index in kept)


@jit.compiled(inner=True)
def next_of(n):
    return n + 1


@jit.compiled
def counted(n):
    last = 0
    for _ in range(n):
        last = next_of(last)
    return last


def test_a_function_is_compiled_once_for_a_number_that_begins_with_zero():
    """By itself numba compiles it for the value 0 as well, and so all that it calls."""
    assert counted(3) == 3
    counted.recompile()  # code that is loaded from the cache asks for no `next_of`
    assert len(next_of.signatures) == 1


class Foreign(NamedTuple):
    """A tuple of somebody who knows nothing of contact laws, with fields of the same names."""

    wear: np.ndarray
    predict: float


class Halving(NamedTuple):
    """A law with a helper of its own."""

    share: float

    @staticmethod
    @jit.compiled(inner=True)
    def half_of_it(law, x):
        return 0.5 * law.share * x

    @staticmethod
    @jit.compiled(inner=True)
    def forces(law, x):
        return law.half_of_it(law, x) + 1.0


def test_every_compiled_method_of_a_law_can_be_called_by_any_name():
    @jit.compiled
    def called(law, x):
        return law.forces(law, x)

    assert called(Halving(4.0), 10.0) == 21.0


def test_fields_of_other_named_tuples_are_what_they_were():
    """Also counted references to arrays: without them the array is freed too early."""

    @numba.njit
    def summed(n):
        mine = Foreign(np.arange(n), 0.5)
        kept = mine.wear
        return kept, mine.predict + kept.sum()

    for _ in range(100):
        kept, value = summed(1000)
        np.testing.assert_array_equal(kept, np.arange(1000))
        assert value == 499500.5


def test_damaged_compiled_code_is_compiled_anew_and_mended(tmp_path, monkeypatch):
    (tmp_path / "program.py").write_text(PROGRAM)
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    home = os.environ | {"XDG_CACHE_HOME": str(tmp_path), "PYTHONPATH": str(ROOT)}

    def run():
        command = [sys.executable, str(tmp_path / "program.py"), "other"]
        subprocess.run(command, env=home, check=True)
        return {file: file.read_bytes() for file in (tmp_path / "hpcrub").rglob("*.nb?")}

    before = run()
    for kind, share in (("nbc", 0.0), ("nbc", 0.5), ("nbi", 0.0), ("nbi", 0.5)):
        for file, content in before.items():
            if file.suffix == f".{kind}":
                file.write_bytes(content[: int(share * len(content))])
        after = run()
        assert before.keys() == after.keys()
        assert all(len(content) > 0.9 * len(before[file]) for file, content in after.items())
