"""Small probability of exceeding a limit: a cheap first look at all disks, few computed in full.

A first look integrates a disk for a short time at a few speeds. The first disks, the *pilot*, get a
first look at all speeds and are computed in full. They show which speeds are worth a first look;
`statistics.rare` then gives the probability with which a disk is computed in full.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.model import mistuning
from hpcrub.response.sweep import run_sweep
from hpcrub.results.layout import DONE, PEAK_STATUS, PENDING, Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.runs import verdict
from hpcrub.runs.cost import Cost
from hpcrub.runs.study import Job, Study
from hpcrub.runs.verdict import USELESS, Finding
from hpcrub.setup.disks import deviation, modes_of
from hpcrub.statistics.percentiles import finite
from hpcrub.statistics.rare import Counts, Goal, Plan, Rule, count, estimate, n_needed, plan
from hpcrub.studies.contact.amplification import amplitudes, peak, peak_status, peak_stress
from hpcrub.studies.contact.limits import percent, severities, severity
from hpcrub.studies.threshold import limit_problems

PILOT = 100  # disks of the pilot
GROWTH = 1.3  # factor on the number of disks from one estimate to the next
EARLY = 0.8  # end of a first look, as part of the time of the first steady-state check
FEW = 4, 8, 16, 32  # numbers of speeds that are tried for a first look
SUPPOSED = 1e-3  # probability that is assumed before anything is known
ESTIMATE = "probability", "probability_low", "probability_high"
_E, _N, _P = ("estimate",), ("sample",), ("pilot",)
LAYOUT = (
    Dataset("n_disks", _E, "1", "disks of every estimate, the first ones drawn", "i8"),
    Dataset("probability", _E, "1", "probability of exceeding a limit; NaN: not estimated"),
    Dataset("probability_low", _E, "1", "lower end of its 95 % interval"),
    Dataset("probability_high", _E, "1", "upper end of its 95 % interval"),
    Dataset("look_speeds", ("speed",), "1", "whether a first look has a speed; none: plain", "u1"),
    Dataset("pilot_look", (*_P, "speed"), "1", "early severity of the pilot's disks"),
    Dataset("pilot_peak_hz", _P, "Hz", "speed of the largest amplitude of the pilot's disks"),
    Dataset("look", _N, "1", "largest early severity at the speeds of the first look; NaN: none"),
    Dataset("inclusion", _N, "1", "probability with which a disk is computed in full"),
    Dataset("computed", _N, "1", "whether a disk was computed in full", "u1"),
    Dataset("peak_amplitude_m", _N, "m", "largest amplitude of a disk over the speeds"),
    Dataset("peak_stress_pa", _N, "Pa", "largest stress of a disk over the speeds"),
    Dataset("peak_status", _N, "1", PEAK_STATUS, "u1"),
    Dataset("time_s", _N, "s", "simulated time of a disk computed in full, of all speeds"),
    Dataset("status", _N, "1", "0 pending, 1 done", "u1"),
)


class Step(NamedTuple):
    """The first n disks, the speeds (indices) of their first look, and the rule of the draw."""

    n: int
    speeds: tuple[int, ...]
    rule: Rule


class Sampling(Job):
    """Job of double sampling: more and more disks, until the goal is met (all ranks)."""

    def _tasks(self):
        return map(int, np.flatnonzero(self.status[: self.round.n] == PENDING))

    def _next(self):
        """Next step with pending disks; None: nothing is left to do (rank 0).

        A step depends on the disks before it alone, whatever else the file holds.
        """
        goal, before = goal_of(self.config), 0
        above, inclusion = beyond(self.file), self.file.read("inclusion")
        estimated = np.isfinite(self.file.read("probability"))
        for place, n in enumerate(map(int, numbers(self.config))):
            if (self.status[:n] == PENDING).any():
                speeds, rule, self.expected = _onwards(self.file, before)
                if place == 1:  # the pilot's disks took longer
                    self.begin()
                return Step(n, speeds, rule)
            counts = count(above[:n], inclusion[:n])
            if not estimated[place]:
                if not before:
                    self._choose_look()
                self.file.write(dict(zip(ESTIMATE, estimate(counts), strict=True)), place)
            if goal.is_met(counts):
                return None
            before = n
        return None

    def _choose_look(self):
        """Write the first look that is expected to save most, and the pilot's looks (rank 0)."""
        tried = {speeds: _plan(self.file, PILOT, speeds) for speeds in candidates(self.file)}
        speeds, best = min(tried.items(), key=lambda item: item[1].saving)
        looks = _looks(self.file, speeds)
        if best.rule == Rule():
            speeds = ()
        mask = np.isin(np.arange(self.config.speeds.n_values), speeds).astype("u1")
        self.file.write({"look_speeds": mask}, ())
        self.file.write({"look": looks}, slice(len(looks)))
        if self.work.n_done:  # this run has computed some of the pilot's disks
            seconds = self.work.seconds / self.work.n_done
            hours = best.cost * seconds / sum(costs(self.file, mask >= 0)) / 3600
            disks = f"about {best.n_disks:,.0f} disks and {hours:,.3g} core hours to the goal"
            self.progress.say(f"{in_words(self.config, speeds)}; {disks}")

    def _pieces(self, sample, poll):
        """Take a first look at a disk, and compute it in full where the draw says so."""
        step, inclusion, speeds = self.round, 1.0, self.config.speeds.values_hz
        modes = modes_of(self.config, self.prepared, deviation(self.config, 0, sample))
        if sample < PILOT:
            yield "pilot_look", sample, self._early(modes, range(len(speeds)), poll)
        elif step.speeds:
            look = np.fmax.reduce(self._early(modes, step.speeds, poll), keepdims=True)
            inclusion = step.rule.inclusion(look)[0]
            yield "look", sample, look[0]
        computed = drawn(self.config, sample) < inclusion
        if computed:
            result = run_sweep(modes, self.prepared.scene, speeds, poll)
            size, at = peak(result, speeds)
            if sample < PILOT:
                yield "pilot_peak_hz", sample, at
            yield "peak_amplitude_m", sample, size
            yield "peak_stress_pa", sample, peak_stress(result)
            yield "peak_status", sample, peak_status(result, speeds)
            yield "time_s", sample, result.time.sum()
        yield "inclusion", sample, inclusion
        yield "computed", sample, int(computed)
        yield "status", sample, DONE

    def _early(self, modes, speeds, poll):
        """Severities (S,) at some speeds at the end of a first look; NaN at the others."""
        scene, config, end = self.prepared.scene, self.config, early_time(self.config)
        scene = scene._replace(steady=scene.steady._replace(first_check=end, max_time=end))
        result = run_sweep(modes, scene, config.speeds.values_hz, poll, selection=speeds)
        return severity(config, amplitudes(result), result.stress)


