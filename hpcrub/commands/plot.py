"""`hpcrub plot FILE.h5 [--figure NAME]`: figures from result files alone."""

import argparse
import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

os.environ["MPLBACKEND"] = "Agg"  # pictures need no screen, whatever the environment names

from hpcrub.errors import HpcrubError
from hpcrub.plot import FIGURES, find, pictures
from hpcrub.ranks.progress import console


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
    parser.add_argument("--figure", metavar="NAME", help="this figure only")
    parser.add_argument("--out", metavar="DIR", help="folder, beside the file by default")
    parser.add_argument("--format", choices=("png", "pdf", "svg"), default="png")
    parser.add_argument("--mode", type=int, metavar="K", help="of mode_shapes, mode_animation")
    options = parser.parse_args(argv)
    how = {"mode": options.mode, "folder": options.out, "kind": options.format}
    drawn: Iterable[Path | HpcrubError] = of_study(options.files, **how)
    if options.figure:
        drawn = pictures.draw(find(options.figure), options.files, **how)
    code = 0
    for found in drawn:
        if isinstance(found, HpcrubError):
            print(f"hpcrub: error: {found}", file=sys.stderr)
            code = max(code, found.exit_code)
        else:
            console().print(str(found), soft_wrap=True)
    return code


def of_study(
    paths: Sequence[str], mode: int | None = None, **how: Any
) -> Iterator[Path | HpcrubError]:
    """Pictures of all figures of a study, and the errors of those that cannot be drawn."""
    wanted = pictures.belonging(FIGURES, paths, mode)
    yield from pictures.draw_all(wanted, paths, mode=mode, **how)
