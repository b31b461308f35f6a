"""Finished samples in the file of a contact study, as far as they count."""

import numpy as np

from hpcrub.results.layout import DONE, FAILED
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import finite

SEEN = "statistics/samples_seen"  # of all running percentiles
PERCENTILES = "statistics/contact/amplification"


def n_counted(file: ResultFile) -> int:
    """Number of samples of each level that the tables count.

    A study that stops when it has converged counts its samples up to there only: how many more it
    has computed depends on the number of ranks.
    """
    n_all = len(file.config.samples)
    if not file.config.convergence.stop_when_converged:
        return n_all
    known = np.isfinite(file.read(PERCENTILES)).any(axis=1)  # (V, K)
    blocks = np.flatnonzero(known.all(axis=0))
    return int(file.read(SEEN, blocks[-1])) if len(blocks) else n_all


def n_failed(file: ResultFile, level: int) -> int:
    """Number of samples of a level without a result, among those that count."""
    status = file.read("samples/status", (level, slice(n_counted(file))))
    return int(np.count_nonzero(status == FAILED))


def rows(file: ResultFile, level: int, name: str) -> np.ndarray:
    """Values of a dataset for the finished samples of a level, among those that count."""
    where = level, slice(n_counted(file))
    done = file.read("samples/status", where) == DONE
    return np.asarray(file.read(f"samples/{name}", where)[done])


def finished(file: ResultFile, level: int, name: str) -> np.ndarray:
    """Those of the same values that are finite."""
    return finite(rows(file, level, name))


def of_levels(file: ResultFile, name: str) -> list[np.ndarray]:
    """The finite values of the finished samples of every level."""
    return [finished(file, level, name) for level in file.config.levels]
