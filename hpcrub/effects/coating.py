"""A coating on the casing that wears: its depth, volume and energy, and who cuts through."""

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.config.text import counted, percent
from hpcrub.contact.lanes import WIDTH
from hpcrub.effects.effect import (
    Change,
    Effect,
    History,
    Kind,
    largest,
    range_of_disks,
    times,
)
from hpcrub.model.coating import Coating
from hpcrub.model.reduction import Modes
from hpcrub.response.quantities import Quantity
from hpcrub.response.revolution import Grid
from hpcrub.response.sweep import SweepResult
from hpcrub.response.wear import ENDED, N_ANGLES, REVOLUTIONS, Wear
from hpcrub.results.layout import ANGLE, Dataset, datasets
from hpcrub.results.samples import of_levels
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import MOST_LOST, SINGLE, USELESS, Finding
from hpcrub.statistics.percentiles import Z_95, finite, probability_interval

REACHED = 1.0 - 1e-9  # share of a coating's depth that counts as worn through: rounding
*POINTS, AROUND = Wear.declared().values()  # the last is over strip and angle, too
DEEPEST = Quantity("deepest_m", "m", "largest worn depth of any speed")
OF_CONTACT = (
    Dataset(
        "tuned/run_deepest_m", ("run",), "m",
        "largest worn depth of any speed: the runs of the tuned disk",
    ),
    *datasets("tuned", ("speed", "strip", "angle"), [AROUND]),
    ANGLE,
)  # fmt: skip
OF_TIME = (
    Dataset("block_s", ("block",), "s", "ends of the parts of a turn after which depths are kept"),
    Dataset("worn_depth_m", ("disk", "block"), "m", "largest worn depth of the coating until then"),
)
OF_ENERGY = (
    Dataset("tuned/wear_energy_j", ("speed",), "J", "energy that the wear by the tuned disk took"),
    Dataset(
        "wear_energy_j", ("sample", "speed"), "J",
        "energy that has gone into the wear of the coating",
    ),
)  # fmt: skip


def _of_histories(*dimensions: Any) -> Any:
    """All datasets of the coating in the group `wear`, for studies of whole motions."""
    around = datasets("wear", (*dimensions, "strip", "angle"), [AROUND])
    return (*datasets("wear", dimensions, POINTS), *around, ANGLE)


class Wearing(Effect):
    """A coating that wears."""

    name = "wear"
    needed = "a coating that wears (contact.law: abradable)"
    unsettled = "may cut deeper"
    amplitude = "largest_amplitude_m"
    datasets: ClassVar = {
        "contact": OF_CONTACT,
        "energy": OF_ENERGY,
        "time_response": (*OF_TIME, *_of_histories("disk")),
        "interaction_map": _of_histories("disk", "speed"),
    }
    points = tuple(POINTS)
    peaks = (
        DEEPEST,
        Quantity("deepest_speed_hz", "Hz", "speed of the largest worn depth"),
    )
    kinds = (
        Kind("amplitude", "peak_amplitude_m", "m", "largest amplitudes, of any time"),
        Kind("worn_depth", DEEPEST.name, "m", "largest worn depths of any speed"),
    )
    changes = (
        Change("coating 20 % harder", "contact.coating.yield_mpa", times(
            {"contact.coating.yield_mpa": 1.2}, where=lambda c: c.contact.wears)),
    )  # fmt: skip

    def exists(self, config: Config) -> bool:
        """Whether the contact law is abradable."""
        return config.contact.wears

    def n_numbers(self, config: Config, grid: Grid) -> int:
        """Worn depths of all lanes, now and after some windows, and of the results."""
        kept = 3 + REVOLUTIONS // config.steady_state.window_revolutions
        bars = WIDTH * grid.steps_per_revolution * kept
        results = config.speeds.n_values * N_ANGLES * (1 + config.mistuning.tuned_runs)
        return config.disk.n_strips * (bars + results)

    def of_disk(self, result: SweepResult, speeds_hz: np.ndarray) -> dict[str, float]:
        """Largest worn depth, and its speed."""
        deepest = largest(result.wear.depth, speeds_hz)
        return dict(zip([peak.name for peak in self.peaks], deepest, strict=True))

    def of_tuned(
        self, config: Config, modes: Modes, runs: list[dict[str, Any]]
    ) -> dict[str, np.ndarray]:
        """Largest worn depths of the runs."""
        return {"run_deepest_m": np.array([run[DEEPEST.name] for run in runs])}

    def of_history(self, study: str, history: History) -> Iterator[tuple[str, Any]]:
        """Wear in the end, and the depth over the time."""
        if study == "time_response":
            yield "worn_depth_m", history.worn_depth
        for name, values in history.wear().by_name().items():
            yield f"wear/{name}", values[0]

    def lines(self, file: ResultFile, disk: int) -> Iterator[str]:
        """Worn depths, and energies of the wear."""
        if file.config.study == "contact":
            yield from _lines_of_disks(file)
        elif file.config.study == "energy":
            low, high, tuned = range_of_disks(file, "wear_energy_j")
            yield f"wear takes {low:.3g} to {high:.3g} J, tuned {tuned:.3g} J"
        elif file.config.study in self.datasets:
            yield from _lines_of_motions(file, disk)

    def findings(self, file: ResultFile) -> Iterator[Finding]:
        """Disks that cut through the coating and reach the casing behind it."""
        if file.config.study != "contact":
            return
        depth = np.concatenate([file.read("tuned/run_deepest_m"), *of_levels(file, DEEPEST.name)])
        yield from cut_through(file.config, depth, "disks and runs of the tuned one")


