"""Stress at the roots of rubbing blades against the forces that hold the blades, for seven disks.

`hpcrub` observes strain and curvature of the first element. `evidence.truth.section` takes the same
steps once more, keeps all of them, and recovers the stress from the reaction of the whole blade.
"""

import numpy as np

from evidence.page import table
from evidence.truth.section import largest, root_stress
from evidence.validation import report
from hpcrub.config.schema import Config
from hpcrub.model.reduction import mistuned_modes
from hpcrub.response.sweep import run_sweep
from hpcrub.setup.disks import deviation
from hpcrub.setup.problem import build_model, build_problem

SPEED_HZ = 33.8
DISKS = ((2020, 2, 0), (2020, 2, 22), (1, 2, 0), (7, 2, 3), (11, 0, 4), (12, 1, 5), (13, 3, 6))
TOPS_HZ = 120.0, 700.0  # modes up to here alone
FACTOR = 45.3e9  # stress of the clamped blade's first bending mode for a motion of its tip [Pa/m]
ALLOWED = 1e-6


def compared(seed, level, sample):
    """Of one disk: half range, amplitude [m], stress, the recovered one, and that of some modes."""
    config = Config(mistuning={"seed": seed}, limits={"stress_mpa": 1000.0})
    model, problem = build_model(config), build_problem(config)
    stiffer = deviation(config, level, sample)
    modes = mistuned_modes(problem.reduced, stiffer)
    found = run_sweep(modes, problem.scene, [SPEED_HZ])
    shapes = model.reduced.basis @ modes.shapes
    rows = root_stress(model.disk, config.disk, shapes, stiffer).reshape(-1, len(modes.omega))
    end = found.time[0] * SPEED_HZ
    window = end - config.steady_state.window_revolutions, end

    def recovered(top_hz):
        some = rows * (modes.omega < 2.0 * np.pi * top_hz)
        return largest(modes, problem.scene, SPEED_HZ, *window, some)

    half_range = config.mistuning.half_range[level]
    return half_range, found.amplitude[0], found.stress[0], *map(recovered, (np.inf, *TOPS_HZ))


def section(_folder):
    """Parts of the page, and verdicts."""
    rows, worst = [], 0.0
    for seed, level, sample in DISKS:
        half_range, amplitude, stress, whole, *some = compared(seed, level, sample)
        worst = max(worst, abs(stress / whole - 1.0))
        rows.append(
            [f"seed {seed}, ±{100 * half_range:.0f} %, sample {sample}", f"{1e3 * amplitude:.1f}"]
            + [f"{1e-6 * s:,.0f}" for s in (FACTOR * amplitude, *some, whole, stress)]
            + [f"{abs(stress / whole - 1.0):.1e}"]
        )
    heading = ["disk", "amplitude [mm]", f"{1e-9 * FACTOR:g} MPa/mm of it"]
    heading += [f"modes up to {f:g} Hz" for f in TOPS_HZ]
    heading += ["recovered [MPa]", "hpcrub [MPa]", "difference"]
    verdict = report.at_most("largest difference of the stress", worst, ALLOWED)
    return {"disks": table(heading, rows)}, [verdict]
