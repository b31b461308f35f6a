"""Trials: disks in contact, each in one case of the input, and one table of what they did.

A case is a changed input, or a deviation of the blades. The table tells which trials come next; in
the last round some disks at the answer are computed once more, to second order.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from scipy.special import bdtrc

from hpcrub.config import run_up
from hpcrub.config.schema import Config
from hpcrub.config.text import counted
from hpcrub.contact.status import DIVERGED, STEADY, are_fatal
from hpcrub.effects.effect import largest
from hpcrub.response.run_up import run_up as run_up_of
from hpcrub.response.sweep import Disk, run_sweeps
from hpcrub.results.layout import PEAK_STATUS, PENDING, Dataset, Values
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import MOST_LOST, SINGLE, USELESS, Finding
from hpcrub.runs.job import Round
from hpcrub.runs.study import Poll, Study
from hpcrub.setup.disks import rubbing_modes
from hpcrub.setup.problem import Problem, build_problem, to_second_order
from hpcrub.setup.run_up import asked_of
from hpcrub.studies.contact import second_order
from hpcrub.studies.contact.amplification import followed, peak, peak_status
from hpcrub.studies.contact.limits import severities, severity

BENT, BENT_STATUS = "second_order_amplitude_m", "second_order_status"
EVERY = 50  # one disk in so many is followed longer, to see whether motions stay
CHANCE = 0.05  # probability of so many in one direction by chance, below which it is none
MOST_TOGETHER = 64  # disks that are integrated together, at most


class Case(NamedTuple):
    """One disk in one case of the input."""

    config: Config  # with the changed input
    blades: np.ndarray  # stiffness deviations (N,) [-]


def table(*dimensions: str, note: str = "") -> tuple[Dataset, ...]:
    """Datasets of the largest amplitudes and stresses of all trials; note: about the amplitude."""
    return (
        Dataset("peak_amplitude_m", dimensions, "m", f"largest amplitude over the speeds{note}"),
        Dataset("peak_stress_pa", dimensions, "Pa", "largest stress over the speeds"),
        Dataset("peak_status", dimensions, "1", PEAK_STATUS, "u1"),
    )


def bent_table(*dimensions: str) -> tuple[Dataset, ...]:
    """Datasets of the trials that are computed to second order, too."""
    words = "largest amplitude to second order; NaN: not computed, infinite: no result"
    return (
        Dataset(BENT, dimensions, "m", words),
        Dataset(BENT_STATUS, dimensions, "1", "1: computed to second order, too", "u1"),
    )


def limited_table(*dimensions: str) -> tuple[Dataset, ...]:
    """Datasets of trials whose disks must meet a limit; some of them are followed longer."""
    words = "amplitude or stress over its limit when followed 4 times as long; NaN: not followed"
    return (
        *table(*dimensions),
        Dataset("deepest_m", dimensions, "m", "largest worn depth of a coating; NaN without one"),
        Dataset("followed_severity", dimensions, "1", words),
        Dataset("status", dimensions, "1", "0 pending, 1 done", "u1"),
        *bent_table(*dimensions),
    )


class Trials(Study):
    """A study of trials. A subclass has datasets of a `table`, and tells the `case` of a task.

    One whose results tell what comes next has `next_disks`, and one with a `bent_table` tells which
    disks are computed `at_the_answer` to second order.
    """

    integrates = True
    to_second_order = True
    of_tasks = False
    unit = "disks"
    amplitude = "peak_amplitude_m"  # dataset of the disks' largest amplitudes
    which = "the first disks"  # that are computed to second order, too

    def case(self, config: Config, task: Any) -> Case | None:
        """Disk and input of a task; None: there is nothing to compute."""
        raise NotImplementedError

    def next_disks(self, file: ResultFile) -> Round:
        """Tasks that are computed next, as `next_round`, at small displacements."""
        return super().next_round(file)

    def at_the_answer(self, file: ResultFile, known: Mapping[str, Any]) -> Sequence[Any]:
        """Tasks of a complete table whose disks are computed to second order; known: by `Round`."""
        return ()

    def next_round(self, file: ResultFile) -> Round:
        """The disks that are asked for; then those at the answer, to second order."""
        last, config = self.next_disks(file), file.config
        tasks = [
            task for task in (() if last.tasks else self.at_the_answer(file, last.known))
            if not file.read(BENT_STATUS, task) and (case := self.case(config, task))
            and second_order.matters(case.config, float(file.read(self.amplitude, task)))
        ]  # fmt: skip
        if not tasks:
            return last
        how = last.expected, "disks to second order", BENT_STATUS
        return Round(tasks, last.known, *how, to_second_order=True)

    def n_together(self, prepared: Any) -> int:
        """Most disks that are worth integrating together."""
        return MOST_TOGETHER if self.problem_of(prepared).basis else 1

    def compute_all(
        self, config: Config, prepared: Any, tasks: Sequence[Any], poll: Poll
    ) -> Iterator[tuple[Any, list[Values]]]:
        """Compute disks together that are of one case of the input."""
        cases: dict[Config, list[tuple[Any, Case]]] = {}
        for task in tasks:
            if case := self.case(config, task):
                cases.setdefault(case.config, []).append((task, case))
            else:
                yield task, []
        there = {line.name for line in self.datasets}
        for of, alike in cases.items():
            own = self.problem_of(prepared) if of is config else _problem_of(of)
            for k, found in peaks_of(of, own, [case.blades for _, case in alike], poll):
                task, case = alike[k]
                # every so many disks, by their number, which is the last part of a task
                asked = of.mistuning.checked_samples and not run_up.runs_up(of)
                if "followed_severity" in there and asked and np.ravel(task)[-1] % EVERY == 1:
                    longer = own._replace(scene=followed(own.scene))
                    ((_, later),) = peaks_of(of, longer, [case.blades], poll)
                    sizes = later["peak_amplitude_m"], later["peak_stress_pa"]
                    found["followed_severity"] = severity(of, *sizes)
                yield task, [(name, task, found[name]) for name in found if name in there]

    def compute_to_second_order(
        self, file: ResultFile, tasks: Sequence[Any], poll: Poll
    ) -> Iterator[tuple[Any, list[Values]]]:
        """Compute disks once more, to second order."""
        for task in tasks:
            if case := self.case(file.config, task):
                there = to_second_order(case.config)
                ((_, found),) = peaks_of(there, _problem_of(there), [case.blades], poll)
                size = np.nan_to_num(found["peak_amplitude_m"], nan=np.inf)
                yield task, [(BENT, task, size)]

    def second_order_finding(self, file: ResultFile) -> Finding | None:
        """What the disks to second order say, if there are any."""
        return second_order.of_others(file, self.which, file.read(self.amplitude), file.read(BENT))


@lru_cache(maxsize=4)
def _problem_of(config: Config) -> Problem:
    """Problem of an input, kept for further disks of the input."""
    return build_problem(config)


def peaks_of(
    config: Config, problem: Problem, disks: Sequence[np.ndarray], poll: Poll
) -> Iterator[tuple[int, dict[str, Any]]]:
    """Largest amplitude [m] of disks in contact, its speed [Hz] and status, largest stress [Pa].

    disks: stiffness deviations (N,) of each [-]. Yields (number of the disk, results by their names
    in a `table`) as disks are complete; NaN where there is none.
    """
    if run_up.runs_up(config):
        yield from enumerate(_peaks_of_runs(config, problem, disks, poll))
        return
    speeds = config.speeds.values_hz
    asked = [Disk(rubbing_modes(config, problem, blades)) for blades in disks]
    # only disks with a common basis can share the lanes
    groups = [asked] if problem.basis else [[disk] for disk in asked]
    for first, group in enumerate(groups):
        for k, result in run_sweeps(group, problem.scene, speeds, poll):
            size, at = peak(result, speeds)
            yield (
                first + k,
                {
                    "peak_amplitude_m": size,
                    "peak_speed_hz": at,
                    "peak_stress_pa": largest(result.stress, speeds)[0],
                    "peak_status": peak_status(result, speeds),
                    "deepest_m": largest(result.wear.depth, speeds)[0],
                },
            )


def _peaks_of_runs(
    config: Config, problem: Problem, disks: Sequence[np.ndarray], poll: Poll
) -> Iterator[dict[str, Any]]:
    """Largest values of disks that run up, over all rates, legs and repetitions, as `peaks_of`."""
    asked = asked_of(config)
    middles = (asked.intervals_hz[1:] + asked.intervals_hz[:-1]) / 2.0
    for blades in disks:
        modes = rubbing_modes(config, problem, blades)
        runs = [
            run_up_of(modes, problem.scene, schedule, asked, poll)
            for schedule in run_up.schedules(config)
        ]
        envelopes = np.fmax.reduce([np.fmax.reduce(run.envelope, axis=(0, 1)) for run in runs])
        stress = [run.stress[np.isfinite(run.stress)].max(initial=0.0) for run in runs]
        failed = any(are_fatal(run.reason).any() for run in runs)
        size, at = largest(envelopes, middles)
        yield {
            "peak_amplitude_m": np.nan if failed else size,
            "peak_speed_hz": np.nan if failed else at,
            "peak_stress_pa": max(stress) if config.observes_stress and not failed else np.nan,
            "peak_status": DIVERGED if failed else STEADY,
            "deepest_m": np.fmax.reduce([np.fmax.reduce(run.worn, axis=None) for run in runs]),
        }


def beyond(file: ResultFile) -> np.ndarray:
    """Whether the disks of a table were computed and exceed a limit, or have no result."""
    return (file.status != PENDING) & ~(severities(file) <= 1.0)


def left_for_others(file: ResultFile) -> Iterator[Finding]:
    """Finding about disks that are followed longer, and then lie on the other side of a limit.

    As many in either direction are chance, and leave a probability as it is; so are a few in one
    direction, which a coin shows as well with a probability above CHANCE.
    """
    before, after = severities(file) > 1.0, file.read("followed_severity")
    known = ~np.isnan(after)
    n = int(np.count_nonzero(known))
    more, less = (np.count_nonzero(known & (after > 1.0) & ~before),
                  np.count_nonzero(known & (after <= 1.0) & before))  # fmt: skip
    if more + less:
        by_chance = float(bdtrc(max(more, less) - 1, more + less, 0.5))
        is_lost = abs(more - less) > MOST_LOST * n and by_chance < CHANCE
        yield Finding(
            USELESS if is_lost else SINGLE,
            "motions that do not stay",
            f"of {counted(n, 'disk')} that were followed four times as long, to see whether their "
            f"motion stays, the limit is exceeded only then by {more}, and no more by {less}: "
            "steady_state.first_check_s and max_time_s four times as long",
        )


def limit_problems(config: Config) -> Iterator[str]:
    """Reasons why a study cannot tell the probability of exceeding a limit."""
    limits = config.limits
    if limits.amplitude_mm is None and limits.stress is None:
        yield f"limits: a {config.study} study needs limits.amplitude_mm or limits.stress_mpa"
    elif limits.stress and not (limits.stress_mpa_per_mm or config.observes_stress):
        yield "limits.stress_mpa: the model tells no stress, give limits.stress_mpa_per_mm"
    if len(config.mistuning.half_range_percent) != 1:
        yield f"mistuning.half_range_percent: a {config.study} study is of one level"
