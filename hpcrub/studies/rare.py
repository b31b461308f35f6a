"""Small probability of exceeding a limit: disk after disk, until it is known as well as asked."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from hpcrub.config.samples import goal_of, of_question, supposed
from hpcrub.config.schema import Config
from hpcrub.effects.coating import cut_through
from hpcrub.results.layout import PENDING, Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import USELESS, Finding
from hpcrub.runs import findings
from hpcrub.runs.cost import Cost
from hpcrub.runs.job import Round
from hpcrub.setup.disks import deviation
from hpcrub.statistics.percentiles import Z_95, probability_interval
from hpcrub.statistics.rare import Z_OF_TESTS, Goal, n_needed, n_to_be_below
from hpcrub.studies.contact import second_order, trials
from hpcrub.studies.contact.limits import by_limit_line, limits_in_words, percent
from hpcrub.studies.contact.second_order import OF_TRIALS
from hpcrub.studies.contact.trials import Case, Trials, beyond

FIRST_DISKS = 100  # disks of the first estimate
GROWTH = 1.3  # factor on the number of disks from one estimate to the next
ESTIMATE = "probability", "probability_low", "probability_high"
_E = ("estimate",)
LAYOUT = (
    Dataset("n_disks", _E, "1", "disks of every estimate, the first ones drawn", "i8"),
    Dataset("probability", _E, "1", "probability of exceeding a limit; NaN: not estimated"),
    Dataset("probability_low", _E, "1", "lower end of its 95 % interval"),
    Dataset("probability_high", _E, "1", "upper end of its 95 % interval"),
    Dataset("peak_speed_hz", ("sample",), "Hz", "speed of the largest amplitude"),
    *trials.limited_table("sample"),
)


class Rare(Trials):
    """Small probability of exceeding a limit."""

    name = "rare"
    what = "small probability of exceeding a limit"
    sections = ("run_up",)
    datasets = LAYOUT

    def sizes(self, config: Config) -> dict[str, int]:
        """Number of estimates."""
        return {"estimate": len(numbers(config))}

    def constants(self, config: Config) -> dict[str, Any]:
        """Numbers of disks after which there is an estimate."""
        return {"n_disks": numbers(config)}

    def problems(self, config: Config) -> Iterator[str]:
        """Keys that do not fit this study."""
        if goal_of(config) == Goal(None, None):
            yield (
                "limits: a rare study ends by limits.probability_error or "
                "limits.probability_below; give one of them"
            )
        yield from trials.limit_problems(config)
        if config.pattern_deviation is not None:
            yield "mistuning.pattern: one pattern has no probability, a rare study draws disks"
        n, (error, below) = config.mistuning.samples, goal_of(config)
        if below is not None and n < (needed := n_to_be_below(below, 0, Z_OF_TESTS)):
            yield (
                f"mistuning.samples: {n:,} disks cannot show that a probability is below "
                f"limits.probability_below {below:g}, even if none of them exceeds the limit; "
                f"{needed:,} can (6/P), or leave samples out"
            )
        if error is not None and not Goal(error, None).is_met(n, n):
            yield (
                f"mistuning.samples: {n:,} disks tell no probability to limits.probability_error "
                f"{error:g} of itself; leave samples out"
            )

    def needs(self, config: Config) -> str:
        """Number of disks that the goal needs, in words."""
        chance, n = supposed(config), of_question(config) or 0
        return f"the goal needs {n:,} disks if the probability is {chance:.2g}"

    def cost(self, config: Config) -> Cost:
        """Cost of the disks that the goal is supposed to need, at every speed."""
        disks = min(of_question(config) or 0, config.mistuning.samples)
        return Cost(disks + second_order.cost(config), disks=disks)

    def case(self, config: Config, task: int) -> Case:
        """Disk of a task, which is its number."""
        return Case(config, deviation(config, 0, task))

    def next_disks(self, file: ResultFile) -> Round:
        """The pending disks of the next estimate, until the goal is met or no disk is left.

        An estimate depends on its disks alone, whatever else the file holds.
        """
        goal, n, there = goal_of(file.config), numbers(file.config), file.status != PENDING
        n_above = np.cumsum(beyond(file))[n - 1]
        n_known = np.count_nonzero(np.cumsum(there)[n - 1] == n)  # estimates
        met = np.flatnonzero(goal.is_met(n_above[:n_known], n[:n_known]))
        end = int(met[0]) + 1 if len(met) else n_known
        found = np.full((len(ESTIMATE), len(n)), np.nan)
        found[:, :end] = n_above[:end] / n[:end], *probability_interval(n_above, n, Z_95)[:, :end]
        over = len(met) or n_known == len(n)
        tasks = [] if over else np.flatnonzero(~there[: n[end]]).tolist()
        expected = n_needed(goal, found[0, end - 1]) if end else 0
        return Round(tasks, dict(zip(ESTIMATE, found, strict=True)), expected)

    def at_the_answer(self, file: ResultFile, known: Mapping[str, Any]) -> list[int]:
        """The first disks."""
        return np.flatnonzero(file.status != PENDING)[:OF_TRIALS].tolist()

    def report(self, file: ResultFile) -> Iterator[str]:
        """The probability, and the number of disks that it took."""
        yield probability_in_words(file)
        if n := last_estimate(file)[0]:
            yield from by_limit_line(file)
            yield f"{n:,} disks, {np.count_nonzero(beyond(file)[:n]):,} of them beyond the limit"

    def findings(self, file: ResultFile) -> Iterator[Finding]:
        """A probability that is not known well enough, disks without a result, doubtful peaks."""
        config, speeds, computed = file.config, file.config.speeds, file.status != PENDING
        n = last_estimate(file)[0]
        if not (n and goal_of(config).is_met(np.count_nonzero(beyond(file)[:n]), n)):
            yield Finding(
                USELESS, "the probability is not known as well as asked",
                f"{config.mistuning.samples:,} disks do not tell the probability as well as "
                "asked: more mistuning.samples, or another goal in limits",
            )  # fmt: skip
        yield from trials.left_for_others(file)
        names = "peak_amplitude_m", "peak_status", "peak_speed_hz"
        size, states, at = (file.read(name)[computed] for name in names)
        yield from cut_through(config, file.read("deepest_m")[computed], "disks")
        bent = self.second_order_finding(file)
        yield from findings.of_disks(config, size, states, to_second_order=bent)
        if speeds.n_values > 1:
            places = np.searchsorted(speeds.values_hz, at[size > 0.0])
            yield from findings.of_peaks(config, places)


def numbers(config: Config) -> np.ndarray:
    """Numbers of disks after which there is an estimate, increasing (E,)."""
    most, n_disks = config.mistuning.samples, [min(FIRST_DISKS, config.mistuning.samples)]
    while n_disks[-1] < most:
        n_disks.append(min(int(np.ceil(GROWTH * n_disks[-1])), most))
    return np.array(n_disks)


def last_estimate(file: ResultFile) -> tuple[int, np.ndarray]:
    """Number of disks of the last estimate, or 0; probability and ends of its interval (3,)."""
    estimates = np.array([file.read(name) for name in ESTIMATE])
    known = np.flatnonzero(np.isfinite(estimates[0]))
    if not len(known):
        return 0, np.full(3, np.nan)
    return int(file.read("n_disks")[known[-1]]), estimates[:, known[-1]]


def probability_in_words(file: ResultFile) -> str:
    """The probability, in words."""
    limits, (n, (chance, low, high)) = file.config.limits, last_estimate(file)
    if not n:
        return f"probability of exceeding {limits_in_words(file.config)}: not known yet"
    text = (
        f"a disk exceeds {limits_in_words(file.config)} with a probability of {percent(chance)} % "
        f"(95 % interval {percent(low)} to {percent(high)} %)"
    )
    if limits.probability_below is None:
        return text
    n_above = np.count_nonzero(beyond(file)[:n])
    side = ("not certainly below", "above", "below")[goal_of(file.config).side(n_above, n)]
    return f"{text}, {side} the {percent(limits.probability_below)} % asked for"


STUDY = Rare()
