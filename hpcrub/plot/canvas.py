"""Frame of every figure: it opens result files, and makes axes or takes the user's own."""

import contextlib
import functools
import inspect
import os
import textwrap
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import product
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
from hpcrub.studies import open_result

Where = Axes | Sequence[Axes] | FigureBase | None

LETTERS = 12  # letters per inch of a line below a figure
# height of a legend in the user's axes with its distance from the data; most of it, in theirs
ROOM, MOST_ROOM = 1.15, 0.5
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

    def __call__(self, file: Any, ax: Where = None, **options: Any) -> Any:
        """Draw it."""


class Canvas:
    """Panels of one drawing, with its title, legends and notes."""

    def __init__(self, where: Where) -> None:
        self.axes: list[Axes] = []  # axes that are drawn into
        # whether the figure holds this drawing alone, so that legends can stand outside the axes
        self.own = where is None or isinstance(where, FigureBase)
        self._where = where
        self._notes: list[str] = []

    @property
    def figure(self) -> Any:
        """Figure or SubFigure of the axes."""
        return self.axes[0].figure

    def panels(
        self, rows: int, columns: int, size: tuple[float, float], **how: Any
    ) -> np.ndarray[Any, np.dtype[Any]]:
        """Return axes (rows, columns), made by `Figure.subplots`; size of a new figure [inch]."""
        given = pyplot.figure() if self._where is None else self._where
        if isinstance(given, Figure) and not given.axes:
            given.set_size_inches(size)
        if isinstance(given, FigureBase):
            made = given.subplots(rows, columns, squeeze=False, **how)
            self.axes = list(made.flat)
            return made
        self.axes = [given] if isinstance(given, Axes) else list(np.ravel(np.asarray(given)))
        if len(self.axes) > rows * columns:
            raise InputError(f"{len(self.axes)} axes given, {rows * columns} can be drawn into")
        # panels beyond the given axes are drawn into a figure that nobody sees
        rest = Figure().subplots(1, rows * columns, squeeze=False)[0, len(self.axes) :]
        return np.array([*self.axes, *rest]).reshape(rows, columns)

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
            if panel in self.axes:
                self.axes.remove(panel)
        for panel in panels[:n:columns]:
            panel.set_ylabel(ylabel)
        return panels[:n]

    def colorbar(self, image: Any, panels: Iterable[Axes], **how: Any) -> Any:
        """Draw the scale of the colours beside panels; returns None where these are not drawn."""
        shown = [panel for panel in panels if panel in self.axes]
        return self.figure.colorbar(image, ax=shown, **how) if shown else None

    def title(self, text: str) -> None:
        """Write a title above all panels, unless they are the user's axes."""
        if self.own:
            self.figure.suptitle(text)

    def note(self, *texts: str) -> None:
        """Keep notes, each once, to be written below the figure."""
        self._notes += [text for text in texts if text not in self._notes]

    def finish(self, files: list[ResultFile]) -> None:
        """Write the legends, the notes, and the warnings of the files below the panels."""
        for file in files:
            for warning in file.warnings:
                self.note(warning if len(files) == 1 else f"{file.path.stem}: {warning}")
        if not self.axes:
            return
        room = self.figure if self.own else self.axes[0]
        width = int(LETTERS * room.bbox.width / self.figure.dpi)
        text = "\n".join(line for note in self._notes for line in textwrap.wrap(note, width))
        if not self.own:
            self._note_and_legends(text)
            return
        legend = self._legend()
        if text:
            # the layout makes room for a text that is the title of the legend
            legend = legend or self.figure.legend([], [], loc="outside lower left")
            legend.set_title(text, prop=FontProperties(size="small"))
            legend.set_alignment("left")

    def _note_and_legends(self, text: str) -> None:
        """Write a text below the first of the user's axes, and a legend into each of them."""
        if text:
            self.axes[0].annotate(
                text, (0, 0), (0, -40), "axes fraction", "offset points", va="top",
                fontsize="x-small", color="0.3", annotation_clip=False,
            )  # fmt: skip
        self.figure.canvas.figure.draw_without_rendering()  # the layout may make axes smaller
        for panel in self.axes:
            named = _labelled(panel)
            if named and not panel.get_legend():
                _legend_above_data(panel, named)

    def _legend(self) -> Legend | None:
        """Draw one legend of all labels below all panels, intervals last; None without labels."""
        of_all: dict[str, Artist] = {}
        for panel in self.axes:
            if not panel.get_legend():
                of_all |= {k: v for k, v in _labelled(panel).items() if k not in of_all}
        if not of_all:
            return None
        labels = sorted(of_all, key=WORDS.__contains__)
        lengths = sorted(map(len, labels), reverse=True)  # the longest in different columns
        width = self.figure.bbox.width / self.figure.dpi
        fits = [n for n in range(1, 5) if sum(lengths[:n]) / ENTRY + n * HANDLE < width]
        handles, how = [of_all[label] for label in labels], {"loc": "outside lower center"}
        return self.figure.legend(handles, labels, ncols=max(fits, default=1), **how)


def _labelled(axes: Axes) -> dict[str, Artist]:
    """What has a label in axes, by its label; the last of those with one label."""
    return dict(zip(*axes.get_legend_handles_labels()[::-1], strict=True))


def _legend_above_data(axes: Axes, named: dict[str, Artist]) -> None:
    """Draw a legend in the user's axes, and make room for it above what is drawn there.

    The largest letters are taken with which it fits; axes that are too small get no legend.
    """
    for size, columns in product(("small", "x-small", "xx-small"), (1, 2, 3)):
        how: dict[str, Any] = {"fontsize": size, "ncols": columns, "loc": "upper left"}
        legend = axes.legend(named.values(), named.keys(), **how)
        box = legend.get_window_extent()
        share = ROOM * box.height / axes.bbox.height
        if share < MOST_ROOM and ROOM * box.width < axes.bbox.width:
            break
    else:
        legend.remove()
        return
    scale = axes.yaxis.get_transform()
    low, high = scale.transform(axes.get_ylim())
    low, high = scale.inverted().transform([low, low + (high - low) / (1.0 - share)])
    axes.set_ylim(low, high)


def figure(*studies: str, **how: Any) -> Callable[[Callable[..., Any]], Drawing]:
    """Return a decorator that turns a function of a `Canvas` and a file into a `Drawing`.

    A function that compares several files gets a list of these, sorted by `families.ordered`.
    how: as in `About`.
    """
    about = About(studies, **how)

    def decorate(draw: Callable[..., Any]) -> Any:
        def drawn(file: Any, ax: Where = None, mode: int | None = None) -> Any:
            if mode is not None and not about.mode:
                raise InputError(f"--mode {mode}: figure {draw.__name__} does not show a mode")
            canvas, options = Canvas(ax), {} if mode is None else {"mode": mode}
            if ax is None:  # the settings of the backend must outlive `rc_context`
                pyplot.draw_if_interactive()
            with _opened(file) as files, rc_context(STYLE if canvas.own else {}):
                _check(draw.__name__, about, files)
                shown = ordered(files)
                if about.needs == "random":
                    canvas.note(*lost_disks(shown))
                draw(canvas, shown if about.several else shown[0], **options)
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
