"""Value of a key at which the probability of exceeding a limit crosses a target.

The same disks are drawn at every value; `statistics.threshold` tells which ones to compute.
"""

import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from hpcrub.config.checks import keys_without_effect
from hpcrub.config.schema import Config
from hpcrub.config.study_keys import MOST_VALUES
from hpcrub.config.text import flatten
from hpcrub.errors import InputError
from hpcrub.results.layout import PENDING, Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import USELESS, Finding
from hpcrub.runs import findings
from hpcrub.runs.cost import Cost
from hpcrub.runs.job import Round
from hpcrub.setup.disks import deviation
from hpcrub.setup.problem import build_problem
from hpcrub.statistics.percentiles import Z_95, probability_interval
from hpcrub.statistics.threshold import UNKNOWN, Search, coarse
from hpcrub.studies.contact.limits import percent
from hpcrub.studies.contact.trials import Case, Trials, beyond, limit_problems, table

NEVER_KEYS = (
    *("study", "output", "sources", "part.", "threshold.", "limits.", "convergence."),
    *(f"mistuning.{name}" for name in ("seed", "samples", "tuned_runs", "checked_samples")),
)
LOOKS = 1.5  # values per bisection that need as many disks as the target asks for
CLOSE = 2  # values so close to the crossing that they need all disks
NUMBERS_IN_TEXT = re.compile(r"\d[\d., ]*(e[-+]?\d+)?")  # in a warning
_V = ("value",)
LAYOUT = (
    Dataset("value", _V, "1", "values of the key, in its own unit"),
    Dataset("n_disks", _V, "1", "disks computed at every value, the first ones drawn", "i8"),
    Dataset("n_above", _V, "1", "those beyond the limit, or without a result", "i8"),
    Dataset("probability_low", _V, "1", "lower end of the 95 % interval of the probability"),
    Dataset("probability_high", _V, "1", "upper end of the 95 % interval of the probability"),
    Dataset("side", _V, "1", "probability certainly below (-1) or above (1) the target", "i8"),
    Dataset("crossing", ("end",), "1", "values on either side of the crossing; NaN: none"),
    *table("value", "sample"),
    Dataset("status", ("value", "sample"), "1", "0 pending, 1 done", "u1"),
)


