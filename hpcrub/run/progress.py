"""Numbers → a bar on a terminal, plain lines in a log, tables at the end."""

import contextlib
import os
import sys
import time
from math import nan

import numpy as np
from rich import box
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn
from rich.progress import Progress as Bar
from rich.table import Table

from hpcrub.contact import status
from hpcrub.contact.status import DIVERGED, NOT_STEADY
from hpcrub.results.layout import DONE, FAILED, PENDING
from hpcrub.statistics.percentiles import Z_95, confidence, percentile_interval

LOG_INTERVAL, LOG_SHARE = 5.0, 0.05  # seconds between plain lines, or this share of the time so far
REFRESH = 0.5  # [s] between two updates of the percentiles
TEXT_SHARE = 0.01  # of the time, at most, is spent on these
ROWS = 1000  # samples read at once
WIDTH = 106  # of the tables in a log
BAR = 12  # width of the bar

# Joachim, Nyssen, Batailly (2020): table 2 [GPa], section 5 and figure 9
TABLE_2 = (207.01, 206.27, 206.95, 216.83, 208.09, 214.21)
TABLE_2 += (211.64, 201.66, 212.56, 203.28, 203.91, 211.93)
PAPER = {
    "tuned, largest amplitude": ("", "34.45", ""),
    "pattern, largest amplitude": ("58.1", "34.78", "49.0"),
    "pattern, largest localisation": ("38.9", "33.66", "67.9"),
}


def console():
    """Where everything meant for people goes."""
    watched = on_terminal()
    plain = {"highlight": False, "markup": False, "emoji": False}
    out = Console(file=_Output(sys.stdout), force_terminal=watched, **plain)
    if not watched:
        out.width = max(out.width, WIDTH)
    return out


def print_line(out, text):
    """Print a line: whole into a log, wrapped at words on a terminal."""
    out.print(text, soft_wrap=not out.is_terminal)


class _Output:
    """Standard output. A full disk or a closed pipe behind it does not end a study."""

    def __init__(self, stream):
        self._stream = stream

    def __getattr__(self, name):
        return getattr(self._stream, name)

    def write(self, text):
        """Write if possible."""
        self._try(self._stream.write, text)

    def flush(self):
        """Flush if possible."""
        self._try(self._stream.flush)

    def _try(self, function, *arguments):
        try:
            function(*arguments)
        except OSError as error:
            if not isinstance(error, BrokenPipeError):  # a reader such as `head` has had enough
                text = f"hpcrub: the output cannot be written ({error.strerror}); on without it"
                with contextlib.suppress(OSError):
                    print(text, file=sys.stderr)
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._stream.fileno())
            os.close(nowhere)


def on_terminal():
    """Whether a person watches. mpirun gives every rank a terminal of its own, so ask mpirun's."""
    if not sys.stdout.isatty():
        return False
    if "OMPI_COMM_WORLD_SIZE" not in os.environ:
        return True
    try:
        return os.readlink(f"/proc/{os.getppid()}/fd/1").startswith(("/dev/pts/", "/dev/tty"))
    except OSError:
        return False


