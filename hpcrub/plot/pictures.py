"""Drawing of figures into picture files, which are named after their result files."""

import contextlib
import os
from collections.abc import Sequence
from pathlib import Path

from matplotlib import rc_context, rcdefaults
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from hpcrub.config.types import without_suffix
from hpcrub.errors import HpcrubError, reason
from hpcrub.plot.canvas import Drawing

Path_ = str | os.PathLike[str]


def draw(
    figure: Drawing, paths: Sequence[Path_], folder: Path_ | None = None, kind: str = "png",
    mode: int | None = None,
) -> list[Path]:  # fmt: skip
    """Draw one figure into picture files, one for several result files together or one for each.

    folder: by default the folder of the first file. kind: png, pdf or svg.
    mode: number of the mode to show, from 1. Returns the paths of the pictures. A picture is named
    STEM_NAME after its file, the main one of a study STEM, and one that compares files NAME; where
    files of one name are drawn into one folder, the names of their own folders come first.
    Raises InputError when the figure needs another study, or cannot show a single mode.
    """
    alike = folder is not None and len({Path(path).name for path in paths}) < len(paths)
    together = figure.about.several and len(paths) > 1
    targets = []
    for group in [list(paths)] if together else [[path] for path in paths]:
        path, name = Path(group[0]), figure.__name__
        if len(group) == 1:
            name = without_suffix(path).name + ("" if figure.about.main else f"_{name}")
            name = f"{path.absolute().parent.name}_{name}" if alike else name
        name += f"_mode_{mode}" if mode is not None else ""
        with rc_context():
            rcdefaults()  # a user's own style, or LaTeX that is missing, must not matter
            paper = Figure(layout="constrained")
            figure(group if len(group) > 1 else path, paper, mode=mode)
            targets.append((Path(folder) if folder else path.parent) / f"{name}.{kind}")
            _save(paper, targets[-1])
    return targets


def _save(drawn: Figure, target: Path) -> None:
    """Write a figure, as a whole or not at all. Raises HpcrubError."""
    part = target.with_name(f"{target.stem}.hpcrub-part{target.suffix}")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        ConstrainedLayoutEngine().execute(drawn)
        drawn.set_layout_engine("none")  # legends would move with the edges that `tight` cuts
        for legend in drawn.legends:
            legend.set_bbox_to_anchor((0, 0, 1, 1), drawn.transFigure)
        drawn.savefig(part, dpi=150, format=target.suffix[1:], bbox_inches="tight")
        os.replace(part, target)
    except OSError as error:
        raise HpcrubError(f"cannot write the figure {target}: {reason(error)}") from None
    finally:
        with contextlib.suppress(OSError):
            part.unlink(missing_ok=True)
