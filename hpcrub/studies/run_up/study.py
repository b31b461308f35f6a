"""Run-up and run-down of many disks: the tuned disk, and all samples of all levels.

Every disk runs up at every rate, with repetitions that begin at evenly spaced angles of the casing:
what they scatter is chance, what disks scatter is mistuning.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from hpcrub.config import run_up
from hpcrub.config.schema import Config
from hpcrub.contact import status
from hpcrub.errors import InputError
from hpcrub.response.run_up import Run, Runner
from hpcrub.results.layout import LEVELS, PENDING, Dataset, Values
from hpcrub.results.storage import ResultFile
from hpcrub.runs.cost import Cost
from hpcrub.runs.job import Round
from hpcrub.runs.kept import Kept
from hpcrub.runs.study import Poll, Study
from hpcrub.setup import imported
from hpcrub.setup.disks import deviation, rubbing_modes, run_deviation, sigma_of
from hpcrub.setup.problem import Problem, build_problem, to_second_order
from hpcrub.setup.run_up import asked_of
from hpcrub.studies.contact import second_order
from hpcrub.studies.contact.amplification import finer
from hpcrub.studies.contact.study import APART, open_contact, require_complete
from hpcrub.studies.run_up import summary

_RUN = ("rate", "repetition", "leg")
_TIP = "largest tangential displacement of any tip"
OF_DISK = (
    Dataset("envelope_m", (*_RUN, "interval"), "m", f"{_TIP} in an interval of speed"),
    Dataset("peak_amplitude_m", _RUN, "m", f"{_TIP} in a leg"),
    Dataset("peak_speed_hz", _RUN, "Hz", "middle of the interval of speed where it is reached"),
    Dataset("seconds_above_s", _RUN, "s", "time in which a limit is exceeded, to a revolution"),
    Dataset("cycles_above", _RUN, "1", "cycles of the tip that moves furthest in this time"),
    Dataset("run_reason", _RUN[:2], "1", status.POINT_REASON, "u1"),
)
OF_STRESS = (
    Dataset("envelope_stress_pa", (*_RUN, "interval"), "Pa", "largest stress in an interval"),
    Dataset("peak_stress_pa", _RUN, "Pa", "largest stress in a leg"),
)
OF_COATING = (Dataset("worn_depth_m", _RUN, "m", "largest worn depth at the end of a leg"),)
LAYOUT = (
    Dataset("hz_per_s", ("rate",), "Hz/s", "gain of speed of each run; of a table the largest"),
    Dataset("interval_hz", ("interval",), "Hz", "middles of the intervals of speed"),
    Dataset("rises", ("leg",), "1", "legs: 1 the speed rises, 0 it falls", "u1"),
    *LEVELS,
    Dataset("frequency_hz", ("frequency",), "Hz", "frequencies of the spectra"),
    Dataset(
        "tuned/spectrum_m", ("rate", "leg", "interval", "frequency"), "m",
        "amplitudes of the tip that moves furthest in an interval, in the first repetition"),
    Dataset("tuned/half_step_peak_m", _RUN, "m", "peak_amplitude_m with half the time step"),
    Dataset("samples/deviation", ("level", "sample", "blade"), "1", "stiffness deviations"),
    Dataset(
        "samples/amplification", ("level", "sample", "rate", "leg"), "1",
        "median peak of the repetitions over that of the tuned disk in the same leg; NaN: that one "
        "hardly moves"),
    Dataset("tuned/run_status", ("rate",), "1", "0 pending, 1 done", "u1"),
    Dataset("tuned/second_order_peak_m", _RUN, "m",
            "peak_amplitude_m to second order at one rate; NaN: not computed, infinite: no result"),
    Dataset(summary.BENT_STATUS, ("rate",), "1", "1: computed to second order, too", "u1"),
)  # fmt: skip
STEADY = (
    Dataset("steady_speed_hz", ("steady_speed",), "Hz", "speeds of the contact study of sources"),
    Dataset("tuned/steady_amplitude_m", ("steady_speed",), "m", "its amplitude of the tuned disk"),
    Dataset("tuned/steady_reference_m", (), "m", "its reference"),
    Dataset("samples/steady_peak_m", ("level", "sample"), "m", "its peak of the same disk"),
)


class RunUp(Study):
    """Disks while the rotor gains and loses speed."""

    name = "run_up"
    what = "run-up and run-down in time, percentiles over the rates"
    sections = ("run_up", "spectrum", "part")
    scales = {
        "rate": "hz_per_s", "interval": "interval_hz", "level": "half_range",
        "frequency": "frequency_hz", "steady_speed": "steady_speed_hz",
    }  # fmt: skip
    integrates = True
    to_second_order = True
    of_tasks = False
    unit = "disks"
    derived = "samples/amplification", "samples/steady_peak_m"
    report = staticmethod(summary.report)
    answer = staticmethod(summary.answer)
    findings = staticmethod(summary.findings)

    def layout(self, config: Config) -> tuple[Dataset, ...]:
        """Datasets of the result file."""
        extra = OF_STRESS * config.observes_stress + OF_COATING * config.contact.wears
        of_disk = *OF_DISK, *extra
        samples = ("level", "sample")
        return (
            *LAYOUT,
            *(line._replace(name=f"tuned/{line.name}") for line in of_disk),
            *(
                line._replace(name=f"samples/{line.name}", dimensions=samples + line.dimensions)
                for line in of_disk
            ),
            Dataset("samples/status", samples, "1", "0 pending, 1 done", "u1"),
            *(STEADY if config.sources else ()),
        )

    def sizes(self, config: Config) -> dict[str, int]:
        """Lengths of this study's own dimensions."""
        runs = run_up.schedules(config)
        return {
            "rate": len(runs),
            "repetition": config.run_up.repeats,
            "leg": len(runs[0].leg_ends),
            "interval": len(run_up.intervals(config)) - 1,
            "frequency": config.spectrum.n_frequencies,
        }

    def source_sizes(self, config: Config) -> dict[str, int]:
        """Number of speeds of the contact study in `sources`."""
        if not config.sources:
            return {}
        with open_contact(config.sources[0]) as file:
            return {"steady_speed": file.config.speeds.n_values}

    def constants(self, config: Config) -> dict[str, Any]:
        """Rates, intervals and levels, and the steady study of the same disks."""
        borders, schedule = run_up.intervals(config), run_up.schedules(config)[0]
        return {
            "hz_per_s": run_up.rates(config),
            "interval_hz": (borders[1:] + borders[:-1]) / 2.0,
            "rises": schedule.leg_rises,
            "half_range": config.mistuning.half_range[list(config.levels)],
            "sigma": sigma_of(config),
            "sample": np.array(config.samples),
            "frequency_hz": asked_of(config, spectra=True).frequencies_hz,
            **(_steady(config) if config.sources else {}),
        }

    def problems(self, config: Config) -> Iterator[str]:
        """Keys that do not fit this study."""
        if len(config.sources) > 1:
            yield f"sources: {len(config.sources)} result files given, a run_up takes one at most"

    def cost(self, config: Config) -> Cost:
        """Steps of all repetitions of all disks, and of the tuned disk with half the step."""
        n_disks = len(config.levels) * len(config.samples)
        return Cost(n_disks + 3 + second_order.cost(config, 1), disks=n_disks + 1)

    def prepare(self, config: Config) -> Any:
        """Prepare a Problem. Raises InputError for speeds beyond the matrices of a model file."""
        known, (low, high) = imported.known_speeds(config), sorted(run_up.ends_of(config))
        if len(known) and not known.min() <= low <= high <= known.max():
            raise InputError(
                f"run_up.to_hz: a run from {low:g} to {high:g} Hz, but matrices of {known.min():g} "
                f"to {known.max():g} Hz in {config.disk.model}; import matrices of higher speeds"
            )
        return super().prepare(config)

    def warnings(self, config: Config, prepared: Any) -> Iterator[str]:
        """Warnings of any study in time, and the force by the gain of speed, which is left out."""
        yield from super().warnings(config, prepared)
        yield from summary.euler_line(config, prepared)

    def parts(self, file: ResultFile) -> np.ndarray:
        """Status of the tuned disk at every rate, then of all samples."""
        return np.append(file.read("tuned/run_status"), file.read("samples/status"))

    def n_parts(self, status: np.ndarray, task: Any) -> int:
        """Every task is one part."""
        return 1

    def next_round(self, file: ResultFile) -> Round:
        """The tuned disk at the rates that are pending, then the pending samples."""
        rates = np.flatnonzero(file.read("tuned/run_status") == PENDING).tolist()
        if rates:
            return Round([(rate,) for rate in rates], status="tuned/run_status")
        tasks = np.argwhere(file.read("samples/status") == PENDING)
        tasks = tasks[np.argsort(tasks[:, 1], kind="stable")]  # all levels of a sample together
        if len(tasks):
            return Round([tuple(task) for task in tasks.tolist()], status="samples/status")
        known = {"samples/amplification": summary.amplifications(file)}
        bent = [(rate,) for rate in summary.pending_to_second_order(file)]
        phase, where = "disks to second order", summary.BENT_STATUS
        return Round(bent, known, None, phase, where, to_second_order=True)

    def compute_all(
        self, config: Config, prepared: Any, tasks: Sequence[Any], poll: Poll
    ) -> Iterator[tuple[Any, list[Values]]]:
        """Run the tuned disk up at one rate, or a sample at all rates.

        tasks: (rate,), or level and number of a sample. The kept states of a task are forgotten
        when the next one is asked for: its results are in the file then.
        """
        problem: Problem = self.problem_of(prepared)
        for task in tasks:
            if len(task) == 1:
                kept = [Kept(config, ("tuned", task[0], *half)) for half in ((), ("half",))]
                found = _tuned(config, problem, task[0], kept, poll)
            else:
                disk = task[0], config.samples[task[1]]
                rates = range(len(run_up.schedules(config)))
                kept = [Kept(config, (*disk, rate)) for rate in rates]
                found = _sample(config, problem, task, kept, poll)
            yield task, list(found)
            for state in kept:
                state.forget()

    def compute_to_second_order(
        self, file: ResultFile, tasks: Sequence[Any], poll: Poll
    ) -> Iterator[tuple[Any, list[Values]]]:
        """Run the tuned disk up once more at one rate, to second order; tasks: (rate,)."""
        bent = to_second_order(file.config)
        problem = build_problem(bent)
        modes = rubbing_modes(bent, problem, run_deviation(bent, 0))
        for (rate,) in tasks:
            runner = Runner(modes, problem.scene, run_up.schedules(bent)[rate], asked_of(bent))
            kept = Kept(file.config, ("tuned", rate, "bent"))
            peak = np.fmax.reduce(kept.finish(runner, poll).envelope, axis=-1)
            yield (rate,), [("tuned/second_order_peak_m", rate, np.nan_to_num(peak, nan=np.inf))]
            kept.forget()

    def has_tuned(self, file: ResultFile) -> bool:
        """Whether the tuned disk is complete."""
        return not (file.read("tuned/run_status") == PENDING).any()

    def conclusion(self, file: ResultFile, usable: bool) -> list[str]:
        """Peaks at every rate, and how often they exceed the limits."""
        return [*summary.report(file), *summary.limit_lines(file)]

    def complete(self, run: Any, file: ResultFile) -> None:
        """Write the amplifications."""
        file.write({"samples/amplification": summary.amplifications(file)}, ())