class Progress:
    """Progress of a study, on rank 0."""

    def __init__(self, config):
        self.config = config
        self.console = console()
        self.bar = self.task = None
        if on_terminal():
            columns = TextColumn("{task.description}"), BarColumn(BAR), MofNCompleteColumn()
            self.bar = Bar(*columns, TextColumn("{task.fields[text]}"), console=self.console)
            self.bar.start()
        self.began = self.shown = time.monotonic()
        self.already = self.done = 0
        self.total = 0
        self.took = 0.0  # [s] by the last text with percentiles

    def say(self, text):
        """Print a line."""
        print_line(self.console, text)

    def tuned(self, n_done, n_total):
        """n_done of n_total speeds of the tuned disk are done."""
        self._show("tuned disk", n_done, n_total, "angular speeds", final=n_done == n_total)

    def tasks(self, n_done, n_total):
        """n_done of n_total tasks of a study without samples are done."""
        final = n_done == n_total
        if final or time.monotonic() - self.shown > self._interval():
            self._show("tasks", n_done, n_total, "", final)

    def start(self, status):
        """The samples begin; status (V, n) of those in the file."""
        self.task = None
        self.began = self.shown = time.monotonic()
        self.already = self.done = int(np.count_nonzero(status != PENDING))
        self.total = status.size
        if self.already:
            self.say(f"{self.already} of {self.total} samples are already there")

    def sample(self, level, sample, outcome, amplification):
        """One sample is finished; amplification (V, n) with NaN for the others."""
        self.done += 1
        if outcome.status == FAILED:
            where = f"level {self.config.levels[level]}, sample {self.config.samples[sample]}"
            self.say(f"{where} failed: {outcome.message}")
        final = self.done == self.total
        if final or time.monotonic() - self.shown > self._interval():
            self._show("samples", self.done, self.total, self._text(amplification), final)

    def stop(self):
        """Leave the terminal as it was."""
        if self.bar:
            self.bar.stop()

    def _interval(self):
        elapsed = time.monotonic() - self.began
        shortest = REFRESH if self.bar else max(LOG_INTERVAL, LOG_SHARE * elapsed)
        return max(shortest, self.took / TEXT_SHARE)

    def _text(self, amplification):
        """Rate, time left, and the percentiles of the widest level, as far as the line has room."""
        start = time.monotonic()
        rate = (self.done - self.already) / max(time.monotonic() - self.began, 1e-9)
        left = duration((self.total - self.done) / rate)
        values = amplification[-1][np.isfinite(amplification[-1])]
        texts = [f"{left} left", f"({rate:.3g}/s, {left} left)"]
        if len(values):
            percentiles = self.config.convergence.percentiles
            shown = [f"{p:.2f}" for p in np.percentile(values, percentiles)]
            names = "/".join(f"{p:g}" for p in percentiles)
            half_range = 100 * self.config.mistuning.half_range[self.config.levels[-1]]
            texts.append(f"{texts[-1]} A at ±{half_range:.3g} %: {'/'.join(shown)}")
            texts.append(
                f"{texts[1]} A at ±{half_range:.3g} %: {' / '.join(shown)} (percentiles {names})"
            )
        self.took = time.monotonic() - start
        return self._longest(texts)

    def _longest(self, texts):
        """The last of the texts for which the line has room."""
        if not self.bar:
            return texts[-1]
        taken = len(f"samples  {self.total}/{self.total}  ") + BAR
        room = self.console.width - taken
        return next((text for text in reversed(texts) if len(text) <= room), "")

    def _show(self, what, n_done, n_total, text, final):
        self.shown = time.monotonic()
        if not self.bar:
            if final or what != "tuned disk":
                self.say(f"{what}: {n_done} of {n_total} {text}".rstrip())
            return
        if self.task is None:
            self.task = self.bar.add_task(what, total=n_total, text=text)
        self.bar.update(self.task, completed=n_done, text=text)


def duration(seconds):
    """12 s, 3.4 min, 5.6 h, 7.8 days."""
    for unit, length, most in (("s", 1, 100), ("min", 60, 6000), ("h", 3600, 172800)):
        if seconds < most:
            return f"{seconds / length:.3g} {unit}"
    return f"{seconds / 86400:,.4g} days"


def summary(file, study, seconds):
    """Print what a finished or interrupted study has found.

    file: ResultFile; study: Study, rank 0's; seconds: wall time of this run.
    """
    out = console()
    if file.config.pattern_deviation is not None:
        out.print(pattern_table(file))
    table = level_table(file)
    fits = out.measure(table, options=out.options.update(width=WIDTH)).maximum <= out.width
    out.print(table if fits else level_table(file, narrow=True))
    if len(file.config.samples) > 1:
        out.print(interval_table(file))
    print_line(out, tuned_line(file))
    for line in point_lines(file):
        print_line(out, line)
    text = f"wall time {duration(seconds)} on {study.team.size} rank{'s'[: study.team.size > 1]}"
    if study.work.seconds > 0.0:
        rate = study.work.n_steps / study.work.seconds
        text += f", {rate / 1e6:.3g} million steps per second and core"
    out.print(text)


