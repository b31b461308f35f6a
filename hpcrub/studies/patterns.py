"""Intentional mistuning: search for the pattern of blade types with which disks vibrate least.

Successive halving (Karnin, Koren and Somekh, ICML 2013): every round doubles the number of disks
and drops the worse half of the patterns. All patterns get the same random disks. Where there are
too many patterns to try all, the search adds neighbours of the best ones after the first round.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.config.text import counted
from hpcrub.response.sweep import run_sweep
from hpcrub.results.layout import DONE, PEAK_STATUS, PENDING, Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import REMARK, SINGLE, USELESS, Finding
from hpcrub.runs import findings
from hpcrub.runs.cost import Cost
from hpcrub.runs.study import Job, Study
from hpcrub.setup.disks import deviation, modes_of
from hpcrub.statistics.necklaces import UNKNOWN, candidates, compare, neighbours
from hpcrub.statistics.percentiles import finite
from hpcrub.studies.contact.amplification import linear_amplitude, peak, peak_status

FIRST = 64  # disks of every pattern in the first round
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
    Dataset("contact_status", ("pattern", "contact_sample"), "1", "0 pending, 1 done", "u1"),
)  # fmt: skip


class Task(NamedTuple):
    """Linear analysis of some disks with one pattern, or one of the disks in contact."""

    pattern: int
    disks: Any  # range of disks, or the number of the disk in contact
    word: tuple[int, ...]  # types of the blades, which the files of other ranks may lack yet


def words_of(config: Config) -> np.ndarray:
    """Types of the blades of every pattern (P, N); row 0, all −1, is the disk without a pattern.

    The last rows may be UNKNOWN until the first round is over.
    """
    asked, n = config.patterns, config.disk.n_blades
    words = candidates(n, len(asked.types_percent), asked.candidates, config.mistuning.seed)
    return np.vstack([np.full(n, -1), words])


def in_letters(word: np.ndarray) -> str:
    """A pattern in letters, such as "AAB x 4"."""
    if word[0] < 0:
        return "no pattern"
    text = "".join("ABC"[kind] for kind in word)
    period = next(p for p in range(1, len(text) + 1) if text == text[:p] * (len(text) // p))
    return text if period == len(text) else f"{text[:period]} x {len(text) // period}"


class Rounds:
    """Ranking of the patterns by the disks in a file, round by round."""

    def __init__(self, file: ResultFile) -> None:
        """Go through the rounds whose disks are done."""
        config, asked = file.config, file.config.patterns
        self.words, self.most = file.read("types"), config.mistuning.samples
        self.status, self.contact_status = file.read("status"), file.read("contact_status")
        values = file.read("amplification")
        n_patterns = len(self.words)
        self.percentile, self.worse_by = np.full((2, n_patterns), np.nan)
        self.n_disks = np.zeros(n_patterns, dtype=int)
        n = min(FIRST, self.most)
        # patterns whose first n disks the next round needs, and n; None: all rounds are over. If
        # these disks are all done, a search has to name the patterns `unknown` first
        self.missing: tuple[np.ndarray, int] | None = None
        self.unknown = np.flatnonzero(self.words[:, 0] == UNKNOWN)
        self.left = np.arange(1, n_patterns - len(self.unknown))
        while True:
            here = np.append(0, self.left)
            if (self.status[here, :n] == PENDING).any():
                self.missing = here, n
                return
            amplification = np.where(np.isfinite(values[here, :n]), values[here, :n], np.inf)
            self.n_disks[here] = n
            self.percentile[here], self.worse_by[here] = compare(amplification, asked.percentile)
            self.left = self.left[np.argsort(self.percentile[self.left], kind="stable")]
            if len(self.unknown):  # first, neighbours of the best are named
                self.missing = here, n
                return
            if n == self.most:
                self.left = self.left[: asked.kept]
                return
            self.left = self.left[: max(asked.kept, -(-len(self.left) // 2))]
            n = min(2 * n, self.most)

    def missing_in_contact(self) -> np.ndarray:
        """Pairs of pattern and sample (n, 2) of the pending disks in contact."""
        here = np.append(0, self.left)
        rows, samples = np.nonzero(self.contact_status[here] == PENDING)
        return np.column_stack([here[rows], samples])


class Halving(Job):
    """Job of the search: rounds of linear analyses, then the patterns left in contact."""

    def run(self) -> None:
        """Compute round after round, then the disks in contact; on all ranks."""
        self.planned = 0
        self.tuned = self.team.on_root(self._tuned)
        self.phase("linear disks")
        while blocks := self.team.on_root(self._blocks):
            self.team.run_tasks(blocks, self._compute, self._collect)
        disks = self.team.on_root(self._contact)
        if disks:
            self.load_kernel()
        self.phase("disks in contact")
        self.team.run_tasks(disks, self._compute, self._collect)

    def n_done(self) -> tuple[int, int]:
        """Number of tasks computed in this run, and of tasks planned so far (rank 0)."""
        return self.work.n_done, self.planned

    def _tuned(self):
        """Linear amplitude of the tuned disk, without air where it flutters [m]."""
        problem, alike = self.prepared, np.zeros(self.config.disk.n_blades)
        modes = modes_of(self.config, problem, alike)
        if modes.waves and modes.waves.damping_ratio.min() <= 0.0:
            problem = problem._replace(reduced=problem.reduced._replace(air=None))
            modes = modes._replace(waves=None)
        return linear_amplitude(self.config, problem, modes, alike)

    def _blocks(self):
        """Linear tasks of the next round; none: all rounds are over (rank 0)."""
        rounds = Rounds(self.file)
        for name in ("n_disks", "percentile", "worse_by"):
            self.file.write({name: getattr(rounds, name)}, ())
        while rounds.missing:
            (here, n), words = rounds.missing, [tuple(word) for word in rounds.words.tolist()]
            blocks = [
                Task(p, disks, words[p])
                for p in here.tolist()
                for first in range(0, n, BLOCK)
                for disks in [range(first, min(first + BLOCK, n))]
                if (rounds.status[p, disks] == PENDING).any()
            ]
            if blocks:
                self.planned += len(blocks)
                return blocks
            # patterns that are not known yet: neighbours of the best after the first round
            ranked = [words[p] for p in rounds.left]
            n_types, seed = len(self.config.patterns.types_percent), self.config.mistuning.seed
            new = neighbours(ranked, n_types, len(rounds.unknown), seed)
            self.file.write({"types": np.array(new)}, slice(rounds.unknown[0], None))
            rounds = Rounds(self.file)
        return []

    def _contact(self):
        """Tasks of the pending disks in contact (rank 0)."""
        rounds = Rounds(self.file)
        pending = rounds.missing_in_contact().tolist()
        disks = [Task(p, sample, tuple(rounds.words[p].tolist())) for p, sample in pending]
        self.planned += len(disks)
        return disks

    def _pieces(self, task, poll):
        if not isinstance(task.disks, range):
            where, blades = (task.pattern, task.disks), self._blades(task.word, task.disks)
            modes = modes_of(self.config, self.prepared, blades)
            speeds = self.config.speeds.values_hz
            result = run_sweep(modes, self.prepared.scene, speeds, poll)
            yield "contact_amplitude_m", where, peak(result, speeds)[0]
            yield "peak_status", where, peak_status(result, speeds)
            yield "contact_status", where, DONE
            return
        results = np.empty((2, len(task.disks)))
        for i, sample in enumerate(task.disks):
            blades = self._blades(task.word, sample)
            modes = modes_of(self.config, self.prepared, blades)
            size = linear_amplitude(self.config, self.prepared, modes, blades)
            results[0, i] = size / self.tuned if np.isfinite(size) else np.nan
            results[1, i] = modes.waves.damping_ratio.min() if modes.waves else np.nan
            poll()
        where = task.pattern, slice(task.disks.start, task.disks.stop)
        yield "amplification", where, results[0]
        yield "least_damping_ratio", where, results[1]
        yield "status", where, DONE

    def _blades(self, word, sample):
        """Stiffness deviations of blades by their types, and at random."""
        types = np.array([*self.config.patterns.types_percent, 0.0]) / 100.0  # -1: no pattern
        return deviation(self.config, 0, sample) + types[np.array(word)]

    def _collect(self, task, seconds):
        self._count("tasks planned so far", seconds)


class PatternStudy(Study):
    """Patterns of blade types, ranked by the amplification of disks with random mistuning."""

    name = "patterns"
    what = "which pattern of blade types makes mistuned disks vibrate least"
    sections = ("patterns",)
    integrates = True
    job = Halving
    unit = "disks"
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

    def cost(self, config: Config) -> Cost:
        """Cost of all rounds of the linear analysis, and of the disks in contact."""
        n_patterns, asked, n = len(words_of(config)), config.patterns, config.mistuning.samples
        rounds = int(np.log2(max(n / FIRST, 1.0))) + 1
        contact = (1 + min(asked.kept, n_patterns)) * asked.contact_samples
        return Cost(contact, disks=rounds * n_patterns * min(FIRST, n) // 2 + contact)

    def is_enough(self, file: ResultFile) -> bool:
        """Whether all rounds are over and the patterns left are computed in contact."""
        rounds = Rounds(file)
        return not rounds.missing and not rounds.missing_in_contact().size

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
            line += _in_contact(file, p)
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
        n_lost, n = (int(np.count_nonzero(done & off)) for off in (~np.isfinite(size), True))
        yield from findings.without_result(n_lost, n, "are missing in the percentiles in contact")
        yield from findings.unsettled_peaks(file.config, file.read("peak_status"))
        yield from findings.kinematics(file.config, size)
        yield from findings.few([file.config.patterns.percentile], file.config.mistuning.samples)


def _in_words(percentile: float) -> str:
    return f"{percentile:.3f}" if np.isfinite(percentile) else "infinite (flutter)"


def _in_contact(file, pattern):
    """Percentiles of the amplitudes in contact of a pattern's disks, in words."""
    size = finite(1e3 * file.read("contact_amplitude_m", pattern))
    if not size.size:
        return ""
    at = file.config.patterns.percentile
    middle, high = np.median(size), np.percentile(size, at)
    return f", in contact {middle:.4g} mm (percentile 50), {high:.4g} ({at:g})"


STUDY = PatternStudy()
