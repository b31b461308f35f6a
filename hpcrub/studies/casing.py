"""The casing: its radius around the circumference, and how its bumps grow."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.model.casing import casing_height, ramp
from hpcrub.results.layout import Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.studies.study import Poll, Study, Values

N_ANGLES, N_TIMES = 2401, 201
LAYOUT = (
    Dataset("angle_rad", ("angle",), "rad", "angle around the casing"),
    Dataset("inward_m", ("angle",), "m", "inward deformation of the fully grown casing"),
    Dataset("gap_m", ("angle",), "m", "gap to the circle of the tips at rest"),
    Dataset("growth_time_s", ("time",), "s", "time"),
    Dataset("growth", ("time",), "1", "growth factor of the bumps"),
)
SCALES = {"angle": "angle_rad", "time": "growth_time_s"}


def sizes(config: Config) -> dict[str, int]:
    """Length of every dimension."""
    return {"angle": N_ANGLES, "time": N_TIMES}


def constants(config: Config) -> dict[str, Any]:
    """The scales."""
    longest = 1.2 * config.casing.growth_time
    return {
        "angle_rad": np.linspace(0, 2 * np.pi, N_ANGLES),
        "growth_time_s": np.linspace(0, longest, N_TIMES),
    }


def compute(config: Config, problem: Any, task: int, poll: Poll) -> Iterator[Values]:
    """Casing and growth."""
    casing, scales = config.casing, constants(config)
    inward = casing_height(scales["angle_rad"], *casing.shape)
    yield "inward_m", (), inward
    yield "gap_m", (), casing.clearance - inward
    yield "growth", (), [ramp(t, casing.growth_time) for t in scales["growth_time_s"]]


def report(file: ResultFile) -> Iterator[str]:
    """The smallest gap."""
    gap = 1e3 * file.read("gap_m").min()
    touches = "" if gap < 0.0 else ": the tips at rest never touch"
    yield f"{file.config.casing.words}, smallest gap at rest {gap:.3f} mm{touches}"


STUDY = Study(
    name="casing",
    figures="1, 3",
    what="casing, clearance and bumps",
    layout=lambda config: LAYOUT,
    scales=SCALES,
    sizes=sizes,
    prepare=lambda config: None,
    constants=constants,
    has_disk=False,
    compute=compute,
    report=report,
)
