"""Result files → figures, for paper and talk. `FIGURES` lists them all.

A figure is a function of a list of open `ResultFile`s that returns a matplotlib Figure (or a list
of pictures for an animation); the files alone are enough to draw it.
"""

import contextlib
import os
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

from hpcrub.config.types import without_suffix
from hpcrub.errors import HpcrubError, InputError
from hpcrub.plot.style import STYLE
from hpcrub.results.storage import ResultFile

# What numbers that no study computes make of a drawing: nothing guards the data of a file, among
# them numbers of nodes. All else is a fault of the program, and is to be seen as one.
ODD_NUMBERS = ArithmeticError, IndexError, MemoryError, ValueError


class Entry(NamedTuple):
    """One figure: "module.function" that draws it, and for whom it is."""

    function: str
    studies: tuple
    paper: str  # figure of the paper
    what: str
    automatic: bool = True  # drawn when the study ends
    several: bool = False  # compares several files; one will do
    random: bool = False  # of random samples, not of one explicit pattern
    mode: bool = False  # can show one chosen mode


FIGURES = {
    "summary": Entry("contact.summary", ("contact",), "7", "responses, amplifications"),
    "family": Entry("families.responses", ("contact",), "8, 9", "responses", several=True),
    "percentiles": Entry(
        "families.percentiles",
        ("contact",),
        "12",
        "both amplifications over σ",
        several=True,
        random=True,
    ),
    "amplitudes": Entry(
        "families.amplitudes",
        ("contact",),
        "13",
        "largest amplitudes over n_d",
        several=True,
        random=True,
    ),
    "running": Entry(
        "families.running",
        ("contact",),
        "10",
        "running means of the percentiles",
        several=True,
        random=True,
    ),
    "errors": Entry(
        "families.errors", ("contact",), "11", "convergence errors", several=True, random=True
    ),
    "disk": Entry("modal.disk", ("modal",), "1", "the disk and its beams"),
    "safe": Entry("modal.safe", ("modal",), "2", "SAFE diagram, full and reduced model"),
    "shapes": Entry(
        "modal.shapes", ("modal",), "", "deformed shapes of the first family", mode=True
    ),
    "animation": Entry(
        "modal.animation", ("modal",), "", "one mode as a GIF (--mode)", False, mode=True
    ),
    "casing": Entry("casing.casing", ("casing",), "1b, 3", "casing, clearance and bumps"),
    "linear": Entry("linear.percentiles", ("linear",), "4", "linear amplification over σ and n_d"),
    "time": Entry("histories.time", ("time_response",), "5", "displacements, gaps, forces"),
    "map": Entry("histories.interaction", ("interaction_map",), "6", "spectra over the speeds"),
    "energy": Entry("energy.energy", ("energy",), "14", "A_nl by displacement and by energy"),
    "energies": Entry(
        "energy.energy", ("energy",), "14", "the same for several n_d together", several=True
    ),
    "cross": Entry("cross.cross", ("cross",), "15", "densities of (A_lin, A_nl)"),
    "damping": Entry("damping.damping", ("damping",), "16", "percentiles at two dampings"),
    "branches": Entry("branches.branches", ("branches",), "17", "stable motions, localisation"),
}


def draw_study(paths, folder=None, kind="png", mode=None):
    """Draw the figures that belong to one finished study, or to several together.

    Args:
        paths, folder, kind: as for `draw`.
        mode: shown by those figures that can show one mode.

    Returns:
        list of the files written.

    Raises:
        InputError: a mode is given and none of the figures shows one.
    """
    file = ResultFile.open(paths[0])
    study, pattern = file.config.study, file.config.pattern_deviation
    file.close()
    names = [
        name
        for name, entry in FIGURES.items()
        if study in entry.studies and entry.automatic and entry.several == (len(paths) > 1)
        if pattern is None or not entry.random
    ]
    if mode is not None and not any(FIGURES[name].mode for name in names):
        raise InputError(f"--mode {mode}: no figure of {paths[0]} shows a mode; {_mode_figures()}")
    return [
        picture
        for name in names
        for picture in draw(paths, name, folder, kind, mode if FIGURES[name].mode else None)
    ]


def draw(paths, name, folder=None, kind="png", mode=None):
    """Draw one figure of one or several result files.

    Args:
        paths: result files.
        name: a name of `FIGURES`.
        folder: where to, beside the first file by default.
        kind: png, pdf or svg.
        mode: the mode to show, counted from 1; None: what the figure shows by itself.

    Returns:
        list of the files written.

    Raises:
        InputError: the figure needs another study, or shows no single mode.
    """
    if name not in FIGURES:
        raise InputError(f"no figure {name!r}; there are {', '.join(FIGURES)}")
    entry = FIGURES[name]
    if mode is not None and not entry.mode:
        raise InputError(f"--mode {mode}: figure {name} does not show a mode; {_mode_figures()}")
    if len(paths) > 1 and not entry.several:
        return [p for path in paths for p in draw([path], name, folder, kind, mode)]
    files = [ResultFile.open(path) for path in paths]
    for file in files:
        if file.config.study not in entry.studies:
            allowed = " or ".join(entry.studies)
            raise InputError(f"{file.path}: figure {name} is for the study {allowed}")
    from matplotlib import pyplot, rc_context  # takes a second to import

    module, function = entry.function.split(".")
    function = getattr(import_module(f"hpcrub.plot.{module}"), function)
    with rc_context(STYLE):
        try:
            figure = function(files) if mode is None else function(files, mode)
            target = _target(files, name, folder, "gif" if isinstance(figure, list) else kind)
            _save(figure, target)
        except ODD_NUMBERS as error:
            raise HpcrubError(
                f"{files[0].path}: figure {name} cannot be drawn, its numbers are odd "
                f"({type(error).__name__}: {str(error):.80})"
            ) from error
        finally:
            pyplot.close("all")
    for file in files:
        file.close()
    return [target]


def _mode_figures():
    names = " and ".join(name for name, entry in FIGURES.items() if entry.mode)
    return f"{names} of the study modal do"


def _save(figure, target):
    """Write a Figure, or a list of pictures, whole or not at all."""
    part = target.with_name(f"{target.name}.hpcrub-part")
    kind = target.suffix[1:]
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        if isinstance(figure, list):
            more = {"save_all": True, "append_images": figure[1:], "duration": 40, "loop": 0}
            figure[0].save(part, kind, **more)
        else:
            figure.savefig(part, dpi=150, format=kind)
        os.replace(part, target)
    except OSError as error:
        with contextlib.suppress(OSError):
            part.unlink(missing_ok=True)
        reason = error.strerror or error
        raise HpcrubError(f"cannot write the figure {target}: {reason}") from None


def _target(files, name, folder, kind):
    """STEM_NAME.kind beside the first file; the first figure of a study is just STEM.kind."""
    first = files[0].path
    folder = Path(folder) if folder else first.parent
    mine = [key for key, entry in FIGURES.items() if files[0].config.study in entry.studies]
    stem = without_suffix(first).name + ("" if name == mine[0] else f"_{name}")
    return folder / f"{name if len(files) > 1 else stem}.{kind}"
