"""Stand-ins for open result files: a configuration and arrays by name."""

from pathlib import Path

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.contact.status import STEADY
from hpcrub.results.layout import DONE
from tests.program import TINY

N = 40  # samples of every level
EVERYWHERE = [("amplitude_error_m", np.nan), ("amplitude_scatter_m", np.nan), ("point_reason", 0),
              ("max_sweeps", 1), ("growth_shows_s", np.nan),
              ("point_status", STEADY)]  # fmt: skip
PHYSICS = TINY[: TINY.index("mistuning")]
PATTERN = f"mistuning: {{pattern_unit: gpa, pattern: {[205.0, 215.0] * 6}}}\n"


class File:
    """Stands for an open result file."""

    def __init__(self, text, warnings="", path="file.h5", **values):
        self.config, self.path = Config.from_yaml(text), Path(path)
        self.values = {name.replace("__", "/"): value for name, value in values.items()}
        if "samples/status" in self.values and self.config.pattern_deviation is None:
            self.config = self.config.replace({"mistuning.samples": self.status.shape[1]})
        self.warnings = [line for line in warnings.splitlines() if line]

    def read(self, name, where=()):
        return np.asarray(self.values[name])[where]

    def __contains__(self, name):
        return name in self.values

    @property
    def status(self):
        return self.read("samples/status")

    @property
    def attributes(self):
        return {"time_step_s": self.config.step}


def contact_file(random, text=TINY, shape=(2, N), **more):
    """Two levels, three speeds; another distribution for everything."""
    status = np.full(shape, DONE)
    status[:, 3:4] = 0  # not there yet: its values must not count
    return File(
        text,
        speeds_hz=np.array([34.0, 34.2, 34.4]),
        half_range=np.array([0.02, 0.04])[: shape[0]],
        sigma=np.array([0.02, 0.04])[: shape[0]] / np.sqrt(3),
        tuned__amplitude_m=random.uniform(0.01, 0.02, 3),
        tuned__run_amplitude_m=random.uniform(0.01, 0.02, (9, 3)),
        **{f"{group}__{name}": np.full((*of, 3), value)
           for group, of in (("tuned", ()), ("samples", shape)) for name, value in EVERYWHERE},
        tuned__peak_speed_hz=34.2,
        samples__time_s=np.ones((*shape, 3)),
        tuned__localisation=random.uniform(0.0, 0.1, 3),
        tuned__reference_amplitude_m=0.013,
        tuned__run_peaks_m=np.array([0.012, 0.013, 0.015]),
        samples__status=status,
        samples__amplitude_m=random.gamma(9.0, 0.002, (*shape, 3)),
        samples__localisation=random.uniform(0.1, 0.6, (*shape, 3)),
        samples__peak_amplitude_m=random.gamma(9.0, 0.003, shape),
        samples__amplification=random.gamma(9.0, 0.2, shape),
        samples__linear_amplification=random.gamma(30.0, 0.05, shape),
        statistics__samples_seen=np.arange(1, 13) * 5,
        statistics__contact__mean_of_amplification=random.uniform(1, 2, (2, 3, 12)),
        statistics__contact__convergence_error=random.uniform(1e-3, 1e-2, (2, 3, 12)),
        **more,
    )  # fmt: skip


def modal_file():
    """Three families on seven nodal diameters, pairs of equal modes between the ends."""
    diameters = np.repeat(np.arange(7), [1, 2, 2, 2, 2, 2, 1])
    frequencies = np.concatenate([f + 2.0 * diameters for f in (85.0, 500.0, 1500.0)])
    order = np.argsort(frequencies, kind="stable")
    values = {"nodal_diameters": np.tile(diameters, 3)[order], "frequencies_hz": frequencies[order]}
    return File(
        "study: modal",
        crossing_hz=93.0 / 4,
        **{f"{kind}__{name}": v for kind in ("full", "reduced") for name, v in values.items()},
    )
