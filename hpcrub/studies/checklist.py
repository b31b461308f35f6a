"""Sensitivity of a contact study: a few disks are computed again, with one change at a time.

A changed grid, step or model shows the error of the computation. A changed input shows how much the
answer depends on a number that is not known well. Another start of the same disks shows how much
their amplitudes change by chance.
"""

import contextlib
import itertools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from hpcrub.config import run_up
from hpcrub.config.schema import Config
from hpcrub.config.text import percent, signed_percent
from hpcrub.effects import EFFECTS
from hpcrub.effects.effect import Change, times
from hpcrub.errors import InputError
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import REMARK, SINGLE, USELESS, Finding
from hpcrub.runs import findings
from hpcrub.runs.cost import Cost
from hpcrub.runs.study import Poll, Values
from hpcrub.setup.disks import deviation, run_deviation
from hpcrub.setup.problem import allows_second_order
from hpcrub.statistics.percentiles import finite, mean_and_error
from hpcrub.studies.contact.trials import Case, Trials, table

LEAST_CHANGE = 0.01  # smallest mean change of the disks that counts [-]
LARGE_CHANGE = 0.05  # change by grid, step or model, at most, that makes a study useless [-]


def _smaller_clearance(c: Any) -> dict[Any, Any]:
    smaller = {"casing.clearance_offset_mm": 0.9 * c.casing.clearance_offset_mm}
    for key in ("clearance_hz_mm", "clearance_s_mm"):
        if points := getattr(c.casing, key):
            return smaller | {f"casing.{key}": [[at, 0.9 * clearance] for at, clearance in points]}
    return smaller | {"casing.clearance_mm": 0.9 * c.casing.clearance_mm}


def _higher_harmonics(c: Any) -> dict[Any, Any]:
    higher = [h.model_dump() | {"amplitude_mm": 1.1 * h.amplitude_mm} for h in c.casing.harmonics]
    return {"casing.harmonics": higher} if higher else {}


def _is_steady(c: Any) -> bool:
    """Whether disks turn at constant speeds, and do not run up."""
    return not run_up.runs_up(c)


CHANGES = (
    Change("as asked", "", times({}), True),
    Change("another start", "mistuning.tuned_runs", times({}), True, 1),
    Change("half the step of the speeds", "speeds.step_hz", times(
        {"speeds.step_hz": 0.5}, where=_is_steady), True),
    Change("half the time step", "time.step_s", times(
        {"time.steps_per_bump_width": 2, "time.steps_per_period": 2, "time.step_s": 0.5}), True),
    Change("twice the modes", "reduction.n_modes", times({"reduction.n_modes": 2}), True),
    Change("followed twice as long", "steady_state.first_check_s", times(
        {"steady_state.first_check_s": 2, "steady_state.max_time_s": 2},
        where=_is_steady), True),
    Change("displacements to second order", "contact.kinematics", lambda c: (
        {"contact.kinematics": "second_order"} if allows_second_order(c) else {}), True),
    Change("half the damping", "material.damping_ratio", times(
        {"material.damping_ratio": 0.5, "material.damping_ratios": 0.5})),
    Change("friction higher by 0.05", "contact.friction",
           lambda c: {"contact.friction": c.contact.friction + 0.05}),
    Change("clearance 10 % smaller", "casing.clearance_mm", _smaller_clearance),
    Change("bumps 10 % higher", "casing.bump_height_mm", times(
        {"casing.bump_height_mm": 1.1}, where=lambda c: c.casing.bump_height_mm > 0.0)),
    Change("harmonics 10 % higher", "casing.harmonics", _higher_harmonics),
    *(change for effect in EFFECTS for change in effect.changes),
)  # fmt: skip
NUMBERED = ", ".join(f"{number} {change.what}" for number, change in enumerate(CHANGES))
NOTE = f"; NaN: not computed, infinite: no result; disk 0: tuned; change: {NUMBERED}"


