"""Value of a key at which the probability of exceeding a limit crosses a target.

The same disks are drawn at every value; `statistics.threshold` tells which ones to compute.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from rich.table import Table

from hpcrub.config.checks import keys_without_effect
from hpcrub.config.schema import Config
from hpcrub.config.study_keys import MOST_VALUES
from hpcrub.config.text import name_and_unit
from hpcrub.effects.coating import cut_through
from hpcrub.errors import InputError
from hpcrub.ranks.progress import table
from hpcrub.results.layout import PENDING, Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import SINGLE, USELESS, Finding
from hpcrub.runs import findings
from hpcrub.runs.cost import Cost
from hpcrub.runs.job import Round
from hpcrub.setup.disks import deviation
from hpcrub.setup.problem import build_problem
from hpcrub.statistics import threshold as statistics
from hpcrub.statistics.percentiles import Z_95, probability_interval
from hpcrub.statistics.rare import Goal, n_needed
from hpcrub.statistics.threshold import ABOVE, BELOW, FIRST_DISKS, UNKNOWN, Search
from hpcrub.studies.contact import second_order, trials
from hpcrub.studies.contact.limits import by_limit_line, limits_in_words, percent, severities
from hpcrub.studies.contact.second_order import OF_TRIALS

NEVER_KEYS = (
    *("study", "output", "sources", "part.", "threshold.", "limits.", "convergence."),
    *(f"mistuning.{name}" for name in ("seed", "samples", "tuned_runs", "checked_samples")),
)
OF_KEY = "value", "crossing"  # datasets in the unit of the key
UNITS = {"": "1", "%": "percent", "deg": "degree"}  # in a result file
_V = ("value",)
LAYOUT = (
    Dataset("value", _V, "1", "values of the key, in its own unit"),
    Dataset("n_disks", _V, "1", "disks computed at every value, the first ones drawn", "i8"),
    Dataset("n_above", _V, "1", "those beyond the limit, or without a result", "i8"),
    Dataset("probability_low", _V, "1", "lower end of the 95 % interval of the probability"),
    Dataset("probability_high", _V, "1", "upper end of the 95 % interval of the probability"),
    Dataset("side", _V, "1", "probability certainly below (-1) or above (1) the target", "i8"),
    Dataset("crossing", ("end",), "1", "values on either side of the crossing; NaN: none"),
    *trials.limited_table("value", "sample"),
)


class Threshold(trials.Trials):
    """Search for the value of a key that meets a limit with a given probability."""

    name = "threshold"
    what = "value of a key that meets a limit with a probability"
    sections = ("threshold", "run_up")
    datasets = LAYOUT
    which = "the first disks at the deciding values"

    def layout(self, config: Config) -> tuple[Dataset, ...]:
        """Datasets of the result file; values of the key have its unit."""
        unit = name_and_unit(Config, config.threshold.key or "")[1].strip()
        units = UNITS.get(unit, unit)
        return tuple(line._replace(units=units) if line.name in OF_KEY else line for line in LAYOUT)

    def sizes(self, config: Config) -> dict[str, int]:
        """Lengths of this study's own dimensions."""
        return {"value": len(values_of(config)), "end": 2}

    def constants(self, config: Config) -> dict[str, Any]:
        """Values of the key."""
        return {"value": values_of(config)}

    def problems(self, config: Config) -> Iterator[str]:
        """Keys that do not fit this study."""
        yield from trials.limit_problems(config)
        n_disks, target = config.mistuning.samples, config.threshold.probability
        if n_disks < (needed := statistics.needed_below(target, 0)):
            yield (
                f"mistuning.samples: {n_disks:,} disks cannot show that a probability is below "
                f"threshold.probability {target:g}, even if none of them exceeds the limit; "
                f"{needed:,} can (5.3/P), or leave samples out"
            )
        key = config.threshold.key
        if key is None:
            yield "threshold.key: missing; the key whose value is searched for is needed"
            return
        if key.startswith(NEVER_KEYS):
            yield f"threshold.key: {key} changes no disk"
            return
        most = MOST_VALUES // 2
        if config.threshold.highest - config.threshold.lowest > most * config.threshold.tolerance:
            yield (
                f"threshold.tolerance: {config.threshold.tolerance} divides the range into more "
                f"than {most} steps"
            )
            return
        for value in map(float, values_of(config)):
            try:
                at_value(config, value)
            except InputError as error:
                yield f"threshold.key: at the value {value:g}: {error}"
                return
        ends = (at_value(config, float(end)) for end in values_of(config)[[0, -1]])
        of_ends = (keys_without_effect(end) for end in ends)  # a default is no key that is given
        lines = [line for end in of_ends for line in end if line.startswith(f"{key}:")]
        yield from (f"threshold.key: {line}" for line in lines[-1:])

    def warnings(self, config: Config, prepared: Any) -> Iterator[str]:
        """Warnings at both ends of the range, once where they are alike.

        The input's own value of the key, of which `prepared` is, is not computed.
        """
        found = dict[str, list[float]]()
        for value in map(float, values_of(config)[[0, -1]]):
            here = at_value(config, value)
            for line in super().warnings(here, build_problem(here)):
                found.setdefault(line, []).append(value)
        for line, at in found.items():
            yield f"{line} (at {config.threshold.key} = {at[0]:g})" if len(at) == 1 else line

    def needs(self, config: Config) -> str:
        """Number of values, and of disks that the search is expected to need, in words."""
        n_values, disks = len(values_of(config)), self.cost(config).disks
        return (
            f"for {n_values} values of {config.threshold.key}, together about {disks:,} disks, up "
            "to three times as many where the probability hardly changes from value to value"
        )

    def cost(self, config: Config) -> Cost:
        """Cost of the disks that a search is expected to compute from its begin."""
        shape = len(values_of(config)), config.mistuning.samples
        nothing = np.full(shape, np.nan), np.zeros(shape, dtype=bool)
        search = Search.followed(*nothing, config.threshold.probability)
        disks = round(float(search.still_expected().sum()))
        return Cost(disks + second_order.cost(config), disks=disks)

    def tried(self, config: Config) -> list[Config]:
        """Inputs at values over the whole range, whose disks may differ tenfold in their cost."""
        values = values_of(config)
        return [at_value(config, float(value)) for value in values[statistics.coarse(len(values))]]

    def case(self, config: Config, task: tuple[int, int]) -> trials.Case:
        """Input and disk of a task; task: indices of value and disk."""
        here = at_value(config, float(values_of(config)[task[0]]))
        return trials.Case(here, deviation(here, 0, task[1]))

    def next_disks(self, file: ResultFile) -> Round:
        """The pending disks of the next values to test; they do not depend on other disks."""
        config, there = file.config, file.status != PENDING
        search = Search.followed(severities(file), there, config.threshold.probability)
        looks = search.next_looks()
        tasks = [(v, int(i)) for v, n in looks for i in np.flatnonzero(~there[v, :n])]
        # the first disks lie over the whole range, unlike all others
        is_far = search.n_done.max() < 2 * FIRST_DISKS
        phase = f"{self.unit} {'over the range' if is_far else 'near the crossing'}"
        ahead = search.still_expected()
        expected = round(float(search.n_done.sum() + ahead.sum()))
        return Round(tasks, results(config, search), expected, phase, ahead=ahead)

    def at_the_answer(self, file: ResultFile, known: Mapping[str, Any]) -> list[tuple[int, int]]:
        """The first disks at both ends of the crossing, or where most disks were computed."""
        n_done, each = known["n_disks"], OF_TRIALS // 2
        ends = np.flatnonzero(np.isin(file.read("value"), known["crossing"]))
        if not len(ends):
            ends = np.argsort(-n_done, kind="stable")[:2]
        return [(int(v), disk) for v in ends for disk in range(min(each, n_done[v]))]

    def report(self, file: ResultFile) -> Iterator[str]:
        """The value that meets the limit, and the number of disks that the search took."""
        yield crossing_in_words(file)
        search, value = search_of(file), file.read("value")
        crossings = search.crossings()
        if len(crossings) > 1:
            sides = search.sides()
            words = (
                f"between {value[a]:g} and {value[b]:g} it {'falls' if sides[a] > 0 else 'rises'}"
                for a, b in crossings
            )
            yield f"the probability crosses the target several times: {'; '.join(words)}"
        yield from by_limit_line(file)
        n_done, n_values = int(file.read("n_disks").sum()), len(file.read("value"))
        seen = np.count_nonzero(file.read("n_disks") > 1)
        yield f"{n_done:,} disks: one at each of {n_values} values, and more at {seen} of them"

    def answer(self, file: ResultFile, usable: bool) -> Iterator[str | Table]:
        """The report, and a table of the probability at every value that was looked at."""
        yield from self.report(file)
        yield probabilities(file)

    def findings(self, file: ResultFile) -> Iterator[Finding]:
        """A crossing that is not certain, not known as well as asked, or one of several."""
        search, asked = search_of(file), file.config.threshold
        if search.next_looks() == [] and not search.sides().any():
            yield Finding(
                USELESS, "no value is certain",
                f"everywhere the probability is too close to {percent(asked.probability)} % for "
                f"{search.most:,} disks: more mistuning.samples, or another range",
            )  # fmt: skip
        if len(search.crossings()) > 1:
            yield Finding(
                SINGLE, "several crossings",
                f"the probability rises and falls again with {asked.key}: between the values that "
                "were tried there may be further crossings; see the figure",
            )  # fmt: skip
        yield from _not_as_close_as_asked(file, search)
        yield from trials.left_for_others(file)
        computed = np.arange(search.most) < search.n_done[:, None]
        sizes, states = file.read("peak_amplitude_m")[computed], file.read("peak_status")[computed]
        # no answer hangs on how far disks move well beyond the limit
        far = (search.sides() == ABOVE) & bool(search.crossings())
        far &= ~np.isin(np.arange(len(far)), search.crossings())
        is_far = np.repeat(far, search.n_done)
        sizes[is_far & np.isfinite(sizes)] = 0.0
        yield from cut_through(file.config, file.read("deepest_m")[computed][~is_far], "disks")
        bent = self.second_order_finding(file)
        yield from findings.of_disks(file.config, sizes, states, to_second_order=bent)


