"""`hpcrub merge OUT.h5 PART.h5 ...`: files of parts of a study become the file of the study."""

import argparse
import os
import shlex
from collections.abc import Sequence

from hpcrub.config.text import counted
from hpcrub.ranks.progress import say
from hpcrub.studies.shared.merge import merge


def main(argv: Sequence[str] | None = None) -> int:
    """Merge the files and print how complete the result is; returns the exit code."""
    parser = argparse.ArgumentParser(prog="hpcrub merge", description=__doc__)
    parser.add_argument("out", metavar="OUT.h5", help="file of the whole study")
    parser.add_argument("parts", metavar="PART.h5", nargs="+", help="files of its parts")
    parser.add_argument("--overwrite", action="store_true", help="replace an existing OUT.h5")
    parser.add_argument(
        "--samples", type=int, metavar="N", help="give OUT.h5 N samples a level, not the parts' own"
    )
    parser.add_argument(
        "--allow-mixed",
        action="store_true",
        help="merge what different states of the program have computed, and name all in OUT.h5",
    )
    options = parser.parse_args(argv)
    out = os.path.expanduser(options.out)
    how = options.overwrite, options.samples, options.allow_mixed
    n_done, n_all = merge(out, options.parts, *how)
    files = counted(len(options.parts), "file")
    say(f"{out}: {n_done} of {counted(n_all, 'sample')}, from {files}")
    if n_done < n_all:
        more = f" --set mistuning.samples={options.samples}" if options.samples else ""
        say(f"main.py with --output {shlex.quote(out)}{more} --resume computes the others")
    return 0
