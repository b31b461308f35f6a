"""Lines about limits: largest amplitude, and probabilities of exceeding limits."""

from collections.abc import Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from rich.table import Table

from hpcrub.config.schema import Config
from hpcrub.config.text import percent
from hpcrub.ranks.progress import table
from hpcrub.results.samples import finished, n_failed
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import Z_95, probability_interval
from hpcrub.studies.contact.survey import Survey


def limits_in_words(config: Config) -> str:
    """The limits that are given, such as "30 mm or 350 MPa"."""
    return " or ".join(_by_limit(config, np.zeros(1), np.zeros(1)))


def severity(config: Config, amplitude: np.ndarray, stress: np.ndarray) -> np.ndarray:
    """Amplitude [m] or stress [Pa] over its limit, the larger of both ratios; NaN: no result."""
    ratio = np.where(np.isfinite(amplitude), 0.0, np.nan)
    for part in _by_limit(config, amplitude, stress).values():
        ratio = np.maximum(ratio, part)
    return ratio


def _by_limit(config: Config, amplitude: np.ndarray, stress: np.ndarray) -> dict[str, np.ndarray]:
    """Amplitude or stress over each limit, by the limit in words."""
    limits, ratios = config.limits, {}
    if limits.amplitude_mm is not None:
        ratios[f"{limits.amplitude_mm:g} mm"] = amplitude / limits.amplitude
    if limits.stress is not None:
        by_factor = limits.stress_mpa_per_mm is not None
        of = limits.stress_per_metre * amplitude if by_factor else stress
        ratios[f"{1e-6 * limits.stress:.4g} MPa"] = of / limits.stress
    return ratios


def by_limit_line(file: ResultFile) -> Iterator[str]:
    """Line that says how many of all disks are beyond which limit, where there are several."""
    size = file.read("peak_amplitude_m"), file.read("peak_stress_pa")
    ratios = _by_limit(file.config, *size)
    if len(ratios) > 1:
        counts = (
            f"{np.count_nonzero(ratio > 1.0):,} beyond {words}" for words, ratio in ratios.items()
        )
        yield f"of all disks computed {', '.join(counts)}"


def severities(file: ResultFile) -> np.ndarray:
    """Severity of every disk of a file; NaN where it was not computed, or has no result."""
    return severity(file.config, file.read("peak_amplitude_m"), file.read("peak_stress_pa"))


def largest_line(file: ResultFile, found: Survey) -> Iterator[str]:
    """The largest amplitude of all samples, and the largest stress where it is limited."""
    size = 1e3 * found.largest
    if not size > 0.0:
        return
    text = f"largest amplitude of all samples: {size:.3g} mm"
    stress = max(_stresses(file, level).max(initial=0.0) for level in file.config.levels)
    if stress > 0.0:
        text += f"; largest stress: {1e-6 * stress:,.0f} MPa{_condition(file.config)}"
    yield text


def _stresses(file: ResultFile, level: int) -> Any:
    """Largest stress of every finished disk of a level [Pa]; none where it is not known."""
    if file.config.observes_stress:
        return finished(file, level, "peak_stress_pa")
    if file.config.limits.stress_mpa_per_mm is None:
        return np.zeros(0)
    return file.config.limits.stress_per_metre * finished(file, level, "peak_amplitude_m")


def _condition(config: Config) -> str:
    """Assumption on which a stress rests, in words; empty for one that is just computed."""
    if config.is_goodman:
        return " (raised by Goodman's line for the rotation)"
    if config.limits.stress_mpa_per_mm is None:
        return ""
    return f" (if it moves in the mode for which {config.limits.stress_mpa_per_mm:g} MPa/mm holds)"


def _stress_in_words(config: Any) -> tuple[str, str]:
    """Limit of the stress, and the assumptions on which it rests, which may be none."""
    limits = config.limits
    if config.is_goodman:
        return f"{limits.stress_mpa:g} MPa", (
            ", each stress being raised for the rotation's at its place by Goodman's line to "
            f"{limits.strength_mpa:g} MPa"
        )
    if limits.static_mpa is None:
        basis = f" without the rotation's stress{_condition(config)}"
        return f"{limits.stress_mpa:g} MPa", basis
    return f"{1e-6 * limits.stress:.4g} MPa", (
        f", which {limits.static_mpa:g} MPa of the rotation leave of {limits.stress_mpa:g} MPa"
        f"{_condition(config)}"
    )


class Chance(NamedTuple):
    """How many disks of a level exceed one limit."""

    level: str  # half range
    limit: str
    basis: str  # what the limit rests on; "" for nothing
    above: int  # disks beyond it, or without a result
    n: int  # disks that were computed
    n_lost: int  # disks without a result

    @property
    def interval(self) -> str:
        """95 % interval of the probability."""
        low, high = probability_interval(self.above, self.n, Z_95)
        return f"{percent(low)} to {percent(high)} %"


def chances(file: ResultFile) -> list[Chance]:
    """Disks that exceed each limit, level by level."""
    config, found = file.config, []
    limited: list[tuple[Any, Any, tuple[str, str]]] = []
    if config.limits.amplitude_mm is not None:
        sizes_of = partial(finished, file, name="peak_amplitude_m")
        words = f"{config.limits.amplitude_mm:g} mm"
        limited.append((sizes_of, config.limits.amplitude, (words, "")))
    if config.limits.stress is not None:
        limited.append((partial(_stresses, file), config.limits.stress, _stress_in_words(config)))
    for level, half_range in enumerate(file.read("half_range")):
        lost, name = n_failed(file, level), f"±{100 * half_range:.3g} %"
        for of_level, limit, in_words in limited:
            sizes = of_level(level=level)
            above = int(np.count_nonzero(sizes > limit))
            # a disk without a result is beyond any limit, as in other studies
            found.append(Chance(name, *in_words, above + lost, len(sizes) + lost, lost))
    return found


def chance_table(file: ResultFile, usable: bool) -> Iterator[str | Table]:
    """Table of the probabilities of exceeding the limits by level, and what the limits rest on.

    usable: False adds a warning. Without limits there is none.
    """
    rows = chances(file)
    if not rows:
        return
    caveat = "" if usable else " (not to be signed)"
    headings = "level", "limit", "disks", "beyond", "probability", "95 % interval"
    found = table(f"Probability of exceeding a limit{caveat}", headings)
    for row in rows:
        beyond = f"{row.above:,}" + f" ({row.n_lost:,} without result)" * bool(row.n_lost)
        share = f"{percent(row.above / row.n)} %" if row.n else "-"
        found.add_row(row.level, row.limit, f"{row.n:,}", beyond, share, row.interval)
    yield found
    yield from dict.fromkeys(f"limit: {row.limit}{row.basis}" for row in rows if row.basis)


def limit_lines(file: ResultFile, usable: bool) -> Iterator[str]:
    """Probability of exceeding the limits at the last level; usable: False adds a warning."""
    rows, config = chances(file), file.config
    caveat = "" if usable else "; not to be signed, the verdict says why"
    for row in (row for row in rows if row.level == rows[-1].level):
        words = f"{row.limit}{row.basis}"
        if config.pattern_deviation is not None:  # one disk has no probability
            does = "exceeds" if row.above else "does not exceed"
            done = "has no result" if row.n_lost else f"{does} {words}"
            yield f"the disk of the pattern {done}{caveat}"
            continue
        or_lost = " or have no result" if row.n_lost else ""
        yield (
            f"{row.level}: {row.above} of {row.n} disks exceed {words}{or_lost}, a probability of "
            f"{row.interval} (95 % interval){caveat}"
        )
