"""Names, units and meaning of everything in the result file of a contact study.

Dimensions: level V, sample n, speed S, blade N, mode, percentile P, and block K = n // step.
"""

from typing import NamedTuple

from hpcrub.config.schema import Config
from hpcrub.response.casing_motion import CasingMotion
from hpcrub.response.quantities import Quantity
from hpcrub.response.sweep import SweepResult
from hpcrub.results.layout import ANGLE, SPEEDS, Dataset, datasets
from hpcrub.results.verdict import MOST_ADVICE, SEVERITIES
from hpcrub.studies.shared import casing_motion, worn


class Kind(NamedTuple):
    """A kind of numbers that a study has statistics of; each sample has one number."""

    name: str  # group of its statistics
    of: str  # dataset of the numbers in `samples`
    units: str
    words: str

    def dataset(self, statistic: str) -> str:
        """Name of the dataset of a statistic, which is a member of `RunningPercentiles`."""
        return f"statistics/{self.name}/{statistic.replace('percentile', self.of)}"


SAMPLES_SEEN = "statistics/samples_seen"  # shared by all kinds
KINDS = (
    Kind("contact", "amplification", "1", "contact amplifications"),
    Kind("linear", "linear_amplification", "1", "linear amplifications"),
    Kind("stress", "peak_stress_pa", "Pa", "largest stresses of any speed"),  # if observed
    Kind("amplitude", "peak_amplitude_m", "m", "largest amplitudes, of any time"),  # of a coating
    Kind("worn_depth", "deepest_m", "m", "largest worn depths of any speed"),  # of a coating
)
AMPLIFICATION = KINDS[0]
_S, _V, _VN, _VNS = ("speed",), ("level",), ("level", "sample"), ("level", "sample", "speed")
_BY = ", by order statistics, level by convergence.z; NaN: too few samples"
_RUNS = "amplitudes of the runs of the tuned disk (mistuning.reference)"
_EQUAL = "of a tuned disk of equal blades, whose motion may not stay"
_REFERENCE = "median of run_peaks_m: amplifications are relative to it"
_DEEPEST = "the runs of the tuned disk"
_LINEAR = "largest tangential displacement of any tip under engine-order excitation, linear"
# effect of half the time step on the disks that are checked
_HALF_STEP = (
    Quantity(
        "half_step_peak_m", "m",
        "largest amplitude over the speeds with half the time step; NaN: not checked"),
    Quantity(
        "half_step_differs", "1",
        "share of the speeds at which half the step changes the amplitude by over 10 %"),
)  # fmt: skip
_CASING = CasingMotion.declared().values()
# quantities of every point
_POINT = (*SweepResult.declared().values(), *_CASING, *worn.NUMBERS)
# The last dataset of a group marks it as complete: `linear_amplitude_m`, and `status` of samples.
LAYOUT = (
    SPEEDS,
    Dataset("half_range", _V, "1", "mistuning levels: largest deviation of a blade's stiffness"),
    Dataset("sigma", _V, "1", "mistuning levels: standard deviation of a blade's stiffness"),
    Dataset("tuned/frequencies_hz", ("mode",), "Hz", "frequencies of the tuned reduced model"),
    *datasets("tuned", _S, _POINT),
    casing_motion.PERMANENT,
    Dataset("tuned/run_amplitude_m", ("run", "speed"), "m", f"{_RUNS} at every speed"),
    Dataset("tuned/peak_amplitude_m", (), "m", "largest amplitude over the speeds"),
    Dataset("tuned/run_peaks_m", ("run",), "m", f"peak {_RUNS}"),
    Dataset("tuned/reference_amplitude_m", (), "m", _REFERENCE),
    Dataset("tuned/symmetric_amplitude_m", _S, "m", f"amplitude {_EQUAL}"),
    Dataset("tuned/symmetric_peak_m", (), "m", f"largest amplitude over the speeds {_EQUAL}"),
    *datasets("tuned", (), _HALF_STEP),
    Dataset("tuned/peak_stress_pa", (), "Pa", "largest stress over the speeds"),
    Dataset("tuned/peak_speed_hz", (), "Hz", "speed of the largest amplitude"),
    Dataset("tuned/run_deepest_m", ("run",), "m", f"largest worn depth of any speed: {_DEEPEST}"),
    *datasets("tuned", (*_S, "strip", "angle"), [worn.AROUND]),
    ANGLE,
    Dataset("tuned/linear_amplitude_m", (), "m", _LINEAR),
    Dataset("samples/deviation", (*_VN, "blade"), "1", "relative stiffness deviation of a blade"),
    *datasets("samples", _VNS, _POINT),
    Dataset("samples/peak_amplitude_m", _VN, "m", "largest amplitude over the speeds"),
    Dataset("samples/peak_stress_pa", _VN, "Pa", "largest stress over the speeds"),
    Dataset("samples/peak_speed_hz", _VN, "Hz", "speed of the largest amplitude"),
    *datasets("samples", _VN, _HALF_STEP),
    Dataset("samples/amplification", _VN, "1", "peak amplitude over the tuned disk's reference"),
    Dataset("samples/linear_amplitude_m", _VN, "m", _LINEAR),
    Dataset("samples/linear_amplification", _VN, "1", "linear amplitude over the tuned disk's"),
    Dataset("samples/deepest_m", _VN, "m", "largest worn depth of any speed"),
    Dataset("samples/deepest_speed_hz", _VN, "Hz", "speed of the largest worn depth"),
    Dataset("samples/status", _VN, "1", "0 pending, 1 done, 2 failed", "u1"),
    Dataset("trust", ("line",), "1", "the verdict, and what to do about it", "S400"),
    Dataset("trust_severity", ("line",), "1", f"severity of these lines: {SEVERITIES}", "u1"),
    Dataset(SAMPLES_SEEN, ("block",), "1", "samples seen", "i8"),
    *(
        Dataset(kind.dataset(name), ("level", "percentile", "block"), kind.units, text)
        for kind in KINDS
        for name, text in (
            ("percentile", f"percentiles of the {kind.words} seen"),
            ("percentile_low", f"lower end of the percentiles' confidence intervals{_BY}"),
            ("percentile_high", f"upper end of the percentiles' confidence intervals{_BY}"),
            ("mean_of_percentile", "mean of the percentile values so far"),
            ("convergence_error", "convergence error, Z sqrt(V/k) of k percentile values"),
        )
    ),
)
# both are max |u_t|, the largest tangential displacement of any tip with its offset
AMPLITUDES = {  # with their names in the glossary
    "amplitude_m": "steady amplitude",
    "largest_amplitude_m": "largest amplitude at any time",
}