class Rare(Study):
    """Small probability of exceeding a limit, by double sampling."""

    name = "rare"
    what = "small probability of exceeding a limit, by double sampling"
    integrates = True
    job = Sampling
    unit = "disks"
    datasets = LAYOUT

    def sizes(self, config: Config) -> dict[str, int]:
        """Lengths of this study's own dimensions."""
        return {"pilot": min(PILOT, config.mistuning.samples), "estimate": len(numbers(config))}

    def constants(self, config: Config) -> dict[str, Any]:
        """Numbers of disks after which there is an estimate."""
        return {"n_disks": numbers(config)}

    def problems(self, config: Config) -> Iterator[str]:
        """Keys that do not fit this study."""
        yield from limit_problems(config)
        if goal_of(config) == Goal(None, None):
            yield (
                "limits: a rare study ends by limits.probability_error or "
                "limits.probability_below; give one of them"
            )
        if config.pattern_deviation is not None:
            yield "mistuning.pattern: one pattern has no probability, a rare study draws disks"

    def needs(self, config: Config) -> str:
        """Number of disks that the goal needs, in words."""
        chance, n = _supposed(config)
        return (
            f"the goal needs {n:,} disks in full if the probability is {chance:.2g}; the first "
            f"{PILOT} disks tell how many of them a first look saves"
        )

    def cost(self, config: Config) -> Cost:
        """Cost of the disks that plain sampling needs, at every speed."""
        disks = min(_supposed(config)[1], config.mistuning.samples)
        return Cost(disks, disks=disks)

    def expected(self, file: ResultFile) -> int:
        """Number of disks that the goal is expected to need, by the last estimate."""
        return _onwards(file, last_estimate(file)[0])[-1]

    def is_enough(self, file: ResultFile) -> bool:
        """Whether the goal is met."""
        n = last_estimate(file)[0]
        return bool(n and goal_of(file.config).is_met(counts_of(file, n)))

    def report(self, file: ResultFile) -> Iterator[str]:
        """The probability, the number of disks that it took, and the first look."""
        yield answer(file)
        n = last_estimate(file)[0]
        if not n:
            return
        computed, above = (np.count_nonzero(flags[:n]) for flags in (in_full(file), beyond(file)))
        yield f"{n:,} disks, {computed:,} computed in full, {above:,} of them beyond the limit"
        yield look_in_words(file)

    def findings(self, file: ResultFile) -> Iterator[Finding]:
        """A probability that is not known well enough, disks without a result, doubtful peaks."""
        config, speeds, computed = file.config, file.config.speeds, in_full(file)
        if not self.is_enough(file):
            yield Finding(
                USELESS, "the probability is not known as well as asked",
                f"{config.mistuning.samples:,} disks do not tell the probability as well as "
                "asked: more mistuning.samples, or another goal in limits",
            )  # fmt: skip
        size, n = file.read("peak_amplitude_m")[computed], int(np.count_nonzero(computed))
        lost = int(np.count_nonzero(~np.isfinite(size)))
        yield from verdict.without_result(lost, n, verdict.BEYOND)
        yield from verdict.unsettled_peaks(config, file.read("peak_status")[computed])
        if speeds.n_values > 1:
            at = file.read("pilot_peak_hz")
            at = at[file.read("peak_amplitude_m")[: len(at)] > 0.0]
            yield from verdict.of_peaks(config, np.searchsorted(speeds.values_hz, at))
        yield from verdict.kinematics(config, size)