def _sample(
    config: Config, problem: Problem, task: tuple[int, int], kept: list[Kept], poll: Poll
) -> Iterator[Values]:
    """Results of a sample at all rates; task: its level and number; kept: a state for each rate."""
    blades = deviation(config, *task)
    yield "samples/deviation", task, blades
    modes = rubbing_modes(config, problem, blades)
    for rate, (schedule, state) in enumerate(zip(run_up.schedules(config), kept, strict=True)):
        runner = Runner(modes, problem.scene, schedule, asked_of(config))
        for name, values in _values(config, state.finish(runner, poll)).items():
            yield f"samples/{name}", (*task, rate), values


def _tuned(
    config: Config, problem: Problem, rate: int, kept: list[Kept], poll: Poll
) -> Iterator[Values]:
    """Results of the tuned disk at one rate, with half the time step, too; kept: both states."""
    modes = rubbing_modes(config, problem, run_deviation(config, 0))
    schedule, scene = run_up.schedules(config)[rate], problem.scene
    runner = Runner(modes, scene, schedule, asked_of(config, spectra=True))
    run = kept[0].finish(runner, poll)
    for name, values in _values(config, run).items():
        yield f"tuned/{name}", rate, values
    yield "tuned/spectrum_m", rate, run.spectrum
    half = kept[1].finish(Runner(modes, finer(scene), schedule, asked_of(config)), poll)
    yield "tuned/half_step_peak_m", rate, np.fmax.reduce(half.envelope, axis=-1)