def tuned_line(file):
    """Peak of the tuned disk, to which all amplifications are relative, and how sure it is."""
    peak, runs = file.read("tuned/peak_amplitude_m"), np.sort(file.read("tuned/run_peaks_m"))
    text = f"tuned disk: {peak * 1e3:.2f} mm at {file.read('tuned/peak_speed_hz'):.2f} Hz"
    if not np.isfinite(runs).all() or runs[-1] / runs[0] - 1.0 < 1e-3:
        return text
    reference = file.read("tuned/reference_amplitude_m")
    text += (
        f"; median {reference * 1e3:.2f} mm of {len(runs)} hardly different disks "
        f"({runs[0] * 1e3:.2f} to {runs[-1] * 1e3:.2f} mm)"
    )
    low, high = np.ravel(percentile_interval(runs, [50.0], Z_95))
    if not np.isfinite([low, high]).all():
        return text
    return text + (
        f": all amplifications share an uncertainty of {100 * (reference / high - 1.0):+.1f} to "
        f"{100 * (reference / low - 1.0):+.1f} % (mistuning.tuned_runs)"
    )


def level_table(file, narrow=False):
    """One row per mistuning level; narrow: without sigma, and with fewer digits."""
    percentiles = file.config.convergence.percentiles
    names = "/".join(f"{p:g}" for p in percentiles)
    table = Table(
        box=box.SIMPLE_HEAD,
        title=f"Amplifications, percentiles {names}, convergence error",
        padding=(0, 0) if narrow else (0, 1),
    )
    headings = ["level", "sigma", "samples", "A_nl", "A_lin", "error", "not\nsteady", "diverged"]
    for heading in headings:
        if not (narrow and heading == "sigma"):
            table.add_column(heading, justify="right", no_wrap=True)
    digits = 2 if narrow else 3
    status = file.status()
    half_range, sigma = file.read("half_range"), file.read("sigma")
    for level in range(len(half_range)):
        done = status[level] == DONE
        n_failed = np.count_nonzero(status[level] == FAILED)
        not_steady, diverged = point_shares(file, level)
        contact, linear = (
            _percentile_text(file.read(f"samples/{name}", level)[done], percentiles, digits)
            for name in ("amplification", "linear_amplification")
        )
        table.add_row(
            f"±{100 * half_range[level]:.3g} %",
            *(() if narrow else (f"{100 * sigma[level]:.2f} %",)),
            f"{np.count_nonzero(done)}" + (f" (+{n_failed} failed)" if n_failed else ""),
            contact,
            linear,
            _last_error(file.read("statistics/contact/convergence_error", level)),
            f"{100 * not_steady:.2f} %",
            f"{100 * diverged:.2f} %",
        )
    return table


def interval_table(file):
    """One row per level and percentile: amplifications with their confidence intervals."""
    c = file.config.convergence
    table = Table(
        box=box.SIMPLE_HEAD,
        title=f"Percentiles and their confidence intervals ({100 * confidence(c.z):.4g} %)",
    )
    for heading in ("level", "percentile", "A_nl", "interval", "A_lin", "interval"):
        table.add_column(heading, justify="right", no_wrap=True)
    status = file.status()
    names = "samples/amplification", "samples/linear_amplification"
    for level, half_range in enumerate(file.read("half_range")):
        done = status[level] == DONE
        columns = []
        for name in names:
            values = file.read(name, level)[done]
            low, high = percentile_interval(values, c.percentiles, c.z)
            middle = np.percentile(values, c.percentiles) if len(values) else np.full_like(low, nan)
            columns += [[_number(x) for x in middle], list(map(_interval, low, high))]
        for percentile, *cells in zip(c.percentiles, *columns, strict=True):
            table.add_row(f"±{100 * half_range:.3g} %", f"{percentile:g}", *cells)
    return table


