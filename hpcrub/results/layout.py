"""Names, dimensions and units of everything in the result file of a contact study.

Dimensions: level V, sample n, speed S, blade N, mode, percentile P, and block K = n // step.

Every axis of every dataset has a dimension scale, so that xarray and netCDF know it by name: a
dataset with the values along it where there is one (`SCALES`), else numbers from 0 (`index_scale`).
"""

from typing import Any, NamedTuple

from hpcrub.contact import status

# Number of the layout, an attribute of every file. Whoever changes the name, the dimensions or the
# meaning of a dataset raises it. Layout 1, without the attribute, lacks the lines with since = 2.
NUMBER = 2
READABLE = (1, 2)

PENDING, DONE, FAILED = 0, 1, 2  # status of a sample
KINDS = ("contact", "linear")


class Dataset(NamedTuple):
    """One line of the file's layout."""

    name: str
    dimensions: tuple[str, ...]
    units: str
    description: str
    dtype: str = "f8"
    since: int = 1  # the first layout that has it


class Plan(NamedTuple):
    """All that is known of a result file before anything is computed."""

    config: Any  # Config
    lines: tuple[Dataset, ...]
    lengths: dict[str, int]  # of every dimension
    scales: dict[str, str]  # dimension: dataset with the values along it, {group} its own group
    values: dict[str, Any]  # datasets that are known now
    attributes: dict[str, str]  # of the root, beside those that every file has


PROGRAMS = Dataset(
    "programs",
    ("program",),
    "1",
    "programs that have computed this file: checksum of the text, version, revision",
    "S160",
    since=2,
)
MOST_PROGRAMS = 32  # in one file


def computed_by(name: str, dimensions: tuple[str, ...]) -> Dataset:
    """The line that says which of the `programs` has computed each sample or task."""
    return Dataset(name, dimensions, "1", "row of `programs` that computed this", "u1", since=2)


_INDEX = {
    "sample": "number of the sample in the whole study",
    "percentile": "percentile",
    "task": "number of the task",
}


def index_scale(dimension: str) -> Dataset:
    """The scale of a dimension that no dataset gives values."""
    words = _INDEX.get(dimension, f"number of the {dimension.replace('_', ' ')}, from 0")
    percentile = dimension == "percentile"
    units, dtype = ("percent", "f8") if percentile else ("1", "i8")
    return Dataset(dimension, (dimension,), units, words, dtype, since=2)


POINT_REASON = "; ".join(f"{code} {words}" for code, words in enumerate(status.WORDS))
_SWEEPS = "most sweeps of the contact force solver in one step; 0: no contact"
POINT_STATUS = (
    "0 none, 1 steady, 2 not steady within the time limit, 3 no result, as point_reason says: "
    "values are NaN"
)
_BY = ", by order statistics, level by convergence.z; NaN: too few samples"
_AMPLITUDE = "largest tangential displacement of any tip over the last revolutions"
_LOCALISATION = "localisation factor of the blade-tip amplitudes"
_RUNS = "peak amplitudes of the tuned disk and of its perturbed runs"
_REFERENCE = "median of run_peaks_m: amplifications are relative to it"
_LINEAR = "largest tangential displacement of any tip under engine-order excitation, linear"
_S, _V, _VN, _VNS = ("speed",), ("level",), ("level", "sample"), ("level", "sample", "speed")

# Data comes before what declares it whole: `linear_amplitude_m` ends `tuned`, `status` the samples.
LAYOUT = (
    Dataset("speeds_hz", _S, "Hz", "speeds of rotation"),
    Dataset("half_range", _V, "1", "mistuning levels: largest deviation of a blade's stiffness"),
    Dataset("sigma", _V, "1", "mistuning levels: standard deviation of a blade's stiffness"),
    Dataset("tuned/frequencies_hz", ("mode",), "Hz", "frequencies of the tuned reduced model"),
    Dataset("tuned/amplitude_m", _S, "m", _AMPLITUDE),
    Dataset("tuned/time_s", _S, "s", "simulated time until steady or given up"),
    Dataset("tuned/point_status", _S, "1", POINT_STATUS, "u1"),
    Dataset("tuned/point_reason", _S, "1", POINT_REASON, "u1"),
    Dataset("tuned/max_sweeps", _S, "1", _SWEEPS, "u1"),
    Dataset("tuned/localisation", _S, "1", _LOCALISATION),
    Dataset("tuned/peak_amplitude_m", (), "m", "largest amplitude over the speeds"),
    Dataset("tuned/run_peaks_m", ("run",), "m", _RUNS),
    Dataset("tuned/reference_amplitude_m", (), "m", _REFERENCE),
    Dataset("tuned/peak_speed_hz", (), "Hz", "speed of the largest amplitude"),
    computed_by("tuned/computed_by", ()),
    Dataset("tuned/linear_amplitude_m", (), "m", _LINEAR),
    Dataset("samples/deviation", (*_VN, "blade"), "1", "relative stiffness deviation of a blade"),
    Dataset("samples/amplitude_m", _VNS, "m", _AMPLITUDE),
    Dataset("samples/time_s", _VNS, "s", "simulated time until steady or given up"),
    Dataset("samples/localisation", _VNS, "1", _LOCALISATION),
    Dataset("samples/point_status", _VNS, "1", POINT_STATUS, "u1"),
    Dataset("samples/point_reason", _VNS, "1", POINT_REASON, "u1"),
    Dataset("samples/max_sweeps", _VNS, "1", _SWEEPS, "u1"),
    Dataset("samples/peak_amplitude_m", _VN, "m", "largest amplitude over the speeds"),
    Dataset("samples/peak_speed_hz", _VN, "Hz", "speed of the largest amplitude"),
    Dataset("samples/amplification", _VN, "1", "peak amplitude over the tuned disk's reference"),
    Dataset("samples/linear_amplitude_m", _VN, "m", _LINEAR),
    Dataset("samples/linear_amplification", _VN, "1", "linear amplitude over the tuned disk's"),
    computed_by("samples/computed_by", _VN),
    Dataset("samples/status", _VN, "1", "0 pending, 1 done, 2 failed", "u1"),
    *(
        line
        for kind in KINDS
        for line in (
            Dataset(f"statistics/{kind}/samples_seen", ("block",), "1", "samples seen", "i8"),
            *(
                Dataset(f"statistics/{kind}/{name}", ("level", "percentile", "block"), "1", text)
                for name, text in (
                    ("percentile", f"percentiles of the {kind} amplifications seen"),
                    ("percentile_low", f"lower end of the percentiles' confidence intervals{_BY}"),
                    ("percentile_high", f"upper end of the percentiles' confidence intervals{_BY}"),
                    ("mean_of_percentile", "mean of the percentile values so far"),
                    ("convergence_error", "convergence error, Z sqrt(V/k) of k percentile values"),
                )
            ),
        )
    ),
)
SCALES = {"speed": "speeds_hz", "level": "half_range", "block": "{group}/samples_seen"}
_NAMES = [line.name.partition("/")[::2] for line in LAYOUT]
TUNED, SAMPLE = ([n for group, n in _NAMES if group == g] for g in ("tuned", "samples"))
