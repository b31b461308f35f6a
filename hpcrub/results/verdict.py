"""Verdict on a result: its severity, the reasons, and what to do."""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

# severities: of a finding, and of a verdict, which has that of its weightiest findings
REMARK, SINGLE, USELESS = range(3)
SEVERITIES = "0 usable, 1 single values are not usable, 2 not usable, percentiles neither"
MOST_ADVICE = 5  # most lines of advice below a verdict
FAR_OFF = 0.2  # change of a peak or an amplification above which no percentile is worth much
MOST_LOST = 0.05  # share of points or peaks, or change of a peak, above which a result is useless


class Finding(NamedTuple):
    """A fact that a user of a result must know."""

    severity: int  # REMARK; SINGLE: single values are unusable; USELESS: percentiles are, too
    why: str  # reason of the verdict, in a few words
    advice: str  # observation and remedy, in one sentence


class Verdict(NamedTuple):
    """Whether a result is usable, why not, and what to do."""

    severity: int  # of the weightiest finding
    words: str  # whether it is usable, and the reasons
    advice: tuple[Finding, ...] = ()  # the weightiest findings first

    @classmethod
    def of(cls, findings: Iterable[Finding], of_many: bool = False) -> "Verdict":
        """Verdict by findings; of_many: whether the result has percentiles of many disks."""
        found = sorted(findings, key=lambda finding: -finding.severity)
        worst = max((finding.severity for finding in found), default=REMARK)
        reasons = ", ".join(dict.fromkeys(f.why for f in found if f.severity == worst))
        single = "percentiles usable, single values not" if of_many else "usable with care"
        words = {
            REMARK: "usable",
            SINGLE: f"{single}: {reasons}",
            USELESS: f"not usable: {reasons}",
        }
        return cls(worst, words[worst], tuple(found[:MOST_ADVICE]))

    @property
    def usable(self) -> bool:
        """Whether the result is usable, at least for percentiles."""
        return self.severity < USELESS

    @property
    def lines(self) -> list[str]:
        """The verdict and its advice, a line each."""
        return [self.words, *(finding.advice for finding in self.advice)]

    def printed(self) -> Iterator[str]:
        """Lines of the verdict as a study prints them."""
        yield f"Verdict: {self.words}."
        yield from (f"- {finding.advice}" for finding in self.advice)
