"""What moves the answer of a contact study: a few disks again with one thing changed.

A changed grid, step or model shows the error of the computation, a changed input how much the
answer owes to a number that is not known well. Another start of the same disks shows how much they
change by chance.
"""

from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.response.sweep import run_sweep
from hpcrub.results.layout import Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.runs import verdict
from hpcrub.runs.cost import Cost
from hpcrub.runs.study import Poll, Study, Values
from hpcrub.runs.verdict import REMARK, SINGLE, USELESS, Finding
from hpcrub.setup.disks import APART, deviation, modes_of
from hpcrub.setup.plausibility import steady_problems
from hpcrub.setup.problem import build_problem
from hpcrub.statistics.percentiles import Z_95
from hpcrub.studies.contact.amplification import peak, peak_stress

LEAST = 0.01  # mean change of the disks that counts [-]
LARGE = 0.05  # and one of the computation that makes a study useless [-]


class Change(NamedTuple):
    """One thing that is changed."""

    what: str
    key: str  # to look at where the answer moves
    values: Callable[[Config], dict[str, Any]]  # of other keys; empty where the scene has no such
    is_error: bool  # of the computation; False: an input that is not known exactly
    start: float = 0.0  # added to the stiffness deviation of all blades [-]


def _finer_time(c):
    names = "time.steps_per_bump_width", "time.steps_per_period"
    finer = {name: 2.0 * getattr(c.time, name.partition(".")[2]) for name in names}
    return finer | {"time.step_s": c.time.step_s / 2.0}


def _longer(c):
    steady = c.steady_state
    return {
        "steady_state.first_check_s": 2.0 * steady.first_check_s,
        "steady_state.max_time_s": 2.0 * steady.max_time_s,
    }


def _damping(c):
    if c.material.damping_ratios is None:
        return {"material.damping_ratio": c.material.damping_ratio / 2.0}
    return {"material.damping_ratios": [ratio / 2.0 for ratio in c.material.damping_ratios]}


def _coating(c):
    yields = 1.2 * c.contact.coating.yield_mpa
    return {"contact.coating.yield_mpa": yields} if c.contact.wears else {}


def _bumps(c):
    height = c.casing.bump_height_mm
    return {"casing.bump_height_mm": 1.1 * height} if height else {}


CHANGES = (
    Change("as asked", "", lambda c: {}, True),
    Change("another start", "mistuning.tuned_runs", lambda c: {}, True, APART),
    Change("half the step of the speeds", "speeds.step_hz",
           lambda c: {"speeds.step_hz": c.speeds.step_hz / 2.0}, True),
    Change("half the time step", "time.step_s", _finer_time, True),
    Change("twice the modes", "reduction.n_modes",
           lambda c: {"reduction.n_modes": 2 * c.reduction.n_modes}, True),
    Change("followed twice as long", "steady_state.first_check_s", _longer, True),
    Change("half the damping", "material.damping_ratio", _damping, False),
    Change("friction higher by 0.05", "contact.friction",
           lambda c: {"contact.friction": c.contact.friction + 0.05}, False),
    Change("clearance 10 % smaller", "casing.clearance_mm",
           lambda c: {"casing.clearance_mm": 0.9 * c.casing.clearance_mm}, False),
    Change("bumps 10 % higher", "casing.bump_height_mm", _bumps, False),
    Change("coating 20 % harder", "contact.coating.yield_mpa", _coating, False),
)  # fmt: skip
_CD = ("change", "disk")
NUMBERED = ", ".join(f"{number} {change.what}" for number, change in enumerate(CHANGES))
LAYOUT = (
    Dataset("peak_amplitude_m", _CD, "m",
            f"largest amplitude over the speeds; disk 0: tuned; change: {NUMBERED}"),
    Dataset("peak_stress_pa", _CD, "Pa", "largest stress over the speeds"),
)  # fmt: skip


