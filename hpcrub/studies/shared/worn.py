"""Datasets and report lines of a coating, the same in all studies."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.response.wear import ENDED, Wear
from hpcrub.results.layout import Dataset
from hpcrub.results.storage import ResultFile
from hpcrub.runs.study import ANGLE, Values
from hpcrub.studies.shared import in_group

# numbers of every speed: {name: (units, description)}, in the order of `Wear`
NUMBERS = {
    "largest_amplitude_m": ("m", "largest tangential displacement of any tip at any time"),
    "largest_amplitude_time_s": ("s", "when it was that large, to a pitch of the casing"),
    "worn_depth_m": ("m", "largest worn depth of the coating in the end"),
    "worn_growth_m": ("m", "largest growth of a worn depth in the last ten revolutions or so"),
    "worn_volume_m3": ("m3", "volume of coating worn away: depth by arc by width of its strip"),
    "wear_energy_j": ("J", "energy that has gone into the wear of this volume"),
    "lobes": ("1", "lobes of the worn depth beyond what blades at rest cut; 0: none"),
}
NAMES = (*NUMBERS, "worn_m")
_AROUND = "largest worn depth within an angle of the casing, of each strip"


def around(group: str, dimensions: tuple[str, ...]) -> Dataset:
    """Dataset of the worn depths of every speed, over strip and angle."""
    return Dataset(f"{group}/worn_m", (*dimensions, "strip", "angle"), "m", _AROUND)


def layout(config: Config, dimensions: tuple[str, ...]) -> tuple[Dataset, ...]:
    """All datasets of the coating, in the group `wear`; none without a coating."""
    if not config.contact.wears:
        return ()
    return (*in_group("wear", dimensions, NUMBERS), around("wear", dimensions), ANGLE)


def values(wear: Wear) -> dict[str, np.ndarray]:
    """Wear at some speeds: {name of the dataset in its group: array}."""
    return dict(zip(NAMES, wear, strict=True))


def of_speed(wear: Wear, where: Any) -> Iterator[Values]:
    """Wear at one speed for the datasets of `layout`; where: place of the speed in them."""
    return ((f"wear/{name}", where, array[0]) for name, array in values(wear).items())


def report(file: ResultFile, disk: int) -> Iterator[str]:
    """Lines about the wear by a disk at the speed of its deepest cut; nothing without a coating.

    file: has the datasets of `layout`, with the disk as their first dimension.
    """
    if "wear/worn_depth_m" not in file:
        return
    numbers = {name: np.atleast_1d(file.read(f"wear/{name}", disk)) for name in NUMBERS}
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
