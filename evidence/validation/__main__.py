"""Hold the kernel against solutions that share no code with it; writes docs/validation.md (3 min).

Every case ends with thresholds, from theory or from what is asked of the program. Ends with 1 if
one of them is not kept.
"""

import argparse
import sys
import tempfile
from importlib import import_module
from pathlib import Path

from evidence import page, progress

CASES = (  # modules of this folder
    "bouncing_bar", "moving_wall", "clamped_rod", "bent_blade", "bent_disk", "run_up",
)  # fmt: skip


def main(argv=None):
    """Run cases, write their page when all have run; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m evidence.validation", description=__doc__)
    parser.add_argument("cases", nargs="*", choices=[*CASES, []], help="these, without the page")
    options = parser.parse_args(argv)
    if names := options.cases:
        with tempfile.TemporaryDirectory() as folder:
            return run(names, Path(folder))[1]
    parts, code = run(CASES, page.DOCS / "figures")
    page.replace(page.DOCS / "validation.md", **parts)
    return code


def run(names, figures):
    """Parts of the page of some cases; 1 if a threshold is not kept, else 0.

    figures: folder that their figures are written to.
    """
    parts, failed = {}, 0
    for name in progress.followed(names, "validation", names=names):
        found, verdicts = import_module(f"evidence.validation.{name}").section(figures)
        rows = []
        for v in verdicts:
            word, value = "passed" if v.passed else "FAILED", f"{v.value:.3g}"
            rows.append([v.what, value, v.allowed, word if v.passed else f"**{word}**"])
            print(f"  {word}: {v.what}: {value} ({v.allowed})", flush=True)
        found["thresholds"] = page.table(["threshold", "found", "allowed", "verdict"], rows)
        parts |= {f"{name}_{part}": text for part, text in found.items()}
        failed += sum(not v.passed for v in verdicts)
    if failed:
        print(f"{failed} thresholds are not kept", file=sys.stderr)
    return parts, min(failed, 1)


if __name__ == "__main__":
    sys.exit(main())