def _not_as_close_as_asked(file: ResultFile, search: Search) -> Iterator[Finding]:
    """Finding about a crossing in a range wider than the tolerance, and what would narrow it."""
    asked, values = file.config.threshold, file.read("value")
    for a, b in search.crossings():
        width, chance = values[b] - values[a], search.expected()[a + 1 : b]
        if width <= asked.tolerance * (1.0 + 1e-9):
            continue
        words = f"the crossing is known within {width:g}, not {asked.tolerance:g}"
        needed = [n_to_tell(asked.probability, p) for p in chance[np.isfinite(chance)]]
        advice = f": about {max(needed):,} mistuning.samples would tell it" if needed else ""
        why = "what lies between is too close to the target to be told from it"
        yield Finding(SINGLE, words, f"{words}, as threshold.tolerance asks; {why}{advice}")
    if (doubtful := search.doubtful()).size:
        most = max(n_to_tell(asked.probability, p) for p in search.expected()[doubtful])
        words = f"one side of {percent(asked.probability)} % is not certain anywhere"
        yield Finding(SINGLE, words, f"{words}: about {most:,} mistuning.samples would tell it")


def n_to_tell(target: float, chance: float) -> int:
    """Disks that tell a probability, or one 10 % from the target if nearer, from the target."""
    least = 0.1 * target
    far = chance if abs(chance - target) > least else target - least
    return n_needed(Goal(None, target), far)


