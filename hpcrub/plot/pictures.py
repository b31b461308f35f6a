"""Figures into picture files, named after their results."""

import contextlib
import os
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from matplotlib import rc_context, rcdefaults
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.figure import Figure

from hpcrub.config.types import without_suffix
from hpcrub.errors import HpcrubError, InputError
from hpcrub.plot.canvas import Drawing
from hpcrub.studies import open_result

FRAMES_PER_SECOND = 25
Path_ = str | os.PathLike[str]


def belonging(
    figures: Sequence[Drawing], paths: Sequence[Path_], mode: int | None = None
) -> list[Drawing]:
    """Those of all figures that are drawn of one finished study, or of several together.

    Raises InputError when a mode is given and none of them shows one.
    """
    with open_result(paths[0]) as file:
        study, random = file.config.study, file.config.pattern_deviation is None
        coated = file.config.contact.wears
    found = [
        figure
        for figure in figures
        if study in figure.about.studies
        if (figure.about.several if len(paths) > 1 else figure.about.alone)
        if random or not figure.about.random
        if coated or not figure.about.coated
    ]
    if mode is not None and not any(figure.about.mode for figure in found):
        raise InputError(f"--mode {mode}: no figure of {paths[0]} shows a mode; shapes of modal do")
    return found


def draw_all(
    figures: Sequence[Drawing], paths: Sequence[Path_], **how: Any
) -> Iterator[Path | HpcrubError]:
    """Draw several figures; of one that cannot be drawn the error comes instead of the picture.

    how: as for `draw`; a mode is shown by those figures that can show one.
    """
    mode = how.pop("mode", None)
    for figure in figures:
        try:
            yield from draw(figure, paths, mode=mode if figure.about.mode else None, **how)
        except HpcrubError as error:
            yield error


def draw(
    figure: Drawing, paths: Sequence[Path_], folder: Path_ | None = None, kind: str = "png",
    mode: int | None = None,
) -> list[Path]:  # fmt: skip
    """Draw one figure into picture files, of several result files together or of each.

    folder: beside the first file by default. kind: png, pdf or svg; an animation is a GIF.
    mode: the one to show, counted from 1. Returns the pictures written.
    Raises InputError when the figure needs another study, or shows no single mode.
    """
    if mode is not None and not figure.about.mode:
        name = figure.__name__
        raise InputError(f"--mode {mode}: figure {name} does not show a mode; shapes of modal do")
    together = figure.about.several and len(paths) > 1
    groups = [list(paths)] if together else [[path] for path in paths]
    targets = _targets(figure, groups, folder, mode)
    return [
        _draw_one(figure, group, target, kind, mode)
        for group, target in zip(groups, targets, strict=True)
    ]


def _draw_one(
    figure: Drawing, paths: list[Path_], target: Path, kind: str, mode: int | None
) -> Path:
    options = {} if mode is None else {"mode": mode}
    with rc_context():
        rcdefaults()  # a user's style, or LaTeX that is not there, is for the user's own drawings
        paper = Figure(layout="constrained")
        drawn = figure(paths if len(paths) > 1 else paths[0], paper, **options)
        moving = isinstance(drawn, FuncAnimation)
        target = target.with_name(f"{target.name}.{'gif' if moving else kind}")
        _save(drawn if moving else paper, target)
    return target


def _targets(
    figure: Drawing, groups: list[list[Path_]], folder: Path_ | None, mode: int | None
) -> list[Path]:
    """Pictures without their endings: STEM_NAME beside the file, the first figure just STEM.

    The main figure of a study is just STEM, and one that compares files NAME. Files of one name
    that are drawn into one folder are told apart by the folders they come from.
    """
    found: list[Path] = []
    for group in groups:
        path = Path(group[0])
        name = figure.__name__
        if len(group) == 1:
            name = without_suffix(path).name + ("" if figure.about.main else f"_{name}")
        name += f"_mode_{mode}" if mode is not None else ""
        found.append((Path(folder) if folder else path.parent) / name)
    twice = Counter(found)
    for i, (target, group) in enumerate(zip(list(found), groups, strict=True)):
        if twice[target] > 1:
            parent = Path(group[0]).absolute().parent.name
            named = target.with_name(f"{parent}_{target.name}")
            found[i] = named if named not in found else target.with_name(f"{i + 1}_{target.name}")
    return found


def _save(drawn: Figure | FuncAnimation, target: Path) -> None:
    """Write a figure or an animation, whole or not at all. Raises HpcrubError."""
    part = target.with_name(f"{target.stem}.hpcrub-part{target.suffix}")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        if isinstance(drawn, FuncAnimation):
            drawn.save(part, writer=PillowWriter(FRAMES_PER_SECOND), dpi=80)
        else:
            _freeze(drawn)
            drawn.savefig(part, dpi=150, format=target.suffix[1:], bbox_inches="tight")
        os.replace(part, target)
    except OSError as error:
        reason = error.strerror or error
        raise HpcrubError(f"cannot write the figure {target}: {reason}") from None
    finally:
        with contextlib.suppress(OSError):
            part.unlink(missing_ok=True)


def _freeze(figure: Figure) -> None:
    """Lay a figure out for good, as legends would move with the edges that `tight` cuts."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    for legend in figure.legends:
        legend.set_bbox_to_anchor((0, 0, 1, 1), figure.transFigure)
