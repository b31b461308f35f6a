"""Counts of the points and peaks of a contact study, over all samples that count."""

from typing import NamedTuple

import numpy as np

from hpcrub.contact import status
from hpcrub.contact.status import AVERAGED
from hpcrub.results.layout import DONE
from hpcrub.results.samples import n_counted
from hpcrub.results.storage import ResultFile
from hpcrub.statistics.percentiles import Z_95, finite, percentile_interval
from hpcrub.studies.contact import layout

NEAR = 0.03  # of the tuned peak: nearer peaks are those of one motion
ALONE = 0.9  # share of a peak: with both neighbours below, the speed step may miss a higher peak


class Survey(NamedTuple):
    """Counts of points and peaks, over the `n_counted` samples of every level."""

    points: np.ndarray  # number of points of every level with each status (V, 5)
    peaks: np.ndarray  # number of peaks with each status (5,)
    lowest: int  # peaks at the lowest speed
    highest: int  # peaks at the highest speed
    alone: int  # peaks whose neighbours are both below ALONE times the peak
    error: float  # median standard error of averaged peaks, over the peak [-]; NaN: none
    largest: float  # largest amplitude [m]
    n_points: int  # number of points, the tuned disk's included
    reasons: np.ndarray  # number of points with each reason
    growing: int  # peaks at which a wave still grows
    shows: float  # time at which all waves that still grow will have shown [s]; NaN: none grows
    sweeps: int  # most sweeps of the solver

    @property
    def n_peaks(self) -> int:
        """Number of peaks, at least 1."""
        return max(1, int(self.peaks.sum()))


def survey(file: ResultFile) -> Survey:
    """Count the points and peaks of a file."""
    last, size_of = file.config.speeds.n_values - 1, layout.amplitude(file.config)
    where = slice(None), slice(n_counted(file))
    names = "point_status", "point_reason", "growth_shows_s", "amplitude_error_m", size_of
    states, reasons, grows, errors, sizes = (file.read(f"samples/{n}", where) for n in names)
    points = np.array([np.bincount(of_level.ravel(), minlength=5)[:5] for of_level in states])
    most = file.read("tuned/max_sweeps"), file.read("samples/max_sweeps", where)
    done = file.read("samples/status", where) == DONE
    size = np.nan_to_num(sizes[done])
    best = size.argmax(axis=1)
    at = np.arange(len(size)), best
    beside = np.maximum(size[at[0], best - 1], size[at[0], np.minimum(best + 1, last)])
    peak, state, error = size[at], states[done][at], errors[done][at]
    ends = ((best == end) & (peak > 0.0) & (last > 0) for end in (0, last))
    lowest, highest = map(int, map(np.count_nonzero, ends))
    alone = int(np.count_nonzero((best > 0) & (best < last) & (beside < ALONE * peak)))
    peaks, largest = np.bincount(state, minlength=5)[:5], float(peak.max(initial=0.0))
    averaged = (state == AVERAGED) & (size_of == layout.STEADY)
    known = float(np.median(error[averaged] / peak[averaged])) if averaged.any() else np.nan
    n_points = int(points[:, 1:].sum() + np.count_nonzero(file.read("tuned/point_status")))
    shows = finite(np.append(file.read("tuned/growth_shows_s"), grows))
    return Survey(
        *(points, peaks, lowest, highest, alone, known, largest, n_points),
        reasons=status.count(file.read("tuned/point_reason")) + status.count(reasons),
        growing=int(np.isfinite(grows[done][at]).sum()),
        shows=float(shows.max()) if shows.size else np.nan,
        sweeps=int(max(sweeps.max(initial=0) for sweeps in most)),
    )


def shared_uncertainty(file: ResultFile, name: str = "amplification") -> np.ndarray:
    """Uncertainty that the values of a dataset of `samples` share, downwards and upwards (2,) [-].

    Amplifications have that of their reference, the 95 % interval of the median of the tuned runs:
    zero where the runs agree, NaN where there are too few of them. Other values share nothing.
    """
    runs = file.read("tuned/run_peaks_m")
    if name != "amplification" or len(runs) == 1 or np.ptp(runs) < 1e-3 * runs.min():
        return np.zeros(2)
    low, high = np.ravel(percentile_interval(runs, [50.0], Z_95))
    reference = file.read("tuned/reference_amplitude_m")
    return np.array([1.0 - reference / high, reference / low - 1.0])


def unstable_peak(file: ResultFile) -> float:
    """Peak of a tuned disk of equal blades whose motion does not stay [m]; NaN where it stays.

    It stays where the runs of the reference reach it, or are nearer than NEAR.
    """
    runs = finite(file.read("tuned/run_peaks_m"))
    if "tuned/symmetric_peak_m" not in file or not runs.size:
        return np.nan
    equal = float(file.read("tuned/symmetric_peak_m"))
    reference = float(file.read("tuned/reference_amplitude_m"))  # 0 where nothing touches
    off = abs(equal - reference)
    return equal if off > NEAR * reference and not runs.min() <= equal <= runs.max() else np.nan
