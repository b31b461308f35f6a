"""Figures into picture files, named after their results."""

import contextlib
import os
from collections.abc import Sequence
from pathlib import Path

from matplotlib import rc_context, rcdefaults
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.figure import Figure

from hpcrub.config.types import without_suffix
from hpcrub.errors import HpcrubError
from hpcrub.plot.canvas import Drawing

FRAMES_PER_SECOND = 25
Path_ = str | os.PathLike[str]


def draw(
    figure: Drawing, paths: Sequence[Path_], folder: Path_ | None = None, kind: str = "png",
    mode: int | None = None,
) -> list[Path]:  # fmt: skip
    """Draw one figure into picture files, of several result files together or of each.

    folder: beside the first file by default. kind: png, pdf or svg; an animation is a GIF.
    mode: the one to show, counted from 1. Returns the pictures written. One is named STEM_NAME
    after its file, the main one of a study STEM, and one that compares files NAME; files of one
    name that are drawn into one folder are told apart by the folders they come from.
    Raises InputError when the figure needs another study, or shows no single mode.
    """
    alike = folder is not None and len({Path(path).name for path in paths}) < len(paths)
    together = figure.about.several and len(paths) > 1
    found = []
    for group in [list(paths)] if together else [[path] for path in paths]:
        path, name = Path(group[0]), figure.__name__
        if len(group) == 1:
            name = without_suffix(path).name + ("" if figure.about.main else f"_{name}")
            name = f"{path.absolute().parent.name}_{name}" if alike else name
        name += f"_mode_{mode}" if mode is not None else ""
        with rc_context():
            rcdefaults()  # a user's style, or LaTeX that is not there, is for the user's drawings
            paper = Figure(layout="constrained")
            drawn = figure(group if len(group) > 1 else path, paper, mode=mode)
            moving = isinstance(drawn, FuncAnimation)
            ending = "gif" if moving else kind
            found.append((Path(folder) if folder else path.parent) / f"{name}.{ending}")
            _save(drawn if moving else paper, found[-1])
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
