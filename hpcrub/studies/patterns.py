"""Intentional mistuning: search for the pattern of blade types with which disks vibrate least.

Successive halving (Karnin, Koren and Somekh, ICML 2013): every round doubles the number of disks
and drops the worse half of the patterns. All patterns get the same random disks.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.config.text import counted
from hpcrub.effects.coating import cut_through
from hpcrub.results.layout import DONE, PEAK_STATUS, PENDING, Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import REMARK, SINGLE, USELESS, Finding
from hpcrub.runs import findings
from hpcrub.runs.cost import Cost
from hpcrub.runs.job import Round
from hpcrub.runs.study import Poll, Values
from hpcrub.setup.disks import deviation, modes_of
from hpcrub.setup.problem import Problem, build_problem
from hpcrub.statistics.necklaces import candidates, compare
from hpcrub.statistics.percentiles import finite
from hpcrub.studies.contact import second_order
from hpcrub.studies.contact.amplification import linear_amplitude
from hpcrub.studies.contact.second_order import OF_TRIALS
from hpcrub.studies.contact.trials import Case, Trials, bent_table, peaks_of

FIRST_DISKS = 64  # disks of every pattern in the first round
BLOCK = 32  # disks of a task
_P, _PN = ("pattern",), ("pattern", "sample")
LAYOUT = (
    Dataset("types", ("pattern", "blade"), "1", "type of every blade; pattern 0: none", "i8"),
    Dataset("n_disks", _P, "1", "disks of the linear analysis, the first ones drawn", "i8"),
    Dataset("percentile", _P, "1", "percentile of their linear amplification; infinite: flutter"),
    Dataset("worse_by", _P, "1", "low end of how much worse than the best of its round"),
    Dataset("amplification", _PN, "1",
            "linear amplitude over the tuned disk's, that without air where this flutters"),
    Dataset("least_damping_ratio", _PN, "1", "of the least stable mode; below 0 it flutters"),
    Dataset("status", _PN, "1", "0 pending, 1 done", "u1"),
    Dataset("contact_amplitude_m", ("pattern", "contact_sample"), "m",
            "largest amplitude in contact over the speeds; NaN: not computed, or none"),
    Dataset("peak_status", ("pattern", "contact_sample"), "1", PEAK_STATUS, "u1"),
    Dataset("deepest_m", ("pattern", "contact_sample"), "m",
            "largest worn depth of a coating over the speeds; NaN without one"),
    Dataset("contact_status", ("pattern", "contact_sample"), "1", "0 pending, 1 done", "u1"),
    *bent_table("pattern", "contact_sample"),
)  # fmt: skip


class Prepared(NamedTuple):
    """What all disks share."""

    problem: Problem
    types: np.ndarray  # of the blades of every pattern (P, N)
    tuned: float  # linear amplitude of the tuned disk, without air where it flutters [m]


def words_of(config: Config) -> np.ndarray:
    """Types of the blades of every pattern (P, N); row 0, all −1, is the disk without a pattern."""
    asked, n = config.patterns, config.disk.n_blades
    words = candidates(n, len(asked.types_percent), asked.candidates, config.mistuning.seed)
    return np.vstack([np.full(n, -1), words])


def added(config: Config, word: np.ndarray) -> np.ndarray:
    """Stiffness deviations (N,) [-] that a pattern adds; word: types of its blades, -1 for none."""
    return np.array([*config.patterns.types_percent, 0.0])[word] / 100.0


def in_letters(word: np.ndarray) -> str:
    """A pattern in letters, such as "AAB x 4"."""
    if word[0] < 0:
        return "no pattern"
    text = "".join("ABC"[kind] for kind in word)
    period = next(p for p in range(1, len(text) + 1) if text == text[:p] * (len(text) // p))
    return text if period == len(text) else f"{text[:period]} x {len(text) // period}"


def schedule(config: Config, n_patterns: int) -> list[tuple[int, int]]:
    """Number of disks of every pattern in each round, and of patterns in it at most."""
    kept, most = config.patterns.kept, config.mistuning.samples
    rounds = [(min(FIRST_DISKS, most), n_patterns)]
    while rounds[-1][0] < most:
        n, n_left = rounds[-1]
        rounds.append((min(2 * n, most), max(kept, -(-n_left // 2))))
    return rounds


def n_linear(config: Config, n_patterns: int) -> int:
    """Number of disks in all rounds of the linear analysis, of the disk without a pattern, too."""
    n, n_left = np.transpose(schedule(config, n_patterns))
    return int(np.sum(np.diff(n, prepend=0) * (1 + np.minimum(n_left, n_patterns))))


class Rounds:
    """Ranking of the patterns by the disks in a file, round by round."""

    def __init__(self, file: ResultFile) -> None:
        """Go through the rounds whose disks are done."""
        self.config, self.most = file.config, file.config.mistuning.samples
        self.words, self.values = file.read("types"), file.read("amplification")
        self.status, self.contact_status = file.read("status"), file.read("contact_status")
        n_patterns = len(self.words)
        self.percentile, self.worse_by = np.full((2, n_patterns), np.nan)
        self.n_disks = np.zeros(n_patterns, dtype=int)
        self.left = np.arange(1, n_patterns)
        # patterns whose first n disks the next round needs, and n; None: all rounds are over
        self.missing: tuple[np.ndarray, int] | None = None
        for n, n_left in schedule(self.config, n_patterns - 1):
            self.left = self.left[:n_left]
            self._rank(n)
            if self.missing:
                return
        self.left = self.left[: self.config.patterns.kept]

    def _rank(self, n: Any) -> None:
        """Rank the patterns left by their first n disks, or note that some of these are missing."""
        here = np.append(0, self.left)
        if (self.status[here, :n] == PENDING).any():
            self.missing = here, n
            return
        known = self.values[here, :n]
        known = np.where(np.isfinite(known), known, np.inf)
        self.n_disks[here] = n
        self.percentile[here], self.worse_by[here] = compare(known, self.config.patterns.percentile)
        self.left = self.left[np.argsort(self.percentile[self.left], kind="stable")]


class PatternStudy(Trials):
    """Patterns of blade types, ranked by the amplification of disks with random mistuning."""

    name = "patterns"
    what = "which pattern of blade types makes mistuned disks vibrate least"
    sections = ("patterns",)
    amplitude = "contact_amplitude_m"
    which = "the first disks with the best pattern and without one"
    datasets = LAYOUT

    def sizes(self, config: Config) -> dict[str, int]:
        """Numbers of patterns, the disk without one included, and of disks in contact."""
        n_contact = config.patterns.contact_samples
        return {"pattern": len(words_of(config)), "contact_sample": n_contact}

    def constants(self, config: Config) -> dict[str, Any]:
        """Blade types of the patterns."""
        return {"types": words_of(config)}

    def problems(self, config: Config) -> Iterator[str]:
        """Keys that do not fit this study."""
        if config.disk.is_resolved and config.disk.n_blades == 1:
            yield "disk.model: it has one blade, and patterns are of several"
        if len(config.mistuning.half_range_percent) != 1:
            yield "mistuning.half_range_percent: a study of patterns is of one level"
        if config.mistuning.pattern is not None or config.mistuning.intentional_percent:
            yield "patterns: mistuning.pattern and intentional_percent are what is searched for"
        if config.patterns.contact_samples > config.mistuning.samples:
            yield "patterns.contact_samples: more than mistuning.samples"
        if config.engine_order is None:
            yield "patterns: there is no engine order of a linear load (forcing, casing)"

    def prepare(self, config: Config) -> Prepared:
        """Prepare the Problem and the linear amplitude of the tuned disk. Raises InputError."""
        problem, alike = build_problem(config), np.zeros(config.disk.n_blades)
        own, modes = problem, modes_of(config, problem, alike)
        if modes.waves and modes.waves.damping_ratio.min() <= 0.0:
            own = problem._replace(reduced=problem.reduced._replace(air=None))
            modes = modes._replace(waves=None)
        return Prepared(problem, words_of(config), linear_amplitude(config, own, modes, alike))

    def cost(self, config: Config) -> Cost:
        """Cost of all rounds of the linear analysis, and of the disks in contact."""
        n_patterns, asked = len(words_of(config)) - 1, config.patterns
        contact = (1 + min(asked.kept, n_patterns)) * asked.contact_samples
        bent = second_order.cost(config)
        return Cost(contact + bent, disks=n_linear(config, n_patterns) + contact)

    def parts(self, file: ResultFile) -> np.ndarray:
        """Status of all disks of the linear analysis, and in contact."""
        return np.hstack([file.read("status"), file.read("contact_status")])

    def next_disks(self, file: ResultFile) -> Round:
        """Pending disks of the next round of linear analyses; at the end, those in contact."""
        rounds = Rounds(file)
        known = {name: getattr(rounds, name) for name in ("n_disks", "percentile", "worse_by")}
        if rounds.missing is None:
            here = np.append(0, rounds.left)
            rows, samples = np.nonzero(rounds.contact_status[here] == PENDING)
            tasks = list(zip(here[rows].tolist(), samples.tolist(), strict=True))
            n_all = int(np.count_nonzero(self.parts(file))) + len(tasks)
            how = "disks in contact", "contact_status"
            return Round(tasks, known, n_all, *how)
        here, n = rounds.missing
        blocks = [slice(first, min(first + BLOCK, n)) for first in range(0, n, BLOCK)]
        pending = [(p, b) for p in here.tolist() for b in blocks if PENDING in rounds.status[p, b]]
        n_all, of = n_linear(file.config, len(rounds.words) - 1), "linear disks"
        return Round(pending, known, n_all, of, integrates=False)

    def case(self, config: Config, task: Any) -> Case:
        """Disk in contact of a task; task: numbers of pattern and disk."""
        pattern = added(config, words_of(config)[task[0]])
        return Case(config, deviation(config, 0, task[1]) + pattern)

    def at_the_answer(self, file: ResultFile, known: Mapping[str, Any]) -> list[tuple[int, int]]:
        """The first disks in contact of the best pattern, and without one."""
        each = min(OF_TRIALS // 2, file.config.patterns.contact_samples)
        return [(row, disk) for row in (int(Rounds(file).left[0]), 0) for disk in range(each)]

    def compute_all(
        self, config: Config, prepared: Prepared, tasks: Sequence[Any], poll: Poll
    ) -> Iterator[tuple[Any, list[Values]]]:
        """Compute linear analyses of some disks with a pattern each, or disks in contact together.

        tasks: each a pattern and a slice of disks, or the number of a disk in contact.
        """
        patterns = [added(config, prepared.types[pattern]) for pattern, _ in tasks]
        if isinstance(tasks[0][1], slice):
            for task, pattern in zip(tasks, patterns, strict=True):
                results = []
                for sample in range(task[1].start, task[1].stop):
                    blades = deviation(config, 0, sample) + pattern
                    modes = modes_of(config, prepared.problem, blades)
                    size = linear_amplitude(config, prepared.problem, modes, blades)
                    least = modes.waves.damping_ratio.min() if modes.waves else np.nan
                    ratio = size / prepared.tuned if np.isfinite(size) else np.nan
                    results.append((ratio, least))
                    poll()
                names = "amplification", "least_damping_ratio"
                columns = zip(names, np.transpose(results), strict=True)
                yield task, [(name, task, values) for name, values in columns]
            return
        disks = zip(tasks, patterns, strict=True)
        blades = [deviation(config, 0, disk) + pattern for (_, disk), pattern in disks]
        for k, found in peaks_of(config, prepared.problem, blades, poll):
            amplitude = "contact_amplitude_m", tasks[k], found["peak_amplitude_m"]
            others = [(name, tasks[k], found[name]) for name in ("peak_status", "deepest_m")]
            yield tasks[k], [amplitude, *others]

    def report(self, file: ResultFile) -> Iterator[str]:
        """The patterns left, compared with the disk without a pattern."""
        rounds, asked = Rounds(file), file.config.patterns
        known, n_blades = rounds.percentile, file.config.disk.n_blades
        if rounds.missing:
            yield "the rounds are not over"
            return
        best = rounds.left[0]
        yield (
            f"best of {len(rounds.words) - 1} patterns: {in_letters(rounds.words[best])}, "
            f"percentile {asked.percentile:g} of A_lin {_in_words(known[best])}, without a pattern "
            f"{_in_words(known[0])}, after {rounds.n_disks.sum():,} linear disks"
        )
        for p in [*rounds.left, 0]:
            line = f"{in_letters(rounds.words[p]):{n_blades + 6}}{_in_words(known[p])}"
            line += ", worse for certain" if rounds.worse_by[p] > 0.0 else ""
            if len(size := finite(1e3 * file.read("contact_amplitude_m", p))):
                high = f"{np.percentile(size, asked.percentile):.4g} ({asked.percentile:g})"
                line += f", in contact {np.median(size):.4g} mm (percentile 50), {high}"
            least = finite(file.read("least_damping_ratio", p))
            if len(least):
                line += f", damping ratio down to {least.min():.3g}"
                line += f", {np.count_nonzero(least <= 0.0)} of {len(least)} disks flutter"
            yield line

    def findings(self, file: ResultFile) -> Iterator[Finding]:
        """Patterns that cannot be told apart, and flutter of the best one."""
        rounds = Rounds(file)
        if rounds.missing:
            return
        if rounds.percentile[0] <= rounds.percentile[rounds.left[0]]:
            words = "no pattern is seen to be better than none"
            yield Finding(REMARK, words, f"{words}: leave the blades alike, or try other types")
        alike = int(np.count_nonzero(rounds.worse_by[rounds.left] <= 0.0))
        if alike > 1:
            words = f"the best {alike} of {len(rounds.left)} patterns left cannot be told apart"
            advice = "take any of them, or more mistuning.samples"
            yield Finding(REMARK, words, f"{words} with 95 % confidence: {advice}")
        unsure = int(np.count_nonzero(np.delete(rounds.worse_by, [0, *rounds.left]) <= 0.0))
        if unsure:
            words = f"{counted(unsure, 'pattern')} dropped without being worse for certain"
            yield Finding(REMARK, words, f"{words}, others may be as good: more patterns.kept")
        least = finite(file.read("least_damping_ratio", rounds.left[0]))
        lost = int(np.count_nonzero(least <= 0.0))
        if lost:
            words = f"{lost} of {len(least)} disks of the best pattern flutter"
            advice = "without contact: types further apart in patterns.types_percent"
            yield Finding(USELESS if lost == len(least) else SINGLE, words, f"{words} {advice}")
        size, done = file.read("contact_amplitude_m"), file.read("contact_status") == DONE
        states, meaning = file.read("peak_status"), "are missing in the percentiles in contact"
        yield from cut_through(file.config, file.read("deepest_m")[done], "disks")
        bent = self.second_order_finding(file)
        yield from findings.of_disks(file.config, size[done], states, meaning, bent)
        yield from findings.too_few_samples(
            [file.config.patterns.percentile], file.config.mistuning.samples
        )


def _in_words(percentile: float) -> str:
    return f"{percentile:.3f}" if np.isfinite(percentile) else "infinite (flutter)"


STUDY = PatternStudy()
