"""`python -m hpcrub plot FILE.h5 [--figure NAME]`: figures from result files alone."""

import argparse
import sys

from hpcrub import plot
from hpcrub.errors import HpcrubError
from hpcrub.run.progress import console


def main(argv=None):
    """Draw and name the figures; returns the exit code."""
    lines = [f"  {name:14} {e.what} ({'/'.join(e.studies)})" for name, e in plot.FIGURES.items()]
    parser = argparse.ArgumentParser(
        prog="python -m hpcrub plot",
        description="Draw figures from result files.",
        epilog="figures:\n" + "\n".join(lines),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("files", nargs="+", metavar="FILE.h5")
    parser.add_argument("--figure", metavar="NAME", help="this figure only")
    parser.add_argument("--out", metavar="DIR", help="folder, beside the file by default")
    parser.add_argument("--format", choices=("png", "pdf", "svg"), default="png")
    parser.add_argument("--mode", type=int, metavar="K", help="mode shown by shapes, animation")
    options = parser.parse_args(argv)
    try:
        for picture in pictures(options):
            console().print(picture, soft_wrap=True)
    except HpcrubError as error:
        print(f"hpcrub: error: {error}", file=sys.stderr)
        return error.exit_code
    return 0


def pictures(options):
    """Paths of the figures asked for."""
    how = options.out, options.format, options.mode
    if options.figure:
        return plot.draw(options.files, options.figure, *how)
    return plot.draw_study(options.files, *how)