def probabilities(file: ResultFile) -> Table:
    """Table of the probability at every value that more than one disk was computed at."""
    names = "n_disks", "n_above", "probability_low", "probability_high", "side"
    headings = file.config.threshold.key or "", "disks", "beyond", "probability", "95 % interval"
    found = table("", (*headings, "the target"))
    words = {BELOW: "met", UNKNOWN: "not known", ABOVE: "not met"}
    for value, n, above, low, high, side in zip(
        file.read("value"), *map(file.read, names), strict=True
    ):
        if n > 1:
            ends = f"{percent(low)} to {percent(high)} %"
            row = f"{value:g}", f"{n:,}", f"{above:,}", f"{percent(above / n)} %", ends
            found.add_row(*row, words[int(side)])
    return found


def results(config: Config, search: Search) -> dict[str, Any]:
    """What a search tells, by the names in the result file."""
    ends = probability_interval(search.n_above, search.n_done, Z_95)
    low, high = np.where(search.n_done > 0, ends, np.nan)
    crossings, values = search.crossings(), values_of(config)
    return {
        "n_disks": search.n_done,
        "n_above": search.n_above,
        "probability_low": low,
        "probability_high": high,
        "side": search.sides(),
        "crossing": values[list(crossings[0])] if crossings else np.full(2, np.nan),
    }


