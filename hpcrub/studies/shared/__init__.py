"""What studies store and say beside their own results: of coatings, casings and air."""

from collections.abc import Iterator, Mapping

from hpcrub.results.layout import Dataset


def in_group(
    group: str, dimensions: tuple[str, ...], numbers: Mapping[str, tuple[str, ...]]
) -> Iterator[Dataset]:
    """Datasets of a group; numbers: {name: (units, description) and, if not f8, the type}."""
    return (Dataset(f"{group}/{name}", dimensions, *of) for name, of in numbers.items())
