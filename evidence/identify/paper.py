"""The paper's numbers as data: what the search is to meet, how well each is known, and when.

A tolerance is the paper's own uncertainty (rounding, a number read off a figure) together with
ours: a peak of a motion that is not periodic scatters from run to run, a percentile of few samples
from draw to draw. A deviation of z tolerances costs about z², and far less than that when it is
large (`cost`), so that one statement that no disk meets does not outweigh all others.
"""

from typing import NamedTuple

import numpy as np

BEND = 4.0  # cost at which a deviation stops to count with its square
MISSING = 100.0  # tolerances that a number counts as off which could not be computed
# Table 2, E_1 to E_12 [1e11 Pa]
TABLE_2 = (
    2.0701, 2.0627, 2.0695, 2.1683, 2.0809, 2.1421,
    2.1164, 2.0166, 2.1256, 2.0328, 2.0391, 2.1193,
)  # fmt: skip
NOMINAL = 2.1  # [1e11 Pa], table 1
PATTERN = np.array(TABLE_2) / NOMINAL - 1  # deviations of the blades, in the printed order


class Statement(NamedTuple):
    """One number of the paper."""

    name: str  # of ours, in what a stage finds
    text: str
    low: float  # the paper's number, or the range that it must lie in
    high: float
    tolerance: float
    stage: str
    row: str  # number of the row in docs/reproduction.md
    fitted: bool = True

    @property
    def paper(self):
        """The paper's number or range as text."""
        if self.low == self.high:
            return f"{self.low:g}"
        if np.isinf(self.high):
            return f"at least {self.low:g}"
        return f"at most {self.high:g}" if np.isinf(self.low) else f"{self.low:g} to {self.high:g}"

    def cost(self, value):
        """What a value costs: z² for small deviations, logarithmic for large ones [-]."""
        return BEND * np.log1p(self.deviation(value) ** 2 / BEND)

    def deviation(self, value):
        """How many tolerances a value lies off."""
        outside = max(self.low - value, value - self.high, 0.0) / self.tolerance
        return outside if np.isfinite(outside) else MISSING

    def verdict(self, value):
        """Agreement in one word: within one tolerance, within two, or not."""
        deviation = self.deviation(value)
        return "yes" if deviation <= 1 else "near" if deviation <= 2 else "no"


def _at(name, text, value, tolerance, stage, row, **more):
    return Statement(name, text, value, value, tolerance, stage, row, **more)


def _unseen(name, text, value, tolerance, row):
    return _at(name, text, value, tolerance, "predictions", row, fitted=False)


