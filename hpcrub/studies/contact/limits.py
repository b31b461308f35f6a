"""Lines about limits: largest amplitude, and probabilities of exceeding limits."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from rich.table import Table

from hpcrub.config.schema import Config
from hpcrub.config.text import percent
from hpcrub.ranks.progress import table
from hpcrub.results.samples import finished, n_failed
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import Z_95, probability_interval
from hpcrub.studies.contact.survey import Survey

AMPLITUDE, STRESS = SIZES = "peak_amplitude_m", "peak_stress_pa"  # what limits are of


class Limit(NamedTuple):
    """A limit of the input, of one of SIZES times a factor."""

    words: str  # such as "350 MPa"
    value: float  # [m] or [Pa]
    of: str = AMPLITUDE
    factor: float = 1.0
    basis: str = ""  # what it rests on
    condition: str = ""  # assumption on which a stress rests; "" for one that is just computed


def limits_of(config: Config) -> list[Limit]:
    """The limits that are given."""
    limits, found = config.limits, []
    if limits.amplitude_mm is not None:
        found.append(Limit(f"{limits.amplitude_mm:g} mm", limits.amplitude))
    if limits.stress is None:
        return found
    words, of, factor, condition = f"{limits.stress_mpa:g} MPa", STRESS, 1.0, ""
    if limits.stress_mpa_per_mm is not None:
        of, factor, slope = AMPLITUDE, limits.stress_per_metre, limits.stress_mpa_per_mm
        condition = f" (if it moves in the mode for which {slope:g} MPa/mm holds)"
    if config.is_goodman:
        condition = " (raised by Goodman's line for the rotation)"
        basis = (
            ", each stress being raised for the rotation's at its place by Goodman's line to "
            f"{limits.strength_mpa:g} MPa"
        )
    elif limits.static_mpa is None:
        basis = f" without the rotation's stress{condition}"
    else:
        left = f", which {limits.static_mpa:g} MPa of the rotation leave of "
        words, basis = f"{1e-6 * limits.stress:.4g} MPa", f"{left}{words}{condition}"
    return [*found, Limit(words, limits.stress, of, factor, basis, condition)]


def limits_in_words(config: Config) -> str:
    """The limits that are given, such as "30 mm or 350 MPa"."""
    return " or ".join(limit.words for limit in limits_of(config))


def severity(config: Config, amplitude: np.ndarray, stress: np.ndarray) -> np.ndarray:
    """Amplitude [m] or stress [Pa] over its limit, the larger of both ratios; NaN: no result."""
    ratio, sizes = np.where(np.isfinite(amplitude), 0.0, np.nan), {AMPLITUDE: amplitude}
    sizes[STRESS] = stress
    for limit in limits_of(config):
        ratio = np.maximum(ratio, limit.factor * sizes[limit.of] / limit.value)
    return ratio


def by_limit_line(file: ResultFile) -> Iterator[str]:
    """Line that says how many of all disks are beyond which limit, where there are several."""
    limits = limits_of(file.config)
    if len(limits) > 1:
        counts = (
            f"{np.count_nonzero(limit.factor * file.read(limit.of) > limit.value):,} beyond "
            f"{limit.words}"
            for limit in limits
        )
        yield f"of all disks computed {', '.join(counts)}"


def severities(file: ResultFile) -> np.ndarray:
    """Severity of every disk of a file; NaN where it was not computed, or has no result."""
    return severity(file.config, *map(file.read, SIZES))


def largest_line(file: ResultFile, found: Survey) -> Iterator[str]:
    """The largest amplitude of all samples, and the largest stress where it is limited."""
    size = 1e3 * found.largest
    if not size > 0.0:
        return
    text = f"largest amplitude of all samples: {size:.3g} mm"
    for limit in (limit for limit in limits_of(file.config) if "Pa" in limit.words):
        of_levels = (_sizes(file, level, limit) for level in file.config.levels)
        stress = max(sizes.max(initial=0.0) for sizes in of_levels)
        text += f"; largest stress: {1e-6 * stress:,.0f} MPa{limit.condition}"
    yield text


def _sizes(file: ResultFile, level: int, limit: Limit) -> np.ndarray:
    """What a limit is of, of every finished disk of a level [m] or [Pa]."""
    return limit.factor * finished(file, level, limit.of)


class Chance(NamedTuple):
    """How many disks of a level exceed one limit."""

    level: str  # half range
    limit: Limit
    above: int  # disks beyond it, or without a result
    n: int  # disks that were computed
    n_lost: int  # disks without a result

    @property
    def interval(self) -> str:
        """95 % interval of the probability."""
        low, high = probability_interval(self.above, self.n, Z_95)
        return f"{percent(low)} to {percent(high)} %"


def chances(file: ResultFile) -> Iterator[Chance]:
    """Disks that exceed each limit, level by level."""
    for level, half_range in enumerate(file.read("half_range")):
        lost, name = n_failed(file, level), f"±{100 * half_range:.3g} %"
        for limit in limits_of(file.config):
            sizes = _sizes(file, level, limit)
            above = int(np.count_nonzero(sizes > limit.value))
            # a disk without a result is beyond any limit, as in other studies
            yield Chance(name, limit, above + lost, len(sizes) + lost, lost)


def chance_table(file: ResultFile, usable: bool) -> Iterator[str | Table]:
    """Table of the probabilities of exceeding the limits by level, and what the limits rest on.

    usable: False adds a warning. Without limits there is none.
    """
    rows = list(chances(file))
    if not rows:
        return
    caveat = "" if usable else " (not to be signed)"
    headings = "level", "limit", "disks", "beyond", "probability", "95 % interval"
    found = table(f"Probability of exceeding a limit{caveat}", headings)
    for row in rows:
        beyond = f"{row.above:,}" + f" ({row.n_lost:,} without result)" * bool(row.n_lost)
        share = f"{percent(row.above / row.n)} %" if row.n else "-"
        found.add_row(row.level, row.limit.words, f"{row.n:,}", beyond, share, row.interval)
    yield found
    limits = limits_of(file.config)
    yield from (f"limit: {limit.words}{limit.basis}" for limit in limits if limit.basis)


def limit_lines(file: ResultFile, usable: bool) -> Iterator[str]:
    """Probability of exceeding the limits at the last level; usable: False adds a warning."""
    caveat = "" if usable else "; not to be signed, the verdict says why"
    for row in list(chances(file))[-len(limits_of(file.config)) :]:
        words = f"{row.limit.words}{row.limit.basis}"
        if file.config.pattern_deviation is not None:  # one disk has no probability
            does = "exceeds" if row.above else "does not exceed"
            done = "has no result" if row.n_lost else f"{does} {words}"
            yield f"the disk of the pattern {done}{caveat}"
            continue
        or_lost = " or have no result" if row.n_lost else ""
        yield (
            f"{row.level}: {row.above} of {row.n} disks exceed {words}{or_lost}, a probability of "
            f"{row.interval} (95 % interval){caveat}"
        )