def _values(config: Config, run: Run) -> dict[str, np.ndarray]:
    """Results of a run by their names in the file."""
    borders, peak = run_up.intervals(config), np.fmax.reduce(run.envelope, axis=-1)
    known = np.isfinite(peak)
    best = np.nan_to_num(run.envelope, nan=-1.0).argmax(axis=-1)
    middle = (borders[1:] + borders[:-1]) / 2.0
    values = {
        "envelope_m": run.envelope,
        "peak_amplitude_m": peak,
        "peak_speed_hz": np.where(known, middle[best], np.nan),
        "seconds_above_s": run.seconds,
        "cycles_above": run.cycles,
        "run_reason": run.reason,
    }
    if config.observes_stress:
        largest = np.fmax.reduce(run.stress, axis=-1)
        values |= {"envelope_stress_pa": run.stress, "peak_stress_pa": largest}
    if config.contact.wears:
        values["worn_depth_m"] = run.worn
    return values


def _steady(config: Config) -> dict[str, Any]:
    """Amplitudes of the contact study in `sources`, whose disks must be those of this study."""
    with open_contact(config.sources[0]) as file:
        require_complete(file, config, (*APART, "speeds.", "casing.clearance_s_mm"))
        n, levels = len(config.samples), len(config.levels)
        mine = [[deviation(config, k, i) for i in range(n)] for k in range(levels)]
        here = slice(config.samples.start, config.samples.stop)
        theirs = file.read("samples/deviation")[:, here]
        if theirs.shape[:2] != (levels, n) or (theirs != mine).any():
            raise InputError(
                f"sources: {file.path} has other disks; mistuning of both studies must be the "
                "same, and the contact study must have as many samples"
            )
        return {
            "steady_speed_hz": file.read("speeds_hz"),
            "tuned/steady_amplitude_m": file.read("tuned/amplitude_m"),
            "tuned/steady_reference_m": file.read("tuned/reference_amplitude_m"),
            "samples/steady_peak_m": file.read("samples/peak_amplitude_m")[:, here],
        }


STUDY = RunUp()
