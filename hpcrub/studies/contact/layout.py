"""Names, units and meaning of everything in the result file of a contact study, and its writing.

Dimensions: level V, sample n, speed S, blade N, mode, percentile P, and block K = n // step.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from hpcrub import effects
from hpcrub.config.schema import Config
from hpcrub.effects.effect import Kind
from hpcrub.response.quantities import Quantity
from hpcrub.response.sweep import SweepResult
from hpcrub.results import samples
from hpcrub.results.layout import DONE, LEVELS, SPEEDS, Dataset, datasets
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import MOST_ADVICE, SEVERITIES, Verdict
from hpcrub.setup.problem import checks_second_order

AMPLIFICATION = Kind("contact", "amplification", "1", "contact amplifications", "A_nl")
LINEAR = Kind("linear", "linear_amplification", "1", "linear amplifications", "A_lin")
_S, _VN, _VNS = ("speed",), ("level", "sample"), ("level", "sample", "speed")
_BY = ", by order statistics, level by convergence.z; NaN: too few samples"
_RUNS = "amplitudes of the runs of the tuned disk (mistuning.reference)"
_EQUAL = "of a tuned disk of equal blades, whose motion may not stay"
_REFERENCE = "median of run_peaks_m: amplifications are relative to it"
_LINEAR = "largest tangential displacement of any tip under engine-order excitation, linear"
# how the disks that are checked are integrated once more
CHECKS = {"half_step": "with half the time step", "followed": "of motions followed 4 times as long"}
TUNED = (
    Dataset("tuned/run_amplitude_m", ("run", "speed"), "m", f"{_RUNS} at every speed"),
    Dataset("tuned/peak_amplitude_m", (), "m", "largest amplitude over the speeds"),
    Dataset("tuned/run_peaks_m", ("run",), "m", f"peak {_RUNS}"),
    Dataset("tuned/reference_amplitude_m", (), "m", _REFERENCE),
    Dataset("tuned/peak_speed_hz", (), "Hz", "speed of the largest amplitude"),
)
_BENT = "to second order, of the tuned disk and the first samples of the last level"
SECOND_ORDER = (
    Dataset("tuned/second_order_peak_m", ("bent",), "m",
            f"largest amplitude over the speeds {_BENT}; NaN: not computed, infinite: no result"),
    Dataset("tuned/second_order_speed_hz", ("bent",), "Hz", f"speed of that amplitude {_BENT}"),
)  # fmt: skip
SYMMETRIC = (
    Dataset("tuned/symmetric_amplitude_m", _S, "m", f"amplitude {_EQUAL}"),
    Dataset("tuned/symmetric_peak_m", (), "m", f"largest amplitude over the speeds {_EQUAL}"),
)
SAMPLES = (
    Dataset("samples/peak_amplitude_m", _VN, "m", "largest amplitude over the speeds"),
    Dataset("samples/peak_speed_hz", _VN, "Hz", "speed of the largest amplitude"),
    Dataset("samples/amplification", _VN, "1", "peak amplitude over the tuned disk's reference"),
    Dataset("samples/linear_amplitude_m", _VN, "m", _LINEAR),
    Dataset("samples/linear_amplification", _VN, "1", "linear amplitude over the tuned disk's"),
)
STATISTICS = (
    ("percentile", "percentiles of the {} seen"),
    ("percentile_low", f"lower end of the percentiles' confidence intervals{_BY}"),
    ("percentile_high", f"upper end of the percentiles' confidence intervals{_BY}"),
    ("mean_of_percentile", "mean of the percentile values so far"),
    ("convergence_error", "convergence error, Z sqrt(V/k) of k percentile values"),
)
# both are max |u_t|, the largest tangential displacement of any tip with its offset
STEADY = "amplitude_m"
AMPLITUDES = {  # with their names in the glossary
    STEADY: "steady amplitude",
    "largest_amplitude_m": "largest amplitude at any time",
}

MOST_LINES = 1 + MOST_ADVICE  # most lines of the verdict


def layout(config: Config) -> Iterator[Dataset]:
    """Datasets of a study; what only some studies have is there only if they have it.

    The last dataset of a group marks the group as complete: `linear_amplitude_m` of the tuned disk,
    and `status` of samples.
    """
    there = effects.of(config)
    optional = {of for effect in effects.EFFECTS for of in effect.points}
    points = [of for of in SweepResult.declared().values() if of not in optional]
    points += [of for e in there for of in e.points]
    checks = _checks() if config.mistuning.checked_samples else ()
    of_disk = (*checks, *(of for e in there for of in e.peaks))
    yield SPEEDS
    yield from LEVELS
    words = "frequencies of the tuned reduced model"
    yield Dataset("tuned/frequencies_hz", ("mode",), "Hz", words)
    yield from datasets("tuned", _S, points)
    yield from TUNED
    yield from SYMMETRIC if config.mistuning.reference == "staying" else ()
    yield from datasets("tuned", (), of_disk)
    yield from SECOND_ORDER if checks_second_order(config) else ()
    yield from (dataset for e in there for dataset in e.datasets.get("contact", ()))
    yield Dataset("tuned/linear_amplitude_m", (), "m", _LINEAR)
    yield Dataset(
        "samples/deviation", (*_VN, "blade"), "1", "relative stiffness deviation of a blade"
    )
    yield from datasets("samples", _VNS, points)
    yield from datasets("samples", _VN, of_disk)
    yield from SAMPLES
    yield Dataset("samples/status", _VN, "1", "0 pending, 1 done, 2 failed", "u1")
    yield Dataset("trust", ("line",), "1", "the verdict, and what to do about it", "S400")
    yield Dataset("trust_severity", ("line",), "1", f"severity of these lines: {SEVERITIES}", "u1")
    yield Dataset(samples.SEEN, ("block",), "1", "samples seen", "i8")
    for kind in kinds(config):
        for name, text in STATISTICS:
            dimensions = "level", "percentile", "block"
            yield Dataset(kind.dataset(name), dimensions, kind.units, text.format(kind.words))


def _checks() -> Iterator[Quantity]:
    """What the disks that are checked do when they are integrated once more."""
    for name, how in CHECKS.items():
        words = f"largest amplitude over the speeds {how}; NaN: not checked"
        yield Quantity(f"{name}_peak_m", "m", words)
        words = f"share of the speeds at which the amplitude {how} differs by over 10 %"
        yield Quantity(f"{name}_differs", "1", words)


def amplitude(config: Config) -> str:
    """Dataset whose largest value is the peak of a disk; with a coating that of any time."""
    return next((e.amplitude for e in effects.of(config) if e.amplitude), STEADY)


def kinds(config: Config) -> tuple[Kind, ...]:
    """Kinds of numbers of which the file of a study has statistics."""
    return AMPLIFICATION, LINEAR, *(kind for e in effects.of(config) for kind in e.kinds)


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
