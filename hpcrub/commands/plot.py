"""`hpcrub plot FILE.h5 [--figure NAME]`: figures from result files alone."""

import argparse
import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

os.environ["MPLBACKEND"] = "Agg"  # pictures need no screen, whatever the environment names

from hpcrub.errors import HpcrubError, InputError
from hpcrub.plot import FIGURES, pictures
from hpcrub.ranks.progress import say
from hpcrub.studies import open_result


def main(argv: Sequence[str] | None = None) -> int:
    """Draw and name the figures; returns the exit code."""
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
    parser.add_argument("--out", metavar="DIR", help="folder, beside the file by default")
    parser.add_argument("--format", choices=("png", "pdf", "svg"), default="png")
    parser.add_argument("--mode", type=int, metavar="K", help="of mode_shapes")
    options = parser.parse_args(argv)
    how = {"mode": options.mode, "folder": options.out, "kind": options.format}
    drawn: Iterable[Path | HpcrubError] = of_study(options.files, **how)
    if options.figure:
        drawn = pictures.draw(names[options.figure], options.files, **how)
    code = 0
    for found in drawn:
        if isinstance(found, HpcrubError):
            print(f"hpcrub: error: {found}", file=sys.stderr)
            code = max(code, found.exit_code)
        else:
            say(str(found))
    return code


def of_study(
    paths: Sequence[str], mode: int | None = None, **how: Any
) -> Iterator[Path | HpcrubError]:
    """Pictures of all figures of one finished study, or of those that compare several.

    Of one that cannot be drawn the error comes instead. mode: those alone that can show one; how:
    as for `pictures.draw`. Raises InputError when there are none.
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
            yield from pictures.draw(figure, paths, mode=mode, **how)
        except HpcrubError as error:
            yield error
