"""Tasks of a contact study, which are cut into parts if there are many ranks."""

import itertools
from collections.abc import Iterable
from typing import Any, NamedTuple

from hpcrub.ranks.schedule import Tasks

PART = 8  # speeds of a part: as many as the kernel integrates at once, at least
FULL = 8  # speeds of samples for each lane, with which few lanes idle at the end


class Part(NamedTuple):
    """Every n_parts-th speed of one disk, or all speeds of several disks together."""

    places: tuple[Any, ...]  # level and number of each sample; number of a disk before them
    part: int = 0
    n_parts: int = 1


def most_parts(n_speeds: int) -> int:
    """Largest number of parts into which a sweep of n_speeds is worth cutting."""
    return max(1, -(-n_speeds // PART))


def together(n_speeds: int, n_lanes: int) -> int:
    """Number of samples of n_speeds that are worth integrating together in n_lanes."""
    return max(1, FULL * n_lanes // n_speeds)


def n_parts(n_left: int, n_ranks: int, most: int) -> int:
    """Parts into which the next of n_left sweeps is cut: one until ranks outnumber the sweeps."""
    return min(most, max(1, n_ranks // n_left))


class ContactTasks(Tasks):
    """Samples of a contact study."""

    def __init__(
        self, samples: Iterable[tuple[int, int]], n_samples: int, most: int, together: int = 1
    ) -> None:
        """Take the samples of a study.

        samples: iterable of n_samples pairs (level, sample), drawn one at a time; most: largest
        number of parts of a sample; together: most samples that a rank integrates together.
        """
        super().__init__()
        self.samples, self.n_samples, self.most = iter(samples), n_samples, most
        self.together = together

    def __len__(self) -> int:
        return super().__len__() + self.n_samples

    def take(self, n_ranks: int) -> Any:
        """Return the next task; there must be one. The parts of a sample follow each other."""
        if self.urgent:
            return super().take(n_ranks)
        # parts cost more than a whole, and most ranks are busy at the end
        cut = n_parts(self.n_samples, n_ranks // 2, self.most)
        # the last samples go out by few, so that no rank waits long for another
        n = max(1, min(self.together, self.n_samples // (2 * n_ranks)))
        self.n_samples -= n
        places = tuple(itertools.islice(self.samples, n))
        first, *rest = (Part(places, part, cut) for part in range(cut))
        self.urgent.extend(rest)
        return first