def values_of(config: Config) -> np.ndarray:
    """Values of the key that may be tested, whole ones of a key with whole numbers (V,)."""
    values, now = config.threshold.values, config.value(config.threshold.key or "")
    now = now[0] if isinstance(now, list) and len(now) == 1 else now
    is_whole = isinstance(now, int) and not isinstance(now, bool)
    return np.unique(np.round(values)) if is_whole else values


def at_value(config: Config, value: float) -> Config:
    """The configuration with a value of the key. Raises InputError for one that is not allowed."""
    key = config.threshold.key or ""
    before = config.value(key)
    if isinstance(before, list) and len(before) > 1:
        instead = " or casing.clearance_offset_mm" if key == "casing.clearance_hz_mm" else ""
        raise InputError(f"{key} has {len(before)} values; name one, such as {key}[0]{instead}")
    return config.replace({key: [value] if isinstance(before, list) else value})


def search_of(file: ResultFile) -> Search:
    """State of the search in a result file."""
    return Search(severities(file), file.read("n_disks"), file.config.threshold.probability)


def ends_of_crossing(file: ResultFile) -> tuple[float, float]:
    """The value that meets the limit, and the next one that does not; NaN: there is none."""
    low, high = map(float, file.read("crossing"))
    falls = np.isfinite(low) and file.read("side")[file.read("value") == low][0] == ABOVE
    return (high, low) if falls else (low, high)


def crossing_in_words(file: ResultFile) -> str:
    """The value that meets the limit, in words."""
    asked, (safe, other) = file.config.threshold, ends_of_crossing(file)
    value, side = file.read("value"), file.read("side")
    name, unit = name_and_unit(Config, asked.key or "")
    does = f"the probability of exceeding {limits_in_words(file.config)}"
    target = f"{percent(asked.probability)} %"
    if np.isfinite(safe):
        return (
            f"{name} of {safe:g}{unit} ({asked.key}) keeps {does} below {target}, with 99 % "
            f"confidence; {other:g}{unit} does not"
        )
    range_of = f"{name} from {value[0]:g} to {value[-1]:g}{unit} ({asked.key})"
    if not side.any():
        return f"{does} is not known yet to be above or below {target}; tried: {range_of}"
    if not np.nan_to_num(file.read("peak_amplitude_m")).any():
        return f"no blade touches the casing at any value tried, {range_of}: no limit is exceeded"
    certain = value[np.flatnonzero(side)]
    at = " and ".join(f"{v:g}" for v in dict.fromkeys(certain[[0, -1]]))
    is_ = f"{does} is {'below' if side.min() < 0 else 'above'} {target} at"
    if (doubtful := value[search_of(file).doubtful()]).size:
        where = ", ".join(f"{v:g}" for v in doubtful)
        return f"{is_} {name} of {at}{unit} ({asked.key}), with 99 % confidence; not known: {where}"
    return f"{is_} all values tried: {range_of}; at {at}{unit} with 99 % confidence"


STUDY = Threshold()