class Checklist(Study):
    """A few disks of a contact study with one thing changed after the other."""

    name = "checklist"
    what = "what moves the answer of a contact study, before it is signed"
    sections = ("checklist",)
    integrates = True
    datasets = LAYOUT

    def sizes(self, config: Config) -> dict[str, int]:
        """Changes, and the tuned disk beside the mistuned ones."""
        return {"change": len(CHANGES), "disk": _n_disks(config)}

    def problems(self, config: Config) -> Iterator[str]:
        """Keys that do not fit this study."""
        yield from steady_problems(config)

    def n_tasks(self, config: Config) -> int:
        """One for every change and disk, so that the disks of one change follow each other."""
        return len(CHANGES) * (_n_disks(config))

    def cost(self, config: Config, until_steady: float) -> Cost:
        """The changes of speeds, step and time take twice as long as the others."""
        disks = _n_disks(config)
        points = (len(CHANGES) + 3) * disks * config.speeds.n_values
        return Cost(points * until_steady, disks=len(CHANGES) * disks)

    def compute(self, config: Config, problem: Any, task: int, poll: Poll) -> Iterator[Values]:
        """One disk with one change; NaN where the scene has no such thing."""
        change, disk = divmod(task, _n_disks(config))
        size = stress = np.nan
        try:
            here, changed = _changed(config.to_yaml(), change)
        except InputError:  # more modes than a model has, for one
            changed = None
        if changed:
            level = len(here.mistuning.half_range) - 1
            own = deviation(here, level, disk - 1) if disk else np.zeros(here.disk.n_blades)
            modes = modes_of(here, changed, own + CHANGES[change].start)
            result = run_sweep(modes, changed.scene, here.speeds.values_hz, poll)
            size, stress = peak(result, here.speeds.values_hz)[0], peak_stress(result)
        yield "peak_amplitude_m", (change, disk), size
        yield "peak_stress_pa", (change, disk), stress

    def report(self, file: ResultFile) -> Iterator[str]:
        """What every change does."""
        size = 1e3 * file.read("peak_amplitude_m")
        if not np.isfinite(size[0]).any():
            yield "no disk has a largest amplitude yet"
            return
        n = np.count_nonzero(np.isfinite(size[0, 1:]))
        yield (
            f"as asked: tuned {size[0, 0]:.4g} mm, median of {n} mistuned disks "
            f"{np.nanmedian(size[0, 1:]):.4g} mm; what follows is the change of all of them"
        )
        for change, (mean, error, most) in zip(CHANGES[1:], moved(size), strict=True):
            if np.isfinite(mean):
                yield (
                    f"{change.what + ':':<29}{100 * mean:+6.1f} ± {100 * error:.1f} %, "
                    f"a single disk by up to {100 * most:.0f} %"
                    + (f": {change.key} moves the answer" if _counts(mean, error) else "")
                )

    def findings(self, file: ResultFile) -> Iterator[Finding]:
        """Changes of the computation that move the answer, and inputs that must be known well."""
        size = file.read("peak_amplitude_m")
        for change, (mean, error, _) in zip(CHANGES[1:], moved(size), strict=True):
            if not _counts(mean, error):
                continue
            words = f"{change.what} moves the answer by {100 * mean:+.2g} %"
            if change.is_error:
                weight = USELESS if abs(mean) > LARGE else SINGLE
                yield Finding(weight, words, f"{words}: {change.key}")
            else:
                yield Finding(REMARK, words, f"{words}: {change.key} must be known that well")
        yield from verdict.kinematics(file.config, float(np.nan_to_num(size[0]).max()))


def moved(size: np.ndarray) -> list[tuple[float, float, float]]:
    """Mean relative change, half of its 95 % interval and largest of a disk, of every change.

    size: largest amplitudes (changes, disks), the first row as asked. NaN where fewer than two
    disks have both.
    """
    found = []
    for row in size[1:]:
        ratio = row / size[0] - 1.0
        ratio = ratio[np.isfinite(ratio)]
        if len(ratio) < 2:
            found.append((np.nan, np.nan, np.nan))
            continue
        error = Z_95 * ratio.std(ddof=1) / np.sqrt(len(ratio))
        found.append((float(ratio.mean()), float(error), float(np.abs(ratio).max())))
    return found


def _n_disks(config):
    """The tuned disk, and mistuned ones as far as there are so many."""
    return 1 + min(config.checklist.disks, config.mistuning.samples)


def _counts(mean, error):
    """Whether a change is more than chance, and more than nothing."""
    return bool(abs(mean) > max(error, LEAST))


@lru_cache(maxsize=2)
def _changed(text, number):
    """Configuration and Problem with a change, kept for all disks; None where nothing changes.

    Raises InputError for a change that the input does not allow.
    """
    config, change = Config.from_yaml(text), CHANGES[number]
    values = change.values(config)
    if not values and number and not change.start:
        return config, None
    config = config.replace(values) if values else config
    return config, build_problem(config)


STUDY = Checklist()
