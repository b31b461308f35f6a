"""A contact law that hpcrub does not know, in a sweep.

A mass of 1 kg on a spring (ω) stands at rest inside a casing that is a spring (k = 4 ω²), reaching
C beyond it all around. Theory: let go, it moves as q = −4C/5 (1 − cos √5 ωt) until q = −C, flies
on as an oscillation of ω whose amplitude, as energy stays, is √(k/ω²) C = 2C, and comes back.
"""

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
Spring.k = 4.0 * OMEGA**2


def scene_of(**changes):
    face = planar_interface(np.zeros(1), 1.0)
    scene = Scene(face, 0.0, CasingShape(1, 0.0), -C, 0.0, 0.0, law=Spring)
    return scene._replace(record_interval=0.0, steady=TWO_TURNS, **changes)


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
