"""Distinct motions at each speed, and their branches over the speeds.

At every speed, the motions from several initial states are split into groups (`split`). Then each
group continues the nearest branch of the speeds before, or begins a new branch (`label`). Two
groups of one speed always belong to different branches, however close they come at another speed.

Amplitude and localisation of many successive windows describe a motion. Two motions differ when
the mean of either quantity differs by more than chance and by more than what matters. Windows
resemble their neighbours. So the error of a mean is computed from the means of batches of windows
and has a Student distribution (Welch). The level of the test is divided by the number of
comparisons (Bonferroni). A motion that jumps between two others within its windows has a large
error, and differs from neither of them.

Batch means: Law, Simulation Modeling and Analysis (2015), section 9.5.3.
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.special import stdtrit

from hpcrub.contact.status import AVERAGED, STEADY

N_BATCHES = 12
FALSE_SPLITS = 0.01  # expected number of pairs in a whole study that chance alone separates
ALIKE_AMPLITUDE, ALIKE_LOCALISATION = 0.03, 0.02  # differences that do not matter
TINY = 1e-300
LINK = 3.0  # largest change of a branch from speed to speed, in standard deviations of windows
REACH = 10  # most speeds at which a branch may be missing; the more, the nearer it must continue


class Group(NamedTuple):
    """Motions at one speed that differ only by chance; [0] amplitude [m], [1] localisation."""

    mean: np.ndarray  # (2,)
    scatter: np.ndarray  # standard deviation of the windows (2,)
    speed: int  # index


def label(amplitude: np.ndarray, localisation: np.ndarray, point_status: np.ndarray) -> np.ndarray:
    """Branch of every steady point (starts, speeds) int; branch 0 has the most points.

    It is -1 where the motion is not steady. amplitude [m], localisation [-]: of the windows
    (starts, speeds, windows); point_status: as `layout.POINT_STATUS` (starts, speeds).
    """
    windows = np.stack([amplitude, localisation])
    known = np.isin(point_status, (STEADY, AVERAGED)) & np.isfinite(windows).all(axis=(0, 3))
    n_points = known.sum(axis=0)
    level = FALSE_SPLITS / max(1, (n_points * (n_points - 1)).sum())  # each pair has two quantities
    branch_of = np.full(point_status.shape, -1)
    branches: list[Group] = []  # the last Group of each
    for speed in np.flatnonzero(n_points):
        motions = windows[:, known[:, speed], speed]
        part = split(motions, level)
        alike = [motions[:, part == p] for p in range(part.max() + 1)]
        groups = [Group(m.mean(axis=(1, 2)), m.std(axis=(1, 2)), int(speed)) for m in alike]
        branch_of[known[:, speed], speed] = _link(branches, groups)[part]
    there = branch_of >= 0
    sizes = np.bincount(branch_of[there])
    branch_of[there] = np.argsort(np.argsort(-sizes, kind="stable"))[branch_of[there]]
    return branch_of


def split(motions: np.ndarray, level: float) -> np.ndarray:
    """Group of every motion at one speed (P,) int, counted from 0.

    All pairs within a group are alike (complete linkage), so that clearly different motions are
    never together. Motions that differ by chance are apart only where another motion, which
    differs from one of them, belongs to the group of the other.

    motions: amplitude and localisation of P motions in W windows (2, P, W); level: probability with
    which chance separates two motions in one of the quantities.
    """
    first, second = np.triu_indices(motions.shape[1], 1)
    if not len(first):
        return np.zeros(motions.shape[1], dtype=int)
    mean, error, degrees = _means(motions)
    largest = np.maximum(mean[0, first], mean[0, second])
    matters = np.stack([ALIKE_AMPLITUDE * largest, np.full(len(first), ALIKE_LOCALISATION)])
    matters = np.maximum(matters, TINY)  # two motions at rest are alike
    chance = _chance(error[:, first], error[:, second], degrees, level)
    apart = np.abs(mean[:, first] - mean[:, second]) / np.maximum(chance, matters)
    from scipy.cluster.hierarchy import fcluster, linkage  # half a second that no other study needs

    return fcluster(linkage(apart.max(axis=0), "complete"), 1.0, "distance") - 1


def _means(motions: Any) -> tuple[Any, Any, Any]:
    """Means (2, P), their standard errors (2, P), and the degrees of freedom of the errors."""
    n_batches = min(N_BATCHES, motions.shape[-1])
    length = motions.shape[-1] // n_batches
    batches = motions[..., -n_batches * length :].reshape(*motions.shape[:-1], n_batches, length)
    means = batches.mean(axis=-1)
    return means.mean(axis=-1), means.std(axis=-1, ddof=1) / np.sqrt(n_batches), n_batches - 1


def _chance(a: Any, b: Any, degrees: Any, level: float) -> Any:
    """Difference of means with errors a and b that chance exceeds with probability `level`."""
    both = np.hypot(a, b)
    ratio = np.where(both > 0, (a**4 + b**4) / np.where(both > 0, both, 1.0) ** 4, 1.0)
    return -both * stdtrit(degrees / ratio, level / 2)


def _link(branches: Any, groups: Any) -> Any:
    """Branch of each group (G,) int; `branches`, the last group of each branch, is modified."""
    from scipy.optimize import linear_sum_assignment  # as in `split`

    cost = np.full((len(branches), len(groups)), LINK)
    for i, old in enumerate(branches):
        for j, new in enumerate(groups):
            least = max(TINY, ALIKE_AMPLITUDE * max(old.mean[0], new.mean[0])), ALIKE_LOCALISATION
            unit = np.maximum(np.hypot(old.scatter, new.scatter), least)
            missed = new.speed - old.speed - 1
            distance = np.linalg.norm((old.mean - new.mean) / unit) + LINK * missed / (REACH + 1)
            cost[i, j] = min(LINK, distance)
    numbers = np.full(len(groups), -1)
    for i, j in zip(*linear_sum_assignment(cost), strict=True):
        if cost[i, j] < LINK:
            numbers[j] = i
            branches[i] = groups[j]
    for new in np.flatnonzero(numbers < 0):
        numbers[new] = len(branches)
        branches.append(groups[new])
    return numbers


def stretches(several: np.ndarray) -> np.ndarray:
    """Uninterrupted stretches of true values (S,): first index and index after the last, (n, 2)."""
    return np.flatnonzero(np.diff(np.concatenate([[0], several, [0]]))).reshape(-1, 2)


def coexisting(branch_of: np.ndarray) -> np.ndarray:
    """Number of different branches at every speed (S,); branch_of: result of `label`."""
    return np.array([len(set(column[column >= 0])) for column in branch_of.T])