def numbers(config: Config) -> np.ndarray:
    """Numbers of disks after which there is an estimate, increasing (E,)."""
    most, n_disks = config.mistuning.samples, [min(PILOT, config.mistuning.samples)]
    while n_disks[-1] < most:
        n_disks.append(min(int(np.ceil(GROWTH * n_disks[-1])), most))
    return np.array(n_disks)


def goal_of(config: Config) -> Goal:
    """Goal at which the study ends."""
    return Goal(config.limits.probability_error, config.limits.probability_below)


def drawn(config: Config, sample: int) -> float:
    """Random number in [0, 1): a disk is computed in full if it is below the inclusion."""
    draw = mistuning.uniform(config.mistuning.seed, mistuning.INCLUSION, 0, sample, 1)
    return float(draw[0] + 1.0) / 2.0


def early_time(config: Config) -> float:
    """Time at which a first look ends [s]."""
    return EARLY * config.steady_state.first_check


def candidates(file: ResultFile) -> list[tuple[int, ...]]:
    """Candidates for the speeds (indices) of a first look: quantiles of the pilot's peak speeds."""
    at = np.sort(finite(file.read("pilot_peak_hz")))
    at = at if at.size else file.config.speeds.values_hz
    places = (((np.arange(few) + 0.5) / few * len(at)).astype(int) for few in FEW)
    speeds = (np.searchsorted(file.config.speeds.values_hz, np.unique(at[i])) for i in places)
    return list(dict.fromkeys(tuple(map(int, indices)) for indices in speeds))


def costs(file: ResultFile, speeds: Any) -> tuple[float, float]:
    """Simulated time of a first look at some speeds, and mean of the pilot's full results [s]."""
    return len(speeds) * early_time(file.config), float(file.read("time_s")[:PILOT].mean())


def in_full(file: ResultFile) -> np.ndarray:
    """Whether disks were computed in full (n,)."""
    return file.read("computed") == 1


def beyond(file: ResultFile) -> np.ndarray:
    """Whether disks were computed in full and exceed a limit or have no result (n,)."""
    return in_full(file) & ~(severities(file) <= 1.0)


def counts_of(file: ResultFile, n: int) -> Counts:
    """Weighted counts of the first n disks."""
    return count(beyond(file)[:n], file.read("inclusion")[:n])


