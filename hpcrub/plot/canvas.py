"""Frame of every figure: it opens result files, and makes panels in a new figure or a given one."""

import contextlib
import functools
import inspect
import os
import textwrap
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple, Protocol

import numpy as np
from matplotlib import pyplot, rc_context
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase
from matplotlib.font_manager import FontProperties
from matplotlib.legend import Legend

from hpcrub.config.schema import Config
from hpcrub.effects import EFFECTS
from hpcrub.errors import InputError
from hpcrub.plot.families import lost_disks, ordered
from hpcrub.plot.intervals import WORDS
from hpcrub.plot.style import STYLE
from hpcrub.results.layout import DONE
from hpcrub.results.storage import ResultFile
from hpcrub.results.verdict import REMARK
from hpcrub.studies import open_result, run_of

LETTERS = 12  # letters per inch of a line below a figure
ENTRY, HANDLE = 11, 0.8  # letters of a legend per inch; width of a symbol with its space [inch]

NEEDS: dict[str, tuple[str, Callable[[Config], bool]]] = {
    "": ("", lambda config: True),
    **{effect.name: (effect.needed, effect.exists) for effect in EFFECTS},
    "random": (
        "random samples, and this is one explicit pattern (mistuning.pattern)",
        lambda c: c.pattern_deviation is None,
    ),
}


class About(NamedTuple):
    """Description of a figure: its studies, what it shows and what it needs."""

    studies: tuple[str, ...]  # studies whose results it shows
    what: str  # what it shows, in a few words
    paper: str = ""  # number of the figure in the paper
    alone: bool = True  # whether it is drawn when a study ends
    several: bool = False  # whether it compares several files; it also takes one
    mode: bool = False  # whether it can show one chosen mode
    main: bool = False  # whether its picture has the name of the result file alone
    needs: str = ""  # what a study must have besides results, a key of NEEDS
    computed: bool = True  # whether it shows results; False: the input alone

    def lacking(self, config: Config) -> str:
        """Return in words what the figure needs and a study lacks; empty when it lacks nothing."""
        words, has_it = NEEDS[self.needs]
        if config.study not in self.studies:
            return f"the study {' or '.join(self.studies)}"
        return "" if has_it(config) else words


class Drawing(Protocol):
    """A figure: a function of a result file, with `about` for the lists of figures."""

    about: About
    __name__: str

    def __call__(self, file: Any, figure: FigureBase | None = None, **options: Any) -> Any:
        """Draw it."""