def _number(x):
    return f"{x:.3f}" if np.isfinite(x) else "-"


def _interval(low, high):
    """An end is open when there are too few samples for it."""
    return f"{_number(low)} to {_number(high)}"


def point_lines(file):
    """What went wrong in single points, in words with counts, and the work of the force solver."""
    counts = status.count(file.read("tuned/point_reason"))
    most = int(file.read("tuned/max_sweeps").max())
    n_points = np.count_nonzero(file.read("tuned/point_status"))
    for level, first in np.ndindex(
        len(file.read("half_range")), -(-len(file.config.samples) // ROWS)
    ):
        where = level, slice(first * ROWS, (first + 1) * ROWS)
        counts = counts + status.count(file.read("samples/point_reason", where))
        most = max(most, int(file.read("samples/max_sweeps", where).max(initial=0)))
        n_points += np.count_nonzero(file.read("samples/point_status", where))
    yield from status.lines(counts, n_points)
    yield f"contact forces: at most {most} sweeps of the solver in a step"


def point_shares(file, level):
    """Shares of the computed points of a level that were not steady, and that diverged."""
    counts = np.zeros(4, dtype=np.int64)
    for first in range(0, len(file.config.samples), ROWS):
        part = file.read("samples/point_status", (level, slice(first, first + ROWS)))
        counts += np.bincount(part.ravel(), minlength=4)[:4]
    n_points = max(counts[1:].sum(), 1)
    return counts[NOT_STEADY] / n_points, counts[DIVERGED] / n_points


def _percentile_text(values, percentiles, digits):
    if len(values) < 2:
        return f"{values[0]:.{digits}f}" if len(values) else "-"
    return "/".join(f"{p:.{digits}f}" for p in np.percentile(values, percentiles))


def _last_error(error):
    """Largest of the latest convergence errors (P, K) over the percentiles."""
    known = np.flatnonzero(np.isfinite(error).all(axis=0))
    return f"{100 * error[:, known[-1]].max():.2f} %" if len(known) else "-"


def pattern_table(file):
    """Peaks of the tuned disk and of an explicit pattern, beside the paper's for its own."""
    moduli = file.config.mistuning.pattern_gpa
    is_paper = file.config.casing.n_bumps == 4 and moduli in (TABLE_2, TABLE_2[::-1])
    table = Table(box=box.SIMPLE_HEAD, title="Amplitude, speed, localisation factor")
    units = ["[mm]", "[Hz]", "LF [%]"]
    for heading in ["", *units, *(f"paper\n{unit}" for unit in units if is_paper)]:
        table.add_column(heading, justify="right" if heading else "left", no_wrap=True)
    for name, values in pattern_rows(file).items():
        row = [f"{values[0] * 1e3:.1f}", f"{values[1]:.2f}", f"{values[2] * 100:.1f}"]
        table.add_row(name, *row, *(PAPER[name] if is_paper else ()))
    return table


def pattern_rows(file):
    """Amplitude [m], speed [Hz] and localisation of the points that the paper names."""
    speeds = file.read("speeds_hz")
    rows = {}
    for name, group, where, by in (
        ("tuned, largest amplitude", "tuned", (), "amplitude_m"),
        ("pattern, largest amplitude", "samples", (0, 0), "amplitude_m"),
        ("pattern, largest localisation", "samples", (0, 0), "localisation"),
    ):
        values = {
            key: file.read(f"{group}/{key}", where) for key in ("amplitude_m", "localisation")
        }
        if np.isfinite(values[by]).any():
            best = np.nanargmax(values[by])
            rows[name] = values["amplitude_m"][best], speeds[best], values["localisation"][best]
    return rows