def last_estimate(file: ResultFile) -> tuple[int, np.ndarray]:
    """Number of disks of the last estimate, or 0; probability and ends of its interval (3,)."""
    estimates = np.array([file.read(name) for name in ESTIMATE])
    known = np.flatnonzero(np.isfinite(estimates[0]))
    if not len(known):
        return 0, np.full(3, np.nan)
    return int(file.read("n_disks")[known[-1]]), estimates[:, known[-1]]


def answer(file: ResultFile) -> str:
    """The probability, in words."""
    limits, (n, (chance, low, high)) = file.config.limits, last_estimate(file)
    of = [f"{limits.amplitude_mm:g} mm"] if limits.amplitude_mm is not None else []
    of += [f"{1e-6 * limits.stress:.4g} MPa"] if limits.stress is not None else []
    if not n:
        return f"probability of exceeding {' or '.join(of)}: not known yet"
    text = (
        f"a disk exceeds {' or '.join(of)} with a probability of {percent(chance)} % "
        f"(95 % interval {percent(low)} to {percent(high)} %)"
    )
    if limits.probability_below is None:
        return text
    side = ("not certainly below", "above", "below")[goal_of(file.config).side(counts_of(file, n))]
    return f"{text}, {side} the {percent(limits.probability_below)} % asked for"


def look_in_words(file: ResultFile) -> str:
    """The first look, its correlation with full results, and the time it saved, in words."""
    from scipy.stats import spearmanr  # its import takes half a second, on rank 0 alone

    speeds, (n, (chance, low, high)) = np.flatnonzero(file.read("look_speeds")), last_estimate(file)
    tried = [tuple(map(int, speeds))] if len(speeds) else candidates(file)
    agree = "; ".join(
        f"{len(look)} speeds {spearmanr(_looks(file, look), severities(file)[:PILOT])[0]:.2f}"
        for look in tried
    )
    text = f"{in_words(file.config, speeds)} (rank correlation with full results: {agree})"
    early, full = costs(file, speeds)
    if not (len(speeds) and chance > 0.0):
        return text
    of_pilot = costs(file, file.config.speeds.values_hz)[0] * PILOT
    took = np.nansum(file.read("time_s")[:n]) + n * early + of_pilot
    plain = n_needed(Goal((high - low) / (2.0 * chance), None), chance, chance, 1.0) * full
    return f"{text}; {took / plain:.2f} of the simulated time of plain sampling to this interval"


def in_words(config: Config, speeds: Any) -> str:
    """Speeds and duration of a first look, in words."""
    if not len(speeds):
        return "plain sampling, for no first look is worth its cost"
    return f"first look at {len(speeds)} speeds for {early_time(config):.3g} s"


def _looks(file, speeds):
    """Largest early severity of the pilot's disks at some speeds (pilot,)."""
    return np.fmax.reduce(file.read("pilot_look")[:, list(speeds)], axis=1)


def _onwards(file, before):
    """Speeds of first looks, rule and number of disks to the goal, by the first disks."""
    looked_at = np.flatnonzero(file.read("look_speeds")) if before else ()
    speeds, rule, needed = tuple(map(int, looked_at)), Rule(), 0.0
    if speeds:
        rule, needed, *_ = _plan(file, before, speeds)
    elif before:
        chance = beyond(file)[:before].mean()
        needed = n_needed(goal_of(file.config), chance, chance, 1.0)
    return speeds, rule, round(float(needed))


def _plan(file: ResultFile, n: int, speeds: tuple[int, ...]) -> Plan:
    """Plan by the first n disks, of which the pilot's have first looks at these speeds."""
    pilot, look = _looks(file, speeds), file.read("look")[:n]
    look[: len(pilot)] = pilot
    inclusion = file.read("inclusion")[:n]
    severity = severities(file)[:n]
    lost = in_full(file)[:n] & np.isnan(severity)
    return plan(look, severity, lost, inclusion, costs(file, speeds), goal_of(file.config))


def _supposed(config):
    """Assumed probability, and the number of disks that the goal needs with it."""
    below = config.limits.probability_below
    chance = SUPPOSED if below is None else below / 3.0
    return chance, int(n_needed(goal_of(config), chance, chance, 1.0))


STUDY = Rare()