class Canvas:
    """Panels of one drawing, with its title, legends and notes."""

    def __init__(self, figure: FigureBase | None) -> None:
        """figure: Figure or SubFigure to draw into; None: a new one of pyplot."""
        if figure is not None and not isinstance(figure, FigureBase):
            kind = type(figure).__name__
            raise InputError(f"figure: a Figure or SubFigure is drawn into, not {kind}")
        self.figure: Any = pyplot.figure() if figure is None else figure
        self.axes: list[Axes] = []  # axes that are drawn into
        self._notes: list[str] = []

    def panels(
        self, rows: int, columns: int, size: tuple[float, float], **how: Any
    ) -> np.ndarray[Any, np.dtype[Any]]:
        """Return axes (rows, columns), made by `Figure.subplots`; size of a new figure [inch]."""
        if isinstance(self.figure, Figure) and not self.figure.axes:
            self.figure.set_size_inches(size)
        made = self.figure.subplots(rows, columns, squeeze=False, **how)
        self.axes = list(made.flat)
        return np.asarray(made)

    def grid(
        self, n: int, most: int, size: tuple[float, float], ylabel: str = "", **how: Any
    ) -> np.ndarray[Any, np.dtype[Any]]:
        """Return n panels, row by row.

        most: columns, if there are so many panels; size: width and height of a panel [inch],
        without the room below all; ylabel: label of the panels on the left; how: options of
        `panels`.
        """
        columns = min(most, n)
        rows = -(-n // columns)
        whole = size[0] * columns, size[1] * rows + 0.6
        panels = self.panels(rows, columns, whole, **how).ravel()
        for panel in panels[n:]:
            panel.set_axis_off()
        self.axes = list(panels[:n])
        for panel in panels[:n:columns]:
            panel.set_ylabel(ylabel)
        return panels[:n]

    def note(self, *texts: str) -> None:
        """Keep notes, each once, to be written below the figure."""
        self._notes += [text for text in texts if text not in self._notes]

    def finish(self, files: list[ResultFile]) -> None:
        """Write the legends, the notes, and the warnings of the files below the panels."""
        for file in files:
            for warning in file.warnings:
                self.note(warning if len(files) == 1 else f"{file.path.stem}: {warning}")
        width = int(LETTERS * self.figure.bbox.width / self.figure.dpi)
        text = "\n".join(line for note in self._notes for line in textwrap.wrap(note, width))
        legend = self._legend()
        if text:
            # the layout makes room for a text that is the title of the legend
            legend = legend or self.figure.legend([], [], loc="outside lower left")
            legend.set_title(text, prop=FontProperties(size="small"))
            legend.set_alignment("left")

    def _legend(self) -> Legend | None:
        """Draw one legend of all labels below all panels, intervals last; None without labels."""
        of_all: dict[str, Artist] = {}
        for panel in self.axes:  # of one label the first panel's last artist
            handles, labels = panel.get_legend_handles_labels()
            of_all = of_all | dict(zip(labels, handles, strict=True)) | of_all
        if not of_all:
            return None
        labels = sorted(of_all, key=WORDS.__contains__)
        lengths = sorted(map(len, labels), reverse=True)  # the longest in different columns
        width = self.figure.bbox.width / self.figure.dpi
        fits = [n for n in range(1, 5) if sum(lengths[:n]) / ENTRY + n * HANDLE < width]
        handles, how = [of_all[label] for label in labels], {"loc": "outside lower center"}
        return self.figure.legend(handles, labels, ncols=max(fits, default=1), **how)


def figure(*studies: str, **how: Any) -> Callable[[Callable[..., Any]], Drawing]:
    """Return a decorator that turns a function of a `Canvas` and a file into a `Drawing`.

    A function that compares several files gets a list of these, sorted by `families.ordered`.
    how: as in `About`.
    """
    about = About(studies, **how)

    def decorate(draw: Callable[..., Any]) -> Any:
        def drawn(file: Any, figure: FigureBase | None = None, mode: int | None = None) -> Any:
            if mode is not None and not about.mode:
                raise InputError(f"--mode {mode}: figure {draw.__name__} does not show a mode")
            options = {} if mode is None else {"mode": mode}
            if figure is None:  # the settings of the backend must outlive `rc_context`
                pyplot.draw_if_interactive()
            with _opened(file) as files, rc_context(STYLE):
                _check(draw.__name__, about, files)
                canvas = Canvas(figure)
                shown = ordered(files)
                if about.needs == "random":
                    canvas.note(*lost_disks(shown))
                draw(canvas, shown if about.several else shown[0], **options)
                if about.main and len(shown) == 1:
                    canvas.note(*_doubts(shown[0]))
                canvas.finish(files)
            return canvas.axes[0] if len(canvas.axes) == 1 else np.array(canvas.axes)

        functools.update_wrapper(drawn, draw)
        del drawn.__wrapped__  # type: ignore[attr-defined]
        drawn.__doc__ = f"{inspect.cleandoc(draw.__doc__ or '')}\n\nStudy: {', '.join(studies)}."
        drawn.about = about  # type: ignore[attr-defined]
        return drawn

    return decorate


@contextlib.contextmanager
def _opened(file: Any) -> Iterator[list[ResultFile]]:
    """Open the files that the user gave (paths, open files, or a list); closes what it opened."""
    several = isinstance(file, Sequence) and not isinstance(file, str)
    with contextlib.ExitStack() as stack:
        files: list[Any] = []
        for one in file if several else [file]:
            if isinstance(one, Config):  # only for a figure of the input alone
                files.append(SimpleNamespace(config=one, path=Path(one.output), warnings=[]))
            elif isinstance(one, str | os.PathLike):
                files.append(stack.enter_context(open_result(one)))
            else:
                files.append(one)
        yield files


def _doubts(file: ResultFile) -> list[str]:
    """The verdict on a result that is not simply usable."""
    verdict = run_of(file.config).study.verdict(file)
    return [verdict.words] if verdict.severity > REMARK else []


def _check(name: str, about: About, files: list[ResultFile]) -> None:
    if not files or (len(files) > 1 and not about.several):
        raise InputError(f"figure {name} shows one result file, {len(files)} are given")
    for file in files:
        if words := about.lacking(file.config):
            raise InputError(f"{file.path}: figure {name} is for {words}")
        # a contact study, which has no dataset `status`, is drawn as far as it is
        if about.computed and "status" in file and not (file.status == DONE).any():
            raise InputError(f"{file.path}: figure {name} has nothing to show: nothing is computed")
    if about.needs == "random" and not any((f.read("samples/status") == DONE).any() for f in files):
        raise InputError(
            f"{files[0].path}: figure {name} has nothing to show: no mistuned disk has a result"
        )
