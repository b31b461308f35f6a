"""`python -m hpcrub.plot FILE.h5 [--figure NAME]`: figures from result files alone."""

import argparse
import sys

from hpcrub import plot
from hpcrub.errors import HpcrubError
from hpcrub.progress import console


def main(argv=None):
    """Draw and name the figures; returns the exit code."""
    lines = [f"  {name:14} {e.what} ({'/'.join(e.studies)})" for name, e in plot.FIGURES.items()]
    parser = argparse.ArgumentParser(
        prog="python -m hpcrub.plot",
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
    extra = {} if options.mode is None else {"mode": options.mode}
    try:
        for picture in pictures(options, extra):
            console().print(picture, soft_wrap=True)
    except HpcrubError as error:
        print(f"hpcrub: error: {error}", file=sys.stderr)
        return error.exit_code
    return 0


def pictures(options, extra):
    """Paths of the figures asked for."""
    if options.figure:
        return plot.draw(options.files, options.figure, options.out, options.format, **extra)
    return plot.draw_study(options.files, options.out, options.format)


if __name__ == "__main__":
    sys.exit(main())
