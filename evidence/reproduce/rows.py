"""Result files of a reproduction, and the rows of its report."""

from functools import cache
from typing import NamedTuple

import numpy as np

from hpcrub.results.layout import DONE
from hpcrub.statistics.percentiles import Z_95, percentile_interval, probability_interval
from hpcrub.studies import open_result

RUNS_BETWEEN = 2.5, 97.5  # percentiles


class Row(NamedTuple):
    """One line of the report."""

    number: str
    quantity: str
    paper: str
    ours: str
    interval: str
    agrees: str
    fitted: bool = False
    remark: str = ""


class Results:
    """The result files of a reproduction, opened when they are needed."""

    def __init__(self, folder):
        self.folder = folder

    @cache  # noqa: B019, lives as long as the report
    def files(self, pattern):
        """All ResultFiles whose names match."""
        return [open_result(path) for path in sorted(self.folder.glob(pattern))]

    def file(self, name):
        """The ResultFile of a name."""
        return self.files(name)[0]

    def contact(self, n_d):
        """The contact study with n_d bumps."""
        return self.file(f"contact/n_bumps={n_d}.h5")


def value_row(number, quantity, paper, ours, low=None, high=None, digits=2, **more):
    """Row of one value; without low and high the paper's rounding and 1 % decide."""
    paper_text, ours_text = f"{paper:.{digits}f}", f"{ours:.{digits + 1}f}"
    slack = 0.5 * 10.0**-digits
    agrees = verdict(paper, ours, slack, low, high, is_speed=quantity.endswith("[Hz]"))
    interval = "" if low is None else bracket((low, high), digits + 1)
    return Row(number, quantity, paper_text, ours_text, interval, agrees, **more)


def run_row(number, quantity, paper, values, digits=2, **more):
    """Row of what every run of a chaotic motion gives: the median, and the range of 95 % of them.

    The paper has one run, which may be any of them.
    """
    middle, *ends = np.percentile(values, [50, *RUNS_BETWEEN])
    return value_row(number, quantity, paper, middle, *ends, digits, **more)


def verdict(paper, ours, slack, low=None, high=None, is_speed=False):
    """Agreement in one word; slack: of the paper's rounding; low, high: ours, NaN if unknown."""
    yes, near = (0.1, 0.01 * paper) if is_speed else (0.01 * abs(paper), 0.05 * abs(paper))
    if low is None:
        agrees = "yes" if abs(ours - paper) <= max(slack, yes) else ""
    else:
        outside = paper < low - slack or paper > high + slack  # an unknown end is never passed
        bounded = np.isfinite(low if paper < ours else high)
        agrees = "" if outside else ("yes" if bounded else "open")
    return agrees or ("near" if abs(ours - paper) <= near else "no")


def worst(verdicts):
    """The least agreement of several."""
    return max(verdicts, key=("yes", "open", "near", "no").index)


def bracket(ends, digits):
    """Interval as text; an end that is not known is a dash."""
    return f"[{', '.join(f'{end:.{digits}f}' if np.isfinite(end) else '–' for end in ends)}]"


def claim_row(number, quantity, paper, ours, holds, **more):
    """Row of a statement."""
    return Row(number, quantity, paper, ours, "", "yes" if holds else "no", **more)


def order(smaller, larger):
    """Whether one percentile is below another; each (value, low, high)."""
    if smaller[0] < larger[0]:
        return "yes"
    return "no" if smaller[1] > larger[2] else "open"  # an unknown end is never passed


def order_row(number, quantity, paper, ours, smaller, larger, **more):
    """Row of what comes first: "open" where the ends of the two that vie overlap.

    smaller, larger: (value, low, high).
    """
    agrees = "no" if smaller[2] < larger[1] else "open"
    agrees = "yes" if paper == ours else agrees
    return Row(number, quantity, str(paper), str(ours), "", agrees, **more)


def done(file, name, level):
    """Values of the finished samples of a level."""
    return file.read(f"samples/{name}", level)[file.status[level] == DONE]


def bounded(values, at):
    """Percentile of values with its interval: value, low, high."""
    low, high = np.ravel(percentile_interval(values, [at], Z_95))
    return np.percentile(values, at), low, high


def percentile(file, level, at, name="amplification"):
    """`bounded` of the finished samples of a level."""
    return bounded(done(file, name, level), at)


def above_linear(file, level):
    """Share of the samples with A_nl > A_lin, and its interval: value, low, high [%]."""
    names = "amplification", "linear_amplification"
    contact, linear = (done(file, name, level) for name in names)
    above, n = np.count_nonzero(contact > linear), len(contact)
    return 100 * above / n, *(100 * end for end in probability_interval(above, n, Z_95))


def tuned_amplitudes(file):
    """Reference, smallest and largest peak of the tuned disk's runs [mm]."""
    reference, runs = file.read("tuned/reference_amplitude_m"), file.read("tuned/run_peaks_m")
    return 1e3 * float(reference), 1e3 * np.nanmin(runs), 1e3 * np.nanmax(runs)
