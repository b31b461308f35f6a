"""Datasets and report lines of a coating, the same in all studies."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from hpcrub.config.schema import Config
from hpcrub.response.wear import ENDED, Wear
from hpcrub.results.layout import ANGLE, Dataset, datasets
from hpcrub.results.storage import ResultFile
from hpcrub.runs.study import Values

QUANTITIES = tuple(Wear.declared().values())
*NUMBERS, AROUND = QUANTITIES  # the last is over strip and angle, too


def datasets_of(group: str, dimensions: tuple[str, ...]) -> tuple[Dataset, ...]:
    """All datasets of the coating in a group."""
    around = datasets(group, (*dimensions, "strip", "angle"), [AROUND])
    return (*datasets(group, dimensions, NUMBERS), *around, ANGLE)


def layout(config: Config, dimensions: tuple[str, ...]) -> tuple[Dataset, ...]:
    """All datasets of the coating, in the group `wear`; none without a coating."""
    return datasets_of("wear", dimensions) if config.contact.wears else ()


def of_speed(wear: Wear, where: Any) -> Iterator[Values]:
    """Wear at one speed for the datasets of `layout`; where: place of the speed in them."""
    return ((f"wear/{name}", where, array[0]) for name, array in wear.by_name().items())


def report(file: ResultFile, disk: int) -> Iterator[str]:
    """Lines about the wear by a disk at the speed of its deepest cut; nothing without a coating.

    file: has the datasets of `layout`, with the disk as their first dimension.
    """
    if "wear/worn_depth_m" not in file:
        return
    numbers = {n.name: np.atleast_1d(file.read(f"wear/{n.name}", disk)) for n in NUMBERS}
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
