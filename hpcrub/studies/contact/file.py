"""What contact studies keep beside other studies: samples, the tuned disk, running percentiles."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from hpcrub.results.storage import ResultFile
from hpcrub.studies.contact.layout import MOST_LINES, SAMPLE, TUNED


def read_tuned(file: ResultFile) -> dict[str, Any] | None:
    """Results of the tuned disk by name, None when they are not complete."""
    names = {name: f"tuned/{name}" for name in TUNED}
    values = {name: file.read(at) for name, at in names.items() if at in file}
    return values if np.isfinite(values["linear_amplitude_m"]) else None


def write_tuned(file: ResultFile, values: dict[str, Any]) -> None:
    """Write the results of the tuned disk, a dict by the names in `layout.TUNED`; one rank."""
    file.write(_present(file, "tuned", TUNED, values), ())


def write_sample(file: ResultFile, level: int, sample: int, values: dict[str, Any]) -> None:
    """Write one sample, its status last; one rank.

    values: by the names in `layout.SAMPLE`, `status` included; others may be missing in a failed
    one. Raises WriteError when the file cannot be written.
    """
    present = _present(file, "samples", SAMPLE, values)
    status = {"samples/status": present.pop("samples/status")}
    file.write(present, (level, sample))
    file.write(status, (level, sample))


def write_statistics(file: ResultFile, kind: str, level: int, running: Any) -> None:
    """Write the RunningPercentiles of one level; one rank.

    Blocks beyond its last become NaN.
    """
    lines = running._asdict()
    lines.pop("samples_seen")  # known since the file was laid out
    for name, values in lines.items():
        dataset = f"statistics/{kind}/{name}"
        padded = np.full(file.shape(dataset)[1:], np.nan)
        padded[:, : values.shape[1]] = values
        file.write({dataset: padded}, (level,))


def write_trust(file: ResultFile, lines: Iterable[str]) -> None:
    """Write the lines of the trust block, as many as there is place for; one rank."""
    texts = np.zeros(MOST_LINES, dtype=file.dtype("trust"))
    for place, text in zip(range(MOST_LINES), lines, strict=False):
        texts[place] = text.encode()[: texts.itemsize]
    file.write({"trust": texts}, ())


def read_trust(file: ResultFile) -> list[str]:
    """Lines of the trust block; none of a study that has none."""
    texts = file.read("trust") if "trust" in file else []
    return [text.decode(errors="ignore") for text in texts if text]


def _present(file, group, names, values):
    """{dataset: value} of those that this file has, in the order of names."""
    pairs = ((f"{group}/{name}", values[name]) for name in names if name in values)
    return {name: value for name, value in pairs if name in file}
