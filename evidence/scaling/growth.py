"""What grows with the number of samples: rank 0's memory, its statistics, the file."""

import tempfile
import time
import tracemalloc
from pathlib import Path

import numpy as np

from evidence.scaling import costs
from hpcrub.config.schema import Config
from hpcrub.ranks.parallel import Team
from hpcrub.results import storage
from hpcrub.results.layout import DONE
from hpcrub.statistics import percentiles as statistics
from hpcrub.studies import contact, files

MANY = 1_000_000  # samples per level
LOOKED = 100_000  # samples per level of a study that looks whether it has converged


class _EmptyFile:
    """Stands for a result file in which nothing is done yet."""

    def __init__(self, config):
        self.shape = len(config.mistuning.half_range), config.mistuning.samples

    def status(self):
        return np.zeros(self.shape, np.uint8)

    def read(self, name):
        return np.full(self.shape, np.nan)

    def tuned(self):
        return None


def memory(all_samples=(10_000, 100_000, 1_000_000)):
    """{samples per level: (bytes at most, bytes kept) on rank 0 for its book of a study}."""
    found = {}
    for n_samples in all_samples:
        config = costs.configuration(4, n_samples)
        tracemalloc.start()
        study = contact.MonteCarlo(contact.STUDY, Team(), config, None, _EmptyFile(config))
        study._take_stock()
        kept, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        found[n_samples] = most, kept
        del study
    return found


def statistics_alone(n_samples=MANY):
    """Seconds for the statistics of n_samples on four levels, of one kind and of both."""
    values = _amplifications((8, n_samples))
    statistics.running_statistics(values[0, :100], [1, 50, 99], 10, 2.81)
    ticks = [time.process_time()]
    for line in values:
        statistics.running_statistics(line, [1, 50, 99], 10, 2.81)
        ticks.append(time.process_time())
    return ticks[4] - ticks[0], ticks[8] - ticks[0]


def statistics_written(n_samples=MANY):
    """Seconds of processor time for what `hpcrub.merge` does after it has copied the samples: read
    the book of n_samples on four levels, compute their statistics, write them."""
    config = Config.model_validate(
        {
            "speeds": {"from_hz": 34.0, "to_hz": 34.0},  # the fewest: they are not read here
            "mistuning": {"half_range_percent": [1, 2, 3, 4], "samples": n_samples},
        }
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.h5"
        files.lay_out(path, config)
        file = storage.ResultFile(path, mode="r+")
        shape = file.status().shape
        file.write({"samples/status": np.full(shape, DONE)}, ())
        for name in ("samples/amplification", "samples/linear_amplification"):
            file.write({name: _amplifications(shape)}, ())
        study = contact.MonteCarlo(contact.STUDY, Team(), config, None, file)
        start = time.process_time()
        study.update_statistics()
        return time.process_time() - start


def laying_out(all_samples=(5_000, 50_000, 200_000)):
    """Rows (samples per level, bytes, seconds) of rank 0 laying out a file of four levels, best of
    three."""
    rows = []
    for n_samples in all_samples:
        config, seconds = costs.configuration(4, n_samples), []
        with tempfile.TemporaryDirectory() as folder:
            for number in range(3):
                start = time.perf_counter()
                files.lay_out(Path(folder) / f"{number}.h5", config)
                seconds.append(time.perf_counter() - start)
        rows.append((n_samples, files.file_size(config), min(seconds)))
    return rows


def looks(n_samples=LOOKED):
    """(number, seconds of processor time) of all looks of a study with stop_when_converged that
    never converges, on four levels; by both criteria {criterion: ...}."""
    found = {}
    for criterion in ("standard_error", "interval"):
        config = costs.configuration(4, n_samples)
        rule = {"stop_when_converged": True, "target_error": 1e-9, "criterion": criterion}
        rule = config.convergence.model_copy(update=rule)
        config = config.model_copy(update={"convergence": rule})
        study = contact.MonteCarlo(contact.STUDY, Team(), config, None, None)
        study.status = np.full(study.shape, DONE, np.uint8)
        study.amplification = _amplifications((2, *study.shape))
        study._converged_at()  # compiled
        found[criterion] = _all_looks(study)
    return found


def _all_looks(study):
    """Its looks as samples come in, from the first to the last."""
    done, values, n_looks, spent = study.status.copy(), study.amplification, 0, 0.0
    step = study.config.convergence.step
    while study.finished < study.shape[1]:
        n = int(max(study.looked_at + step, np.ceil(study.looked_at * contact.LOOK_AGAIN)))
        n = min(n, study.shape[1])
        study.status = np.where(np.arange(study.shape[1]) < n, done, 0).astype(np.uint8)
        study.amplification = np.where(study.status == DONE, values, np.nan)
        study.finished = n
        start = time.process_time()
        study._is_enough()
        spent += time.process_time() - start
        n_looks += study.looked_at == n
    return n_looks, spent


def _amplifications(shape):
    return np.random.default_rng(1).gamma(20.0, 0.1, shape)


def file_sizes():
    """Rows (name, samples in all, bytes, bytes per sample) for the paper's study and beyond."""
    rows = []
    for name, factor in (("paper", 1), ("10 times", 10), ("100 times", 100)):
        total = n_samples = 0
        for n_bumps in costs.CASES:
            config = costs.configuration(n_bumps, 5000 * factor)
            total += files.file_size(config)
            n_samples += 4 * config.mistuning.samples
        rows.append((name, n_samples, total, total / n_samples))
    return rows