def cut_through(config: Config, depth: np.ndarray, who: str) -> Iterator[Finding]:
    """Finding about disks or runs (who) that cut through the coating; depth: largest of each [m].

    NaN is the depth of those without a result.
    """
    n = int(np.count_nonzero(np.isfinite(depth)))
    through = int(np.count_nonzero(depth >= REACHED * depth_of_all(config)))
    if through:
        yield Finding(
            USELESS if through > MOST_LOST * n else SINGLE,
            f"{through} of {n} {who} cut through the coating",
            f"{through} of {n} {who} cut through the coating and reach the casing: read that "
            "share, not amplitudes or their percentiles; contact.coating.thickness_mm or "
            "casing.clearance_mm decide it",
        )


def _lines_of_motions(file: ResultFile, disk: int) -> Iterator[str]:
    """Wear by a disk at the speed of its deepest cut."""
    numbers = {of.name: np.atleast_1d(file.read(f"wear/{of.name}", disk)) for of in POINTS}
    depth, growth = numbers["worn_depth_m"], numbers["worn_growth_m"]
    if not np.isfinite(depth).any():
        return
    at = int(np.nanargmax(depth))
    here = {name: values[at] for name, values in numbers.items()}
    speeds = file.config.speeds.values_hz
    where = f" at {speeds[at]:g} Hz" if len(speeds) > 1 else ""
    if not depth[at] > 0.0:
        yield "nothing of the coating is worn"
        return
    yield (
        f"worn{where} {1e3 * depth[at]:.3g} mm deep in {here['lobes']:.0f} lobes, "
        f"{1e9 * here['worn_volume_m3']:.3g} mm³ with {here['wear_energy_j']:.3g} J; "
        f"largest amplitude {1e3 * here['largest_amplitude_m']:.3g} mm at "
        f"{here['largest_amplitude_time_s']:.3g} s"
    )
    goes_on = growth > ENDED * depth
    if len(speeds) > 1:
        yield f"wear goes on at {np.count_nonzero(goes_on)} of {len(speeds)} speeds"
    else:
        word = "wear goes on" if goes_on[0] else "wear has ended"
        yield f"{word}: {1e3 * growth[0]:.3g} mm deeper in the last ten revolutions"


def _lines_of_disks(file: ResultFile) -> Iterator[str]:
    """Worn depths of the runs of the tuned disk and of every level, and who cuts through."""
    config, tuned = file.config, finite(file.read("tuned/run_deepest_m"))
    levels = zip(file.read("half_range"), of_levels(file, DEEPEST.name), strict=True)
    is_random = config.pattern_deviation is None
    who = "±{:.3g} %: {} disks" if is_random else "the disk of the pattern"
    groups = [(who.format(100 * half_range, len(depth)), depth) for half_range, depth in levels]
    for words, depth in [(f"{counted(len(tuned), 'run')} of the tuned disk", tuned), *groups]:
        if not len(depth):
            continue
        through = int(np.count_nonzero(depth >= REACHED * depth_of_all(config)))
        share = ""
        if is_random and depth is not tuned:
            low, high = map(percent, probability_interval(through, len(depth), Z_95))
            share = f", a share of {low} to {high} % (95 % interval)"
        yield (
            f"{words}: cut {1e3 * np.median(depth):.3g} mm deep at the median, "
            f"{1e3 * depth.max():.3g} mm at most; {through} of {len(depth)} cut through the "
            f"coating{share}"
        )


def depth_of_all(config: Config) -> float:
    """Depth at which a coating is worn through [m]."""
    c = config.contact.coating
    return Coating(c.thickness, c.young, c.yield_stress, c.hardening, area=0.0).worn_through