STATEMENTS = (
    _at("lowest_hz", "lowest frequency of family 1B [Hz]", 90.1, 0.05, "geometry", "1"),
    _at("highest_hz", "highest frequency of family 1B [Hz]", 93.2, 0.05, "geometry", "1"),
    # central differences were run with h = 5e-5 s, which is stable below 1/(pi h); the tolerance is
    # what a second ring element in every sector, which the paper may have, takes off ours
    Statement("reduced_highest_hz", "highest frequency of the reduced model, η = 60 [Hz]",
              -np.inf, 6366.0, 2500.0, "geometry", "7"),
    _at("linear_99_4", "percentile 99 of A_lin, n_d = 4, σ = 2.3 %", 1.57, 0.04, "linear", "10"),
    Statement("linear_3_below", "largest percentile 99 of A_lin of n_d = 4, 5, 6, less that of "
              "n_d = 3", 0.0, np.inf, 0.05, "linear", "10"),
    Statement("linear_6_above", "percentile 99 of A_lin of n_d = 6, less the largest of "
              "n_d = 3, 4, 5", 0.0, np.inf, 0.05, "linear", "10"),
    _at("peak_3_hz", "tuned peak, n_d = 3, in the middle of its range [Hz]", 46.0, 0.75, "tuned",
        "3"),
    _at("peak_4_hz", "tuned peak, n_d = 4 [Hz]", 34.45, 0.3, "tuned", "2"),
    _at("peak_5_hz", "tuned peak, n_d = 5, in the middle of its range [Hz]", 27.45, 0.35, "tuned",
        "3"),
    _at("peak_6_hz", "tuned peak, n_d = 6, in the middle of its range [Hz]", 22.5, 0.25, "tuned",
        "3"),
    Statement("tuned_order", "smaller tuned amplitude of n_d = 3 and 6 over the larger of "
              "n_d = 4 and 5", 1.0, np.inf, 0.1, "tuned", "14"),
    _at("pattern_mm", "pattern of Table 2: largest amplitude [mm]", 58.1, 2.5, "pattern", "4"),
    _at("pattern_hz", "its speed [Hz]", 34.78, 0.2, "pattern", "4"),
    _at("pattern_local", "localisation there [%]", 49.0, 5.0, "pattern", "4"),
    _at("most_local", "largest localisation [%]", 67.9, 5.0, "pattern", "4"),
    _at("most_local_hz", "its speed [Hz]", 33.66, 0.3, "pattern", "4"),
    _at("most_local_mm", "amplitude there [mm]", 38.9, 6.0, "pattern", "4"),
    _at("least_local", "smallest localisation [%]", 17.0, 4.0, "pattern", "4"),
    Statement("pattern_steady", "its steady points [%]", 95.0, np.inf, 5.0, "pattern", "6"),
    _at("pattern_time", "its mean simulated time [s]", 0.96, 0.1, "pattern", "6"),
    _at("median_23", "percentile 50 of A_nl, n_d = 4, σ = 2.3 %, that of 99 of A_lin", 1.57, 0.06,
        "samples", "11"),
    _at("share_06", "samples with A_nl > A_lin, n_d = 4, σ = 0.6 % [%]", 82.0, 10.0, "samples",
        "12"),
    _at("share_23", "samples with A_nl > A_lin, n_d = 4, σ = 2.3 % [%]", 96.0, 6.0, "samples",
        "12"),
    Statement("samples_steady", "steady points of the samples, n_d = 4 [%]", 95.0, np.inf, 5.0,
              "samples", "6"),
    _at("samples_time", "their mean simulated time [s]", 0.96, 0.1, "samples", "6"),
    Statement("step_change", "mean change of the pattern's response from h = 1 to 20 µs, of its "
              "largest amplitude [%]", -np.inf, 1.0, 1.0, "smooth", "7"),
    Statement("modes_change", "the same from η = 60 to 48 [%]", -np.inf, 1.0, 1.0, "smooth", "8"),
    Statement("tuned_steady", "steady points of the tuned disk, n_d = 4 [%]", 95.0, np.inf, 5.0,
              "fine", "6"),
    Statement("peak_scatter", "range of its peak over perturbed runs [%]", -np.inf, 1.0, 2.0,
              "fine", "2"),
    _unseen("second_hz", "second tuned interaction, n_d = 4 [Hz]", 69.0, 0.7, "2"),
    *(_unseen(f"edge_{n}_23", f"samples whose peak is at an edge of table 3's range, n_d = {n}, "
              "σ = 2.3 % [%]", 0.0, 1.0, "3") for n in (3, 4, 6)),
    _unseen("time_s", "mean simulated time, n_d = 3, 4, 6 [s]", 0.96, 0.02, "6"),
    _unseen("a_nl_99_23", "percentile 99 of A_nl, n_d = 4, σ = 2.3 %", 1.75, 0.06, "9"),
    _unseen("a_nl_99_less_damping", "the same, ξ = 4·10⁻³", 1.84, 0.06, "9"),
    _unseen("a_nl_50_23", "percentile 50 of A_nl, n_d = 4, σ = 2.3 %", 1.57, 0.03, "11"),
    _unseen("a_nl_50_06", "percentile 50 of A_nl, n_d = 4, σ = 0.6 % (its figure 12d)", 1.3, 0.05,
            "11"),
    *(_unseen(f"mm_{n}_{level}", f"percentile 99 of the amplitude, n_d = {n}, σ = {sigma} % [mm]",
              65.0, 3.0, "14") for n in (3, 6) for level, sigma in (("06", 0.6), ("23", 2.3))),
)  # fmt: skip
STAGES = ("geometry", "linear", "pattern", "tuned", "samples", "smooth", "fine")  # cheap to dear


def loss(found, stages=STAGES):
    """Sum of the costs of the statements of some stages.

    Parameters
    ----------
    found : dict
        Our numbers by the names of the statements; one that is missing costs the most.
    stages : sequence of str

    Returns
    -------
    float [-]
    """
    return sum(s.cost(found.get(s.name, np.nan)) for s in STATEMENTS if s.stage in stages)