class Checklist(Trials):
    """A few disks of a contact study, with one change after the other."""

    name = "checklist"
    what = "what moves the answer of a contact study, before it is signed"
    sections = ("checklist", "run_up")
    of_tasks, unit = True, "tasks"
    datasets = table("change", "disk", note=NOTE)

    def sizes(self, config: Config) -> dict[str, int]:
        """Numbers of changes and of disks, the tuned one included."""
        return {"change": len(CHANGES), "disk": _n_disks(config)}

    def n_tasks(self, config: Config) -> int:
        """One task for every change and disk; the disks of one change follow each other."""
        return len(CHANGES) * _n_disks(config)

    def cost(self, config: Config) -> Cost:
        """Cost of all changes; those of speeds, step and time take twice as long as others."""
        disks = _n_disks(config)
        return Cost((len(CHANGES) + 3) * disks, disks=len(CHANGES) * disks)

    def case(self, config: Config, task: int) -> Case | None:
        """One disk with one change; None where the change does not apply."""
        number, disk = divmod(task, _n_disks(config))
        change, level = CHANGES[number], len(config.mistuning.half_range) - 1
        values = change.values(config)
        if number and not values and not change.run:
            return None
        own = deviation(config, level, disk - 1) if disk else run_deviation(config, 0)
        if change.run:
            own = own + run_deviation(config, change.run)
        return Case(config.replace(values) if values else config, own)

    def compute_all(
        self, config: Config, prepared: Any, tasks: Sequence[int], poll: Poll
    ) -> Iterator[tuple[int, list[Values]]]:
        """Compute disks with a change each, whose amplitude is infinite without a result."""
        n_disks = _n_disks(config)
        for _, alike in itertools.groupby(tasks, lambda task: task // n_disks):
            left = list(alike)
            with contextlib.suppress(InputError):  # for example more modes than a model has
                for task, found in super().compute_all(config, prepared, tuple(left), poll):
                    left.remove(task)
                    values = {name: value for name, _, value in found}
                    if not np.isfinite(values.get("peak_amplitude_m", 0.0)):
                        values["peak_amplitude_m"] = np.inf
                    place = divmod(task, n_disks)
                    yield task, [(name, place, value) for name, value in values.items()]
            yield from ((task, []) for task in left)

    def report(self, file: ResultFile) -> Iterator[str]:
        """Lines about the effect of every change."""
        size = 1e3 * file.read("peak_amplitude_m")
        if not np.isfinite(size[0]).any():
            yield "no disk has a largest amplitude"
            return
        mistuned = finite(size[0, 1:])
        middle = f"{np.median(mistuned):.4g} mm" if len(mistuned) else "-"
        yield (
            f"as asked: tuned {size[0, 0]:.4g} mm, median of {len(mistuned)} mistuned disks "
            f"{middle}; what follows is the change of all of them"
        )
        for change, (mean, error, most) in zip(CHANGES[1:], moved(size), strict=True):
            if np.isfinite(mean):
                yield (
                    f"{change.what + ':':<29}{100 * mean:+6.1f} ± {100 * error:.1f} %, "
                    f"a single disk by up to {100 * most:.0f} %"
                    + (f": {change.key} moves the answer" if _is_shown(mean, error) else "")
                )

    def findings(self, file: ResultFile) -> Iterator[Finding]:
        """Changes of the computation that move the answer, and inputs that must be known well."""
        size = file.read("peak_amplitude_m")
        lost, n = np.isinf(size), size.shape[1]
        asked, states = size[0][~np.isnan(size[0])], file.read("peak_status")
        yield from findings.of_disks(file.config, asked, states, "no change of them is known")
        for change, gone in zip(CHANGES[1:], lost[1:] & ~lost[0], strict=True):
            if gone.any():
                words = f"{np.count_nonzero(gone)} of {n} disks have no result with {change.what}"
                severity = USELESS if change.is_error else SINGLE
                yield Finding(severity, words, f"{words}: {change.key}")
        for change, (mean, error, _) in zip(CHANGES[1:], moved(size), strict=True):
            words = f"{change.what} moves the answer by {signed_percent(mean)} %"
            if not change.is_error:
                if _is_shown(mean, error):
                    yield Finding(REMARK, words, f"{words}: {change.key} must be known that well")
                continue
            advice, most = f"{words}: {change.key}", abs(mean) + error
            if not _is_shown(mean, error):  # few disks leave it open: it is not called small
                words = f"{change.what} may move the answer by up to {percent(most)} %"
                advice = (
                    f"{words} ({signed_percent(mean)} ± {percent(error)} %): {change.key}, or more "
                    "checklist.disks tell whether it does"
                )
            if most > LEAST_CHANGE:
                yield Finding(USELESS if most > LARGE_CHANGE else SINGLE, words, advice)


def moved(size: np.ndarray) -> list[tuple[float, float, float]]:
    """Mean relative change, half its 95 % interval and largest change of a disk, by row.

    The interval is that of Student, because the disks are few.
    size: largest amplitudes (changes, disks), row 0 without a change. NaN where fewer than two
    disks have an amplitude in the row and in row 0.
    """
    moves = []
    for row in size[1:]:
        known = np.isfinite(row) & np.isfinite(size[0])
        ratio = row[known] / size[0][known] - 1.0
        if len(ratio) < 2:
            moves.append((np.nan, np.nan, np.nan))
            continue
        moves.append((*mean_and_error(ratio), float(np.abs(ratio).max())))
    return moves


def _n_disks(config: Config) -> Any:
    """Number of disks: the tuned one, and mistuned ones up to the number of samples."""
    return 1 + min(config.checklist.disks, config.mistuning.samples)


def _is_shown(mean: float, error: float) -> bool:
    """Whether a change is certainly more than chance, and more than LEAST_CHANGE."""
    return abs(mean) > max(error, LEAST_CHANGE)


STUDY = Checklist()
