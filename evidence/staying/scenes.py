"""The scenes on which motions are followed on, and the rules that are compared."""

import numpy as np

from evidence.page import ROOT
from hpcrub.config.schema import load_runs
from hpcrub.setup import input_files
from hpcrub.setup.disks import deviation, modes_of, run_deviation
from hpcrub.setup.problem import build_problem

# speeds around the interaction of so many bumps with the first family of the reference disk [Hz]
RANGES = {
    2: (66.5, 70.5, 0.1), 3: (44.5, 47.5, 0.075), 4: (33.3, 35.5, 0.055), 6: (22.0, 24.4, 0.1),
    12: (11.0, 12.2, 0.05),
}  # fmt: skip
DAMPINGS = 0.005, 0.01, 0.02, 0.03, 0.04
TUNED = {
    (n, damping): {
        "casing.n_bumps": n, "material.damping_ratio": damping,
        "speeds.from_hz": first, "speeds.to_hz": last, "speeds.step_hz": step,
    }
    for n, (first, last, step) in RANGES.items() for damping in DAMPINGS
}  # fmt: skip
# name: (input, changes, disks, seconds of the truth); a disk is (level, sample), or a run of the
# tuned disk (None, run)
MISTUNED = {
    "quick start": ("quickstart", {}, [(v, n) for v in (0, 1) for n in range(10)], 4.0),
    "quick start, tuned": ("quickstart", {}, [(None, run) for run in range(6)], 4.0),
    "Table 2": ("table2", {"steady_state.rule": "ensemble", "mistuning.samples": 4,
                           "mistuning.reference": "staying"}, [(0, n) for n in range(4)], 4.0),
    "blisk": ("blisk/contact", {}, [(None, 0), (None, 1), *((0, n) for n in range(4))], 2.0),
    "rotor 67": ("rotor67/contact", {}, [(None, 0), *((0, n) for n in range(3))], 1.2),
    "three bumps": ("quickstart", TUNED[3, 0.005] | {"mistuning.seed": 71},
                    [(0, 0), (1, 0), (0, 1), (1, 1)], 4.0),
    "five bumps, damping 0.02": ("quickstart", {
        "casing.n_bumps": 5, "material.damping_ratio": 0.02, "mistuning.seed": 72,
        "speeds.from_hz": 26.5, "speeds.to_hz": 29.0}, [(0, 0), (1, 0), (0, 1)], 4.0),
    "six bumps, damping 0.01": ("quickstart", TUNED[6, 0.01] | {"mistuning.seed": 73},
                                [(0, 0), (1, 0), (0, 1), (1, 1)], 4.0),
    "30 blades": ("quickstart", {"disk.n_blades": 30, "mistuning.seed": 74},
                  [(0, 0), (1, 0), (0, 1)], 4.0),
}  # fmt: skip


class Scenes:
    """Disks of one input with changes."""

    def __init__(self, name, changes):
        config = load_runs(ROOT / f"inputs/{name}.yaml")[0].replace(changes)
        self.config = input_files.resolved(config)
        self.problem = build_problem(self.config)
        self.speeds = self.config.speeds.values_hz

    def modes(self, level, number):
        """Modes of a sample of a level, or of a run of the tuned disk."""
        blades = np.zeros(self.config.disk.n_blades)
        if level is not None:
            blades = deviation(self.config, level, number)
        elif number >= 0:
            blades = run_deviation(self.config, number)
        return modes_of(self.config, self.problem, blades)

    def scene(self, **criteria):
        """Scene with other criteria of the steady state."""
        scene = self.problem.scene
        return scene._replace(steady=scene.steady._replace(**criteria))
