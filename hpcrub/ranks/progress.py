"""Progress of a study, in lines that become rarer with time; the console that prints them."""

import io
import sys
import time
from collections.abc import Iterable
from typing import Any

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from hpcrub.config.schema import Config
from hpcrub.config.text import counted
from hpcrub.errors import print_no_more
from hpcrub.ranks.parallel import launched_size
from hpcrub.results.layout import FAILED, PENDING
from hpcrub.statistics.percentiles import finite

INTERVAL, SHARE = 5.0, 0.05  # seconds between two lines, or this share of the time so far
WIDTH = 106  # of the tables in a log
PLAIN: dict[str, Any] = {"highlight": False, "markup": False, "emoji": False}


class _Output(Console):
    """A console whose reader may leave, and whose disk may be full: the work goes on without it."""

    def print(self, *objects: Any, **how: Any) -> None:
        try:
            super().print(*objects, **how)
        except SystemExit:  # of rich, for a reader that has left; what follows is printed nowhere
            pass
        except OSError as error:
            print_no_more(error)


def console() -> Console:
    """Return the console that prints all text meant for people.

    Under mpirun it prints plain lines: mpirun gives every rank a terminal of its own, even when
    the output of mpirun goes into a file.
    """
    plain = dict(PLAIN)
    if launched_size():
        plain["force_terminal"] = False
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # the encoding may lack ± or σ
    out = _Output(**plain)
    if not out.is_terminal:
        out.width = max(out.width, WIDTH)
    return out


def table(title: str, headings: Iterable[str], **how: Any) -> Table:
    """Return a table without rows, with a column of numbers for each heading; how: of `Table`."""
    empty = Table(box=box.SIMPLE_HEAD, title=title, **how)
    for heading in headings:
        empty.add_column(heading, justify="right", no_wrap=True)
    return empty


def say(line: str) -> None:
    """Print a line without line breaks, so that names can be copied from a terminal."""
    console().print(line, soft_wrap=True)


def print_item(item: str | Table) -> None:
    """Print a table, or a line: unbroken into a log, wrapped at words on a terminal."""
    out = console()
    out.print(item, soft_wrap=isinstance(item, str) and not out.is_terminal)


class Progress:
    """Progress of a study, on rank 0."""

    def __init__(self, config: Config) -> None:
        self.config = config
        self.began = self.shown = time.monotonic()
        self.already = self.done = self.total = 0

    say = staticmethod(print_item)

    def part(
        self, what: str, n_done: int, n_total: int, left: float = 0.0, expected: int | None = None
    ) -> None:
        """Print that n_done of n_total parts are done; what: their name, such as tasks.

        - left: time that the others take [s]; not above 0: not known.
        - expected: about as many are needed, of n_total at most; 0: not known; None: all.
        """
        if not self._is_due(n_done == n_total):
            return
        about = "" if expected is None else "about "
        more = f", {about}{duration(left)} left" if left > 0.0 else ""
        self.say(f"{what}: {amount(n_done, n_total, expected)}{more}")

    def start(self, status: np.ndarray) -> None:
        """Begin the samples; status (V, n): that of each sample in the file."""
        self.began = self.shown = time.monotonic()
        self.already = self.done = int(np.count_nonzero(status != PENDING))
        self.total = status.size
        if self.already:
            self.say(f"{self.already} of {counted(self.total, 'sample')} are already there")

    def sample(self, level: int, sample: int, outcome: Any, amplification: np.ndarray) -> None:
        """Count one more finished sample; amplification (V, n), NaN for samples not finished."""
        self.done += 1
        if outcome.status == FAILED:
            where = f"level {self.config.levels[level]}, sample {self.config.samples[sample]}"
            self.say(f"{where} failed: {outcome.message}")
        if self._is_due(self.done == self.total):
            text = self._text(amplification)
            stops = self.config.convergence.stop_when_converged
            most, about = ("at most ", "at most about ") if stops else ("", "")
            self.say(f"samples: {self.done} of {most}{self.total}, {about}{text}")

    def _is_due(self, is_last: bool) -> bool:
        now = time.monotonic()
        if not is_last and now - self.shown <= max(INTERVAL, SHARE * (now - self.began)):
            return False
        self.shown = now
        return True

    def _text(self, amplification: Any) -> Any:
        """Time left, rate, and amplifications of the widest level, or of the pattern."""
        rate = (self.done - self.already) / max(time.monotonic() - self.began, 1e-9)
        left = duration((self.total - self.done) / rate)
        values, config = finite(amplification[-1]), self.config
        text = f"{left} left ({rate:.3g}/s)"
        if not len(values):
            return text
        at = config.convergence.percentiles
        of = f"at ±{100 * config.mistuning.half_range[config.levels[-1]]:.3g} %"
        what = f"percentiles {'/'.join(f'{p:g}' for p in at)}"
        if config.pattern_deviation is not None:  # samples are runs of one disk
            at, of = (0.0, 50.0, 100.0), "of the pattern"
            what = f"least, median and largest of {len(values)} runs"
        at, what = (at, f" ({what})") if len(values) > 1 else ((50.0,), "")
        text += f"; A {of}: {' / '.join(f'{p:.2f}' for p in np.percentile(values, at))}{what}"
        return text


def amount(n_done: int, n_total: int, expected: int | None = None, unit: str = "") -> str:
    """Return how many parts are done, in words; n_total, expected: see `Progress.part`."""
    unit = f" {unit}" if unit else ""
    if expected is None:
        return f"{n_done} of {n_total}{unit}"
    goal = min(expected, n_total)
    if goal and n_done <= goal:
        return f"{n_done} of about {goal}{unit} (at most {n_total})"
    more = f", more than the {goal} expected" if goal else ""
    return f"{n_done} of at most {n_total}{unit}{more}"


def duration(seconds: float) -> str:
    """Return a duration in words, such as 12 s, 3.4 min, 5.6 h or 7.8 days."""
    for unit, length, most in (("s", 1, 100), ("min", 60, 6000), ("h", 3600, 172800)):
        if seconds < most:
            return f"{seconds / length:.3g} {unit}"
    return f"{seconds / 86400:,.4g} days"
