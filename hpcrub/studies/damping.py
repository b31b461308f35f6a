"""Percentiles of several contact studies that differ in their damping, with intervals."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from hpcrub.config.schema import Config, differences
from hpcrub.errors import InputError
from hpcrub.results.layout import Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import Z_95, percentile_interval
from hpcrub.studies.sources import PHYSICS, amplifications, complete
from hpcrub.studies.study import Poll, Study, Values

KINDS = ("contact", "linear")
FREE = "material.damping_ratio"
# what, besides the physics, sets one population of disks apart from another
SAME = (
    *PHYSICS,
    *(
        f"mistuning.{key}"
        for key in (
            "half_range_percent",
            "distribution",
            "truncation",
            "measured_percent",
            "neighbour_correlation",
            "intentional_percent",
            "pattern_gpa",
            "pattern_percent",
            "blade_frequencies_hz",
            "patterns_unit",
            "patterns_sha256",
            "by",
        )
    ),
)
_CLP = ("case", "level", "percentile")
LAYOUT = (
    Dataset("damping_ratio", ("case",), "1", "damping ratio of every mode"),
    Dataset("tuned_amplitude_m", ("case",), "m", "peak of the tuned disk in contact"),
    Dataset("sigma", ("level",), "1", "standard deviation of a blade's stiffness"),
    *(
        line
        for kind in KINDS
        for line in (
            Dataset(f"{kind}/percentile", _CLP, "1", f"percentiles of the {kind} amplification"),
            Dataset(f"{kind}/interval", (*_CLP, "bound"), "1", "their 95 % intervals"),
        )
    ),
)
SCALES = {"case": "damping_ratio", "level": "sigma"}


def sizes(config: Config) -> dict[str, int]:
    """Length of every dimension that the sources do not tell."""
    n_percentiles = len(config.convergence.percentiles)
    return {"case": len(config.sources), "percentile": n_percentiles, "bound": 2}


def source_sizes(config: Config) -> dict[str, int]:
    """Length of the other one."""
    file = complete(config.sources[0])
    n_levels = len(file.read("sigma"))
    file.close()
    return {"level": n_levels}


def constants(config: Config) -> dict[str, Any]:
    """Damping of the sources and their levels.

    Raises InputError when they differ in their levels or in other physics than the damping; they
    may have other samples and seeds.
    """
    files = [complete(path) for path in config.sources]
    for file in files:
        if file.config.material.damping_ratios is not None:
            raise InputError(
                f"sources: {file.path} has material.damping_ratios; files of one damping ratio "
                "each can be compared"
            )
    for file in files[1:]:
        _compare(files[0], file)
    values = {
        "damping_ratio": [file.config.material.damping_ratio for file in files],
        "tuned_amplitude_m": [file.read("tuned/reference_amplitude_m") for file in files],
        "sigma": files[0].read("sigma"),
    }
    for file in files:
        file.close()
    return values


def _compare(first, other):
    found = differences(first.config, other.config, ("in the first", "in the second"))
    keys = (line.partition(":")[0] for line in found)
    wrong = [
        line
        for key, line in zip(keys, found, strict=True)
        if key != FREE and any(key == same or key.startswith(f"{same}.") for same in SAME)
    ]
    if wrong:
        raise InputError(f"sources: {first.path} and {other.path} differ in {'; '.join(wrong)}")


def prepare(config: Config) -> Any:
    """Configuration and amplifications of all sources. Raises InputError as `constants`."""
    constants(config)
    return config, [amplifications(path) for path in config.sources]


def compute(config: Config, problem: Any, task: int, poll: Poll) -> Iterator[Values]:
    """Percentiles with their intervals."""
    config, sources = problem
    for case, source in enumerate(sources):
        for kind, values in zip(KINDS, source, strict=True):
            for level, found in enumerate(values):
                known = found[np.isfinite(found)]
                at = config.convergence.percentiles
                if len(known):
                    yield f"{kind}/percentile", (case, level), np.percentile(known, at)
                interval = np.transpose(percentile_interval(known, at, Z_95))
                yield f"{kind}/interval", (case, level), interval


def report(file: ResultFile) -> Iterator[str]:
    """The last percentile at the widest level."""
    percentile = file.config.convergence.percentiles[-1]
    for case, damping in enumerate(file.read("damping_ratio")):
        for kind in KINDS:
            value = file.read(f"{kind}/percentile", (case, -1, -1))
            low, high = file.read(f"{kind}/interval", (case, -1, -1))
            yield (
                f"damping {damping:g}, {kind}, percentile {percentile:g} at the widest level: "
                f"{value:.3f} [{low:.3f}, {high:.3f}]"
            )


STUDY = Study(
    name="damping",
    figures="16",
    what="percentiles of contact studies with different damping",
    layout=lambda config: LAYOUT,
    scales=SCALES,
    sizes=sizes,
    constants=constants,
    source_sizes=source_sizes,
    prepare=prepare,
    n_sources=2,
    has_disk=False,
    compute=compute,
    report=report,
)
