"""Datasets and report lines that several studies share: coatings, casings that vibrate, air."""

from collections.abc import Iterator, Mapping

from hpcrub.results.layout import Dataset


def in_group(
    group: str, dimensions: tuple[str, ...], numbers: Mapping[str, tuple[str, ...]]
) -> Iterator[Dataset]:
    """Datasets of a group; numbers: {name: (units, description)}, with the type if it is not f8."""
    return (Dataset(f"{group}/{name}", dimensions, *of) for name, of in numbers.items())
