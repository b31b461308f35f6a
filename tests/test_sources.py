"""Studies that take their samples from an earlier contact study: energy, cross, damping.

Truth: the strain energy of every blade on the full finite-element model.
"""

import numpy as np
import pytest
from conftest import TINY

from hpcrub import config, history
from hpcrub.reduction import craig_bampton, mistune, mistuned_modes
from hpcrub.studies import energy
from hpcrub.study import build_problem
from hpcrub.sweep import Motion, run_sweep

ONE_SPEED = {"speeds.from_hz": 34.0, "speeds.to_hz": 34.0}


@pytest.mark.parametrize("basis", ["tuned", "per_sample"])
def test_strain_energy_is_that_of_the_full_model(basis):
    """The same motion in the dof of the finite elements, blade by blade."""
    keys = ONE_SPEED | {"reduction.basis": basis}
    cfg = config.replaced(config.Config.from_yaml(TINY), keys)
    model, deviation = build_problem(cfg), np.linspace(-0.03, 0.03, 12)
    problem = energy.Problem(cfg, model, deviation[None])
    ((_, _, found),) = energy.compute(problem, 1, lambda: None)

    disk, own = mistune(model.disk, deviation), basis == "per_sample"
    reduced = craig_bampton(disk, cfg.reduction.n_modes) if own else model.reduced
    modes = mistuned_modes(reduced, np.zeros(12) if own else deviation)
    motion = Motion.at_rest(1, len(modes.omega))
    run_sweep(modes, model.scene, [34.0], motion=motion)
    duration = cfg.steady_state.window_revolutions / 34.0
    pieces = history.march(modes, model.scene, [34.0], duration, motion)
    q = np.concatenate([piece.position[:, :, 0] for piece in pieces])
    u = q @ (reduced.basis @ modes.shapes).T
    expected = [
        (0.5 * (u[:, dof] @ k) * u[:, dof]).sum(axis=1).max()
        for dof, k in zip(disk.blade_dof, disk.blade_stiffness, strict=True)
    ]
    assert min(expected) > 0.0
    assert found[0] == pytest.approx(expected, rel=1e-6)
