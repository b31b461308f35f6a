"""`hpcrub plot FILE.h5 [--figure NAME]`: draw figures from result files."""

import argparse
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

os.environ["MPLBACKEND"] = "Agg"  # pictures need no screen, whatever the environment names

from hpcrub.errors import HpcrubError, InputError, complain
from hpcrub.plot import FIGURES, pictures
from hpcrub.plot.canvas import Drawing
from hpcrub.ranks.progress import say
from hpcrub.studies import open_result


def main(argv: Sequence[str] | None = None) -> int:
    """Draw the figures and print the names of their files; returns the exit code."""
    lines = [f"  {f.__name__:19} {f.about.what} ({'/'.join(f.about.studies)})" for f in FIGURES]
    parser = argparse.ArgumentParser(
        prog="hpcrub plot",
        description="Draw figures from result files.",
        epilog="figures:\n" + "\n".join(lines),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("files", nargs="+", metavar="FILE.h5")
    names = {figure.__name__: figure for figure in FIGURES}
    parser.add_argument("--figure", metavar="NAME", choices=names, help="this figure only")
    parser.add_argument("--output", metavar="DIR", help="folder, beside the file by default")
    parser.add_argument("--format", choices=("png", "pdf", "svg"), default="png")
    parser.add_argument("--mode", type=int, metavar="K", help="of mode_shapes")
    options = parser.parse_args(argv)
    how = {"mode": options.mode, "folder": options.output, "kind": options.format}
    drawn: Iterable[Path | HpcrubError] = (end for _, end in of_study(options.files, **how))
    if options.figure:
        drawn = pictures.draw(names[options.figure], options.files, **how)
    code = 0
    for outcome in drawn:
        if isinstance(outcome, HpcrubError):
            complain(f"hpcrub: error: {outcome}")
            code = max(code, outcome.exit_code)
        else:
            say(str(outcome))
    return code


def of_study(
    paths: Sequence[str], mode: int | None = None, **how: Any
) -> Iterator[tuple[Drawing, Path | HpcrubError]]:
    """Draw all figures of one study, or those that compare several; yield their picture files.

    Each comes with its figure; for one that cannot be drawn its error is yielded. mode: only
    figures that can show one mode are drawn; how: options of `pictures.draw`. Raises InputError
    when no figure shows a mode.
    """
    with open_result(paths[0]) as file:
        config = file.config
    wanted = [
        figure
        for figure in FIGURES
        if not figure.about.lacking(config)
        if (figure.about.several if len(paths) > 1 else figure.about.alone)
        if mode is None or figure.about.mode
    ]
    if mode is not None and not wanted:
        raise InputError(f"--mode {mode}: no figure of {paths[0]} shows a mode")
    for figure in wanted:
        try:
            yield from ((figure, path) for path in pictures.draw(figure, paths, mode=mode, **how))
        except HpcrubError as error:
            yield figure, error
