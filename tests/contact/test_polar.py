"""Contact in the displaced position: what a long time step must not lose.

A slow bump presses a nearly radial blade. How far its tip evades depends on the direction of the
contact force, and the fast modes spring back within a step when they are let go.
"""

import pytest

from hpcrub.config.schema import Config, replaced
from hpcrub.contact.status import STEADY
from hpcrub.response.sweep import run_sweep
from hpcrub.studies.problem import build_problem
from hpcrub.studies.samples import deviation, modes_of

PRESSED = {
    "disk.n_blades": 3,
    "disk.blade.n_elements": 2,
    "disk.blade.thickness_mm": 6.9,
    "disk.blade.lean_deg": -4.3,
    "disk.blade.bow": -0.051,
    "disk.tip_radius_mm": 387.0,
    "disk.inner_radius_mm": 169.9,
    "disk.ring_thickness_mm": 13.4,
    "disk.spoke_thickness_mm": 7.2,
    "material.damping_ratio": 0.22,
    "reduction.n_modes": 27,
    "casing.n_bumps": 2,
    "casing.bump_height_mm": 0.316,
    "casing.clearance_mm": 0.045,
    "contact.friction": 0.0,
    "contact.kinematics": "polar",
    "speeds.from_hz": 2.1,
    "speeds.to_hz": 2.1,
    "steady_state.first_check_s": 1.0,
    "steady_state.window_revolutions": 1,
}


def amplitude(keys, factor=1.0):
    """Of the tuned disk at the step that the input gets, divided by a factor [m]."""
    config = replaced(Config(), keys)
    config = replaced(config, {"time.step_s": config.step / factor})
    problem = build_problem(config)
    modes = modes_of(config, problem, 0.0 * deviation(config, 0, 0))
    result = run_sweep(modes, problem.scene, config.speeds.values_hz)
    assert result.point_status[0] == STEADY
    return result.amplitude[0]


def test_a_pressed_blade_needs_no_shorter_step_than_the_usual_one():
    assert amplitude(PRESSED) == pytest.approx(amplitude(PRESSED, 16.0), rel=0.01)


def test_it_matters_that_the_normal_turns():
    """For a tip that moves by a thousandth of the radius: the blade is near to buckling."""
    small = amplitude(PRESSED | {"contact.kinematics": "small"})
    assert amplitude(PRESSED) < 0.9 * small
