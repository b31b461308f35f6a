"""Reading and writing samples, the tuned disk and statistics in the file of a contact study."""

from typing import Any

import numpy as np

from hpcrub.results.layout import DONE
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import Verdict
from hpcrub.studies.contact.layout import MOST_LINES, Kind, layout


def names(file: ResultFile, group: str) -> list[str]:
    """Names of the datasets in a group of a file; the last one marks the group as complete."""
    parts = [line.name.partition("/") for line in layout(file.config)]
    return [name for of, _, name in parts if of == group]


def write_tuned(file: ResultFile, values: dict[str, Any]) -> None:
    """Write the results of the tuned disk, by their names in the group; one rank."""
    file.write({f"tuned/{n}": values[n] for n in names(file, "tuned") if n in values}, ())


def write_sample(file: ResultFile, level: int, sample: int, values: dict[str, Any]) -> None:
    """Write one sample, its status last; one rank.

    values: {name in the group: value}, `status` included; a failed sample may lack all others.
    Raises WriteError when the file cannot be written.
    """
    there = {f"samples/{n}": values[n] for n in names(file, "samples") if n in values}
    status = {"samples/status": there.pop("samples/status")}
    file.write(there, (level, sample))
    file.write(status, (level, sample))


def is_untouched(file: ResultFile) -> bool:
    """Whether no disk moves, because the casing never reaches the blades."""
    return bool(file.read("tuned/reference_amplitude_m") == 0.0)


def write_untouched(file: ResultFile) -> None:
    """Write all samples as those of disks that nothing touches, which are like the tuned one."""
    there = set(names(file, "tuned")) & set(names(file, "samples"))
    alike = {f"samples/{name}": file.read(f"tuned/{name}") for name in there}
    for name, values in alike.items():
        whole = np.broadcast_to(values, file.shape(name)[:2] + np.shape(values))
        file.write({name: whole}, ())
    file.write({"samples/status": np.full(file.shape("samples/status"), DONE)}, ())


def write_statistics(file: ResultFile, kind: Kind, level: int, running: Any) -> None:
    """Write the RunningPercentiles of one level; one rank.

    Blocks beyond the last one of `running` become NaN.
    """
    for name, values in running._asdict().items():
        dataset = kind.dataset(name)
        padded = np.full(file.shape(dataset)[1:], np.nan)
        padded[:, : values.shape[1]] = values
        file.write({dataset: padded}, (level,))


def write_verdict(file: ResultFile, verdict: Verdict) -> None:
    """Write a verdict and its advice, with their severities; one rank."""
    texts = np.zeros(MOST_LINES, dtype=file.dtype("trust"))
    severities = np.zeros(MOST_LINES, dtype=np.uint8)
    for place, text in enumerate(verdict.lines):
        texts[place] = text.encode()[: texts.itemsize]
    of_lines = [verdict.severity, *(finding.severity for finding in verdict.advice)]
    severities[: len(of_lines)] = of_lines
    file.write({"trust": texts, "trust_severity": severities}, ())
