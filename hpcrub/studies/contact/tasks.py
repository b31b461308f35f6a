"""Tasks of a contact study: tuned disk and samples, cut into parts if there are many ranks."""

from collections.abc import Iterable
from typing import Any, NamedTuple

from hpcrub.ranks.schedule import Tasks

PART = 8  # speeds of a part: as many as the kernel integrates at once, at least


class TunedPart(NamedTuple):
    """Every n_parts-th speed of one run of the tuned disk."""

    run: int = 0
    part: int = 0
    n_parts: int = 1


class SamplePart(NamedTuple):
    """Every n_parts-th speed of one sample.

    When all parts are computed, one rank gets the whole `response` and writes it.
    """

    level: int
    sample: int
    part: int = 0
    n_parts: int = 1
    response: tuple | None = None


def most_parts(n_speeds: int) -> int:
    """Largest number of parts into which a sweep of n_speeds is worth cutting."""
    return max(1, -(-n_speeds // PART))


def n_parts(n_left: int, n_ranks: int, most: int) -> int:
    """Parts into which the next of n_left sweeps is cut: one until ranks outnumber the sweeps.

    Only half the ranks count: parts cost more than a whole, and most ranks are busy at the end.
    """
    return min(most, max(1, n_ranks // (2 * max(n_left, 1))))


class ContactTasks(Tasks):
    """Tasks of a contact study: the tuned disk and the samples."""

    def __init__(
        self, tuned: list[TunedPart], samples: Iterable[tuple[int, int]], n_samples: int, most: int
    ) -> None:
        """Take the tasks of a study.

        samples: iterable of n_samples pairs (level, sample), drawn one at a time; most: largest
        number of parts of a sample.
        """
        super().__init__()
        self.urgent.extend(tuned)
        self.samples, self.n_samples, self.most = iter(samples), n_samples, most

    def __len__(self) -> int:
        return super().__len__() + self.n_samples

    def take(self, n_ranks: int) -> Any:
        """Return the next task; there must be one. The parts of a sample follow each other."""
        if self.urgent:
            return super().take(n_ranks)
        cut = n_parts(self.n_samples, n_ranks, self.most)
        self.n_samples -= 1
        first, *rest = (SamplePart(*task, part, cut) for task in [next(self.samples)]
                        for part in range(cut))  # fmt: skip
        self.urgent.extend(rest)
        return first