def _names(quantities):
    return [of.name for of in quantities]


_SYMMETRIC = "symmetric_amplitude_m", "symmetric_peak_m"
MOST_LINES = 1 + MOST_ADVICE  # most lines of the verdict
_OF_COATING = {
    *_names(worn.QUANTITIES),
    ANGLE.name,
    "run_deepest_m",
    "deepest_m",
    "deepest_speed_hz",
}
_OF_COATING |= {kind.name for kind in KINDS[3:]}


def layout(config: Config) -> tuple[Dataset, ...]:
    """Datasets of a study: for coating, stress, checks and casing motion only if it has them."""
    left_out = set[str]().union(
        () if config.contact.wears else _OF_COATING,
        () if config.observes_stress else ("stress_pa", "peak_stress_pa", "stress"),
        () if config.mistuning.checked_samples else _names(_HALF_STEP),
        () if config.mistuning.reference == "staying" else _SYMMETRIC,
        () if config.casing.vibrates else (*_names(_CASING), "permanent_growth_per_s"),
    )
    return tuple(line for line in LAYOUT if left_out.isdisjoint(line.name.split("/")))


def amplitude(config: Config) -> str:
    """Dataset whose largest value is the peak of a disk; with a coating that of any time."""
    return "largest_amplitude_m" if config.contact.wears else "amplitude_m"


def kinds(config: Config) -> tuple[Kind, ...]:
    """Kinds of numbers of which the file of a study has statistics."""
    there = {line.name for line in layout(config)}
    return tuple(kind for kind in KINDS if kind.dataset("percentile") in there)
