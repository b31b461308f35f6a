"""What a physical effect adds to the studies: one class, of which every part has a default.

An effect is a module of this room, or any file that is imported before a study begins, with a
subclass of `Effect`. Result files, summaries, verdicts, checklists, reports and figures loop over
the effects that an input has; they name none.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any, ClassVar, NamedTuple

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.model.reduction import Modes
from hpcrub.response.band import Observers
from hpcrub.response.quantities import Quantity
from hpcrub.response.revolution import Grid
from hpcrub.response.scene import Scene
from hpcrub.response.sweep import SweepResult
from hpcrub.response.wear import Wear
from hpcrub.results.layout import Dataset, Values
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import Finding
from hpcrub.setup.problem import Model, Problem
from hpcrub.statistics.percentiles import finite


class Kind(NamedTuple):
    """A kind of numbers that a contact study has percentiles of; each sample has one number."""

    name: str  # group of its statistics
    of: str  # dataset of the numbers in `samples`
    units: str
    words: str
    symbol: str = ""  # heading of its percentiles in the summary; "": its name

    def dataset(self, statistic: str) -> str:
        """Name of the dataset of a statistic, which is a member of `RunningPercentiles`."""
        return f"statistics/{self.name}/{statistic.replace('percentile', self.of)}"


class Change(NamedTuple):
    """One change of an input, for the checklist."""

    what: str
    key: str  # key to look at where the change moves the answer
    values: Callable[[Config], dict[str, Any]]  # {key: value}; empty: does not apply
    is_error: bool = False  # shows an error of the computation; False: an input that is uncertain
    run: int = 0  # run of the disk, see `setup.disks.run_deviation`


class History(NamedTuple):
    """The whole motion of one disk at one speed, as an effect reads it."""

    modes: Modes
    scene: Scene
    speed_hz: float
    wear: Callable[[], Wear]  # state of the coating at the end
    # of a time_response only
    time: np.ndarray = np.zeros(0)  # (T,) [s]
    position: np.ndarray = np.zeros((0, 0))  # modal coordinates (T, K) [m·√kg]
    casing: np.ndarray = np.zeros((0, 0))  # turned coordinates of its pairs (T, 2J) [m·√kg]
    worn_depth: np.ndarray = np.zeros(0)  # largest worn depth after every block [m]


class Load(NamedTuple):
    """A load of the linear response, and the tuned disk at the speed where they resonate."""

    model: Model
    speed: float | None = None  # [rad/s]; None: they never do, or the stiffness is of one speed
    n_diameters: int = 0


class Effect:
    """A physical effect; study: the name of a study."""

    name = ""  # as figures ask for it
    needed = ""  # what a figure of it needs, in words
    omitted = ""  # sentence of a report on what the model leaves out without the effect
    unsettled = ""  # what a motion that has not settled may still do, in words
    amplitude = ""  # dataset whose largest value is the peak of a disk, if not `amplitude_m`
    points: tuple[Quantity, ...] = ()  # quantities of every speed
    peaks: tuple[Quantity, ...] = ()  # numbers of every disk of a contact study
    kinds: tuple[Kind, ...] = ()  # of these, those with percentiles
    changes: tuple[Change, ...] = ()  # what is uncertain
    # datasets of a study, by its name; in contact besides `points` and `peaks`
    datasets: ClassVar[Mapping[str, tuple[Dataset, ...]]] = {}

    def __init_subclass__(cls) -> None:
        """Add an effect to those that the studies know."""
        EFFECTS.append(cls())

    def exists(self, config: Config) -> bool:
        """Whether an input has the effect."""
        raise NotImplementedError

    def observers(self, config: Config) -> Observers:
        """Return {name of one of `points`: function of the end of a speed}; see `run_sweep`."""
        return {}

    def sizes(self, config: Config) -> dict[str, int]:
        """Lengths of dimensions of its datasets that no study has."""
        return {}

    def warnings(self, config: Config, problem: Problem) -> Iterator[str]:
        """Warnings about what a study that integrates does not resolve, before it begins."""
        return iter(())

    def n_numbers(self, config: Config, grid: Grid) -> int:
        """Numbers that the effect keeps in memory while a disk is integrated."""
        return 0

    def of_disk(self, result: SweepResult, speeds_hz: np.ndarray) -> dict[str, float]:
        """Return {name: value} of `peaks` for one disk of a contact study."""
        return {}

    def of_tuned(
        self, config: Config, modes: Modes, runs: list[dict[str, Any]]
    ) -> dict[str, np.ndarray]:
        """Return {name: values} for the tuned disk of a contact study, beside those of any disk.

        runs: results by name of each run of the reference.
        """
        return {}

    def of_history(self, study: str, history: History) -> Iterator[tuple[str, Any]]:
        """Yield (name, value) of a whole motion, for the studies of histories."""
        return iter(())

    def of_model(self, study: str, config: Config, loads: list[Load]) -> Iterator[tuple[str, Any]]:
        """Yield (name, value) of the tuned disk, for the modal and linear studies."""
        return iter(())

    def of_samples(self, level: int, first: int, modes: list[Modes]) -> Iterator[Values]:
        """Values of consecutive samples for the linear study; first: number of the first one."""
        return iter(())

    def lines(self, file: ResultFile, disk: int) -> Iterator[str]:
        """Lines of the summary; of a study of whole motions facts about one disk."""
        return iter(())

    def findings(self, file: ResultFile) -> Iterator[Finding]:
        """Findings for the verdict."""
        return iter(())


EFFECTS: list[Effect] = []


def times(
    factors: Mapping[str, float], where: Callable[[Config], bool] = lambda config: True
) -> Callable[[Config], dict[str, Any]]:
    """Return a function of a Config that multiplies keys, for a `Change`.

    factors: {key: factor}; keys that are null do not count; where: whether the change applies.
    """

    def values(config: Config) -> dict[Any, Any]:
        before = config.by_path() if where(config) else {}
        known = {key: before[key] for key in factors if before.get(key) is not None}
        return {key: (factors[key] * np.array(value)).tolist() for key, value in known.items()}

    return values


def peaks_of_disks(file: ResultFile, name: str) -> tuple[np.ndarray, float]:
    """Largest value of a dataset of an energy study for every sample (n,) and the tuned disk.

    NaN where no value is known.
    """
    disks = file.read(f"tuned/{name}"), *file.read(name)
    tuned, *peaks = (known.max() if known.size else np.nan for known in map(finite, disks))
    return np.array(peaks), float(tuned)


def range_of_disks(file: ResultFile, name: str) -> tuple[float, float, float]:
    """Least and largest of the same peaks of samples, and that of the tuned disk."""
    peaks, tuned = peaks_of_disks(file, name)
    return float(np.nanmin(peaks)), float(np.nanmax(peaks)), tuned


def largest(values: np.ndarray, speeds_hz: np.ndarray) -> tuple[float, float]:
    """Largest of some values (S,), and its speed [Hz]; NaN where no value is known."""
    if not np.isfinite(values).any():
        return np.nan, np.nan
    best = np.nanargmax(values)
    return float(values[best]), float(speeds_hz[best])
