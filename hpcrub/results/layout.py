"""Description of the datasets of a result file, as far as the files of all studies share it.

Every axis of every dataset has a dimension scale, so that xarray and netCDF know it by name: a
dataset with the values along it where the study names one, else numbers from 0 (`index_scale`).
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from hpcrub.response.quantities import Quantity

# Number of the layout, an attribute of every file. Whoever changes the name, the dimensions or the
# meaning of a dataset raises it.
NUMBER = 8

Values = tuple[str, Any, Any]  # dataset, where in it, values

PENDING, DONE, FAILED = 0, 1, 2  # status of a sample or task
OVERHEAD = 1024  # [bytes] of the name and attributes of a dataset, about


class Dataset(NamedTuple):
    """Description of one dataset: a line of the file's layout."""

    name: str
    dimensions: tuple[str, ...]
    units: str
    description: str
    dtype: str = "f8"


class Plan(NamedTuple):
    """Everything that is known of a result file before the study begins."""

    config: Any  # Config
    lines: tuple[Dataset, ...]
    lengths: dict[str, int]  # of every dimension
    scales: dict[str, str]  # dimension: dataset with the values along it
    values: dict[str, Any]  # values of the datasets that are known already
    attributes: dict[str, Any]  # attributes of the root, besides those that every file has


def file_size(lines: Sequence[Dataset], lengths: dict[str, int]) -> int:
    """Return the size of a result file with these datasets [bytes]."""
    return sum(
        math.prod(lengths[d] for d in line.dimensions) * np.dtype(line.dtype).itemsize + OVERHEAD
        for line in lines
    )


def datasets(
    group: str, dimensions: tuple[str, ...], quantities: Iterable[Quantity]
) -> Iterator[Dataset]:
    """Datasets of some quantities, over the same dimensions; group: "" for the file's root."""
    prefix = f"{group}/" if group else ""
    return (Dataset(prefix + of.name, dimensions, *of[1:4]) for of in quantities)


SPEEDS = Dataset("speeds_hz", ("speed",), "Hz", "speeds of rotation")
LEVELS = (
    Dataset(
        "half_range", ("level",), "1", "mistuning levels: largest deviation of a blade's stiffness"
    ),
    Dataset(
        "sigma", ("level",), "1", "mistuning levels: standard deviation of a blade's stiffness"
    ),
)
ANGLE = Dataset("angle_deg", ("angle",), "degree", "begins of equal parts of the casing")

_INDEX = {
    "sample": "number of the sample in the whole study",
    "percentile": "percentile",
    "task": "number of the task",
    "blade": "number of the blade, from 1",
    "strip": "number of the strip of the coating, from 0 at its smallest axial place",
}


def index_scale(dimension: str, name: str) -> Dataset:
    """Return the scale `name` for a dimension along which no dataset has values."""
    words = _INDEX.get(dimension, f"number of the {dimension.replace('_', ' ')}, from 0")
    units, dtype = ("percent", "f8") if dimension == "percentile" else ("1", "i8")
    return Dataset(name, (dimension,), units, words, dtype)


PEAK_STATUS = "status of the point of the largest amplitude, as point_status"