class Threshold(Trials):
    """Search for the value of a key that meets a limit with a given probability."""

    name = "threshold"
    what = "value of a key that meets a limit with a probability"
    sections = ("threshold",)
    datasets = LAYOUT

    def sizes(self, config: Config) -> dict[str, int]:
        """Lengths of this study's own dimensions."""
        return {"value": len(config.threshold.values), "end": 2}

    def constants(self, config: Config) -> dict[str, Any]:
        """Values of the key."""
        return {"value": config.threshold.values}

    def problems(self, config: Config) -> Iterator[str]:
        """Keys that do not fit this study."""
        yield from limit_problems(config)
        key = config.threshold.key
        if key is None:
            yield "threshold.key: missing; the key whose value is searched for is needed"
            return
        if key.startswith(NEVER_KEYS):
            yield f"threshold.key: {key} changes no disk"
            return
        most = MOST_VALUES - 1
        if config.threshold.highest - config.threshold.lowest > most * config.threshold.tolerance:
            yield (
                f"threshold.tolerance: {config.threshold.tolerance} divides the range into more "
                f"than {most} steps"
            )
        for value in map(float, config.threshold.values):
            try:
                at_value(config, value)
            except InputError as error:
                yield f"threshold.key: {value:g}: {error}"
                return
        for line in keys_without_effect(at_value(config, config.threshold.highest)):
            if line.startswith(f"{key}:"):
                yield f"threshold.key: {line}"

    def warnings(self, config: Config, prepared: Any) -> Iterator[str]:
        """Warnings at both ends of the range; the lower end's where they differ in numbers only.

        The input's own value of the key, of which `prepared` is, is not computed.
        """
        key, found = config.threshold.key, dict[str, list[tuple[float, str]]]()
        for value in map(float, config.threshold.values[[0, -1]]):
            here = at_value(config, value)
            for line in super().warnings(here, build_problem(here)):
                found.setdefault(NUMBERS_IN_TEXT.sub("#", line), []).append((value, line))
        for (value, line), *others in found.values():
            if (line,) == tuple(other for _, other in others):
                yield line
            else:
                also = "".join(f"; also at {other:g}" for other, _ in others)
                yield f"{line} (at {key} = {value:g}{also})"

    def needs(self, config: Config) -> str:
        """Number of values, and of disks that the search is expected to need, in words."""
        n_values, disks = len(config.threshold.values), self.cost(config).disks
        return (  # where the probability is steep it is a third, where it is flat three times
            f"for {n_values} values of {config.threshold.key}, together about {disks:,} disks, "
            "give or take a factor of three"
        )

    def cost(self, config: Config) -> Cost:
        """Cost of the disks that a few values need until their intervals leave out the target."""
        # the interval by so many disks, none of them beyond the limit, leaves out the target
        n_values, most = len(config.threshold.values), config.mistuning.samples
        needed = min(4.6 / config.threshold.probability, most)
        disks = round(LOOKS * np.log2(n_values) * needed + CLOSE * most)
        disks = min(disks, n_values * most)
        return Cost(disks, disks=disks)

    def tried(self, config: Config) -> list[Config]:
        """Inputs at values over the whole range, whose disks may differ tenfold in their cost."""
        values = config.threshold.values
        return [at_value(config, float(value)) for value in values[coarse(len(values))]]

    def case(self, config: Config, task: tuple[int, int]) -> Case:
        """Input and disk of a task; task: indices of value and disk."""
        here = at_value(config, float(config.threshold.values[task[0]]))
        return Case(here, deviation(here, 0, task[1]), task)

    def next_round(self, file: ResultFile) -> Round:
        """The pending disks of the next value to test; its order does not depend on other disks."""
        config, there = file.config, file.status != PENDING
        search = Search.followed(beyond(file), there, config.threshold.probability)
        known, tasks, phase = results(config, search), [], self.unit
        if look := search.next_look():
            value, n = look
            tasks = [(value, int(i)) for i in np.flatnonzero(~there[value, :n])]
            # the first values lie over the whole range, unlike all others
            phase += " over the range" if value in coarse(len(there)) else " near the crossing"
        return Round(tasks, known, self.cost(config).disks, phase)

    def report(self, file: ResultFile) -> Iterator[str]:
        """The value that meets the limit, and the number of disks that the search took."""
        yield answer(file)
        n_done, n_values = int(file.read("n_disks").sum()), len(file.config.threshold.values)
        share = n_done / (n_values * file.config.mistuning.samples)
        yield (
            f"{n_done:,} disks at {np.count_nonzero(file.read('n_disks'))} of {n_values} values, "
            f"{percent(share)} % of all disks at all values"
        )

    def findings(self, file: ResultFile) -> Iterator[Finding]:
        """A crossing that is not certain, or several crossings."""
        search, config = search_of(file), file.config
        if search.next_look() is None and (search.sides()[[0, -1]] == UNKNOWN).any():
            yield Finding(
                USELESS, "the ends are not certain",
                "at an end of the range the probability is too close to the target for "
                f"{config.mistuning.samples} disks: mistuning.samples, or another range",
            )  # fmt: skip
        if not search.is_monotone():
            yield Finding(
                USELESS, "several crossings",
                f"the probability rises and falls again with {config.threshold.key}: one of "
                "several crossings is told; draw the figure, and search on parts of the range",
            )  # fmt: skip
        computed = np.arange(search.most) < search.n_done[:, None]
        names = "peak_amplitude_m", "peak_status"
        yield from findings.of_disks(config, *(file.read(name)[computed] for name in names))


def results(config: Config, search: Search) -> dict[str, Any]:
    """What a search tells, by the names in the result file."""
    ends = probability_interval(search.n_above, search.n_done, Z_95)
    low, high = np.where(search.n_done > 0, ends, np.nan)
    crossing = search.crossing()
    return {
        "n_disks": search.n_done,
        "n_above": search.n_above,
        "probability_low": low,
        "probability_high": high,
        "side": search.sides(),
        "crossing": config.threshold.values[list(crossing)] if crossing else np.full(2, np.nan),
    }


def at_value(config: Config, value: float) -> Config:
    """The configuration with a value of the key. Raises InputError for one that is not allowed."""
    key = config.threshold.key or ""
    before = flatten(config.model_dump(mode="json")).get(key)
    number = int(value) if isinstance(before, int) and value.is_integer() else value
    return config.replace({key: [number] if isinstance(before, list) else number})


def search_of(file: ResultFile) -> Search:
    """State of the search in a result file."""
    n_disks, n_above = file.read("n_disks"), file.read("n_above")
    most = file.config.mistuning.samples
    return Search(n_disks, n_above, file.config.threshold.probability, most)


def answer(file: ResultFile) -> str:
    """The value that meets the limit, in words."""
    asked, (low, high) = file.config.threshold, file.read("crossing")
    what = f"the probability of exceeding the limit crosses {100 * asked.probability:g} %"
    if np.isfinite(low):
        fall = file.read("side")[0] > 0
        return (
            f"{what} between {asked.key} = {low:g} and {high:g}; it "
            f"{'falls' if fall else 'rises'}, so {high if fall else low:g} is on the safe side"
        )
    sides = file.read("side")[[0, -1]]
    if UNKNOWN in sides:
        return f"{what} at no value of {asked.key} that is known yet"
    words = "below" if sides[0] < 0 else "above"
    ends = f"{asked.lowest:g} and {asked.highest:g}"
    return (
        f"{what} at no value: at {asked.key} = {ends}, and at the values computed between them, it "
        f"is {words} that"
    )


STUDY = Threshold()
