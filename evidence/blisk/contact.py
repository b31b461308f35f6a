"""The rubbing blisk beside Moreau-Jean time stepping on the same reduced matrices.

`python -m evidence.blisk.contact` writes docs/figures/blisk_response.png (5 min); ends with 1 when
an amplitude differs by more than LIMIT where the motion is periodic.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from evidence import pictures
from evidence.truth import moreau_jean
from evidence.truth.ring import wall_of
from hpcrub.config.schema import load_runs
from hpcrub.model.imported import neutral, reduced
from hpcrub.response.sweep import run_sweep
from hpcrub.results import model_file
from hpcrub.setup.disks import modes_of
from hpcrub.setup.imported import resolved
from hpcrub.setup.problem import build_problem

INPUT = "inputs/blisk/contact.yaml"
# with more friction, and higher bumps, than the example, which is then hard to integrate
CHANGED = [
    "contact.friction=0.05",
    "casing.bump_height_mm=0.06",
    "speeds.from_hz=205",
    "speeds.to_hz=221",
    "time.step_s=2e-6",
    "time.steps_per_bump_width=16",
    "steady_state.first_check_s=0.3",
    "steady_state.max_time_s=0.6",
]
FIGURE = Path("docs/figures/blisk_response.png")
COMPARED = (209.0, 211.0, 213.0, 215.0, 217.0)  # [Hz]
STEP = 5e-7  # of the second program [s]
LIMIT = 0.005  # up to PERIODIC, where the motion repeats itself to less than this
PERIODIC = 215.0  # [Hz]


def main():
    """Both programs at some speeds of the example; returns the exit code."""
    config = resolved(load_runs(INPUT, CHANGED)[0])
    problem = build_problem(config)
    modes = modes_of(config, problem, np.zeros(config.disk.n_blades))
    speeds = config.speeds.values_hz
    ours = run_sweep(modes, problem.scene, speeds).amplitude
    fan, theirs, worst = neutral.from_arrays(model_file.read(config.disk.model)), [], 0.0
    how = problem.scene.damping_ratio, wall_of(problem.scene)
    for speed in COMPARED:
        model = reduced.reduced_model(fan, 2 * np.pi * speed)
        seconds = config.steady_state.first_check
        other = moreau_jean.amplitudes(model, *how, [speed], STEP, seconds)[1, 0]
        theirs.append(other)
        mine = np.interp(speed, speeds, ours)
        if speed <= PERIODIC:
            worst = max(worst, abs(mine / other - 1))
        print(f"{speed:g} Hz: {1e3 * mine:.4f} mm, Moreau-Jean {1e3 * other:.4f} mm, "
              f"{100 * (mine / other - 1):+.2f} %")  # fmt: skip
    figure, axes = plt.subplots(figsize=(6, 3.6), layout="constrained")
    axes.plot(speeds, 1e3 * ours, "o-", color="C0", label="hpcrub")
    axes.plot(COMPARED, 1e3 * np.array(theirs), "x", color="C1", ms=8, label="Moreau-Jean")
    axes.set(xlabel="speed of rotation [Hz]", ylabel="amplitude of the tips [mm]", ylim=(0, None))
    axes.legend(frameon=False)
    pictures.save(figure, FIGURE, dpi=150)
    return int(not worst <= LIMIT)


if __name__ == "__main__":
    raise SystemExit(main())
