"""Stress of the blades, where a limit asks for it and the disk knows it."""

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.effects.effect import Effect, History, Kind, largest, range_of_disks
from hpcrub.response.quantities import Quantity
from hpcrub.response.sweep import SweepResult
from hpcrub.results.layout import Dataset
from hpcrub.results.storage import ResultFile

PEAK = Quantity("peak_stress_pa", "Pa", "largest stress over the speeds")
OF_HISTORY = Dataset(
    "stress_pa", ("disk", "time", "stress"), "Pa", "stress at each place; both faces of a root"
)
OF_ENERGY = (
    Dataset("tuned/stress_pa", ("speed",), "Pa", "largest stress of the tuned disk's blades"),
    Dataset("stress_pa", ("sample", "speed"), "Pa", "largest stress of any blade"),
)


class Stress(Effect):
    """Largest stress of the blades."""

    name = "stress"
    datasets: ClassVar = {"time_response": (OF_HISTORY,), "energy": OF_ENERGY}
    points = (SweepResult.declared()["stress"],)
    peaks = (PEAK,)
    kinds = (Kind("stress", PEAK.name, "Pa", "largest stresses of any speed"),)

    def exists(self, config: Config) -> bool:
        """Whether stresses are limited, and computed rather than estimated."""
        return config.observes_stress

    def sizes(self, config: Config) -> dict[str, int]:
        """Number of places at which stresses are known."""
        return {"stress": config.disk.n_stresses or 2 * config.disk.n_blades}

    def of_disk(self, result: SweepResult, speeds_hz: np.ndarray) -> dict[str, float]:
        """Largest stress over the speeds."""
        return {PEAK.name: largest(result.stress, speeds_hz)[0]}

    def of_history(self, study: str, history: History) -> Iterator[tuple[str, Any]]:
        """Stresses at all places over the time."""
        if study == "time_response":
            yield OF_HISTORY.name, history.position @ history.modes.stress.T

    def lines(self, file: ResultFile, disk: int) -> Iterator[str]:
        """Largest stress of a motion, or range over the disks of an energy study."""
        if file.config.study == "time_response":
            stress = np.abs(file.read("stress_pa", disk)).max()
            yield f"largest stress {1e-6 * stress:,.0f} MPa"
        elif file.config.study == "energy":
            low, high, tuned = (1e-6 * size for size in range_of_disks(file, "stress_pa"))
            yield f"largest stress {low:,.0f} to {high:,.0f} MPa, tuned {tuned:,.0f}"
