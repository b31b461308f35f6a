"""Write docs/validation.md and its figures, and judge them: ``python -m evidence.validation``."""

import sys
import time
from pathlib import Path

from evidence.validation import (
    bouncing_bar,
    cantilever,
    energy_audit,
    full_disk,
    linear_load,
    moving_wall,
    report,
)
from hpcrub import __version__

CASES = (bouncing_bar, moving_wall, cantilever, full_disk, linear_load, energy_audit)
DOCS = Path(__file__).parents[2] / "docs"
HEAD = f"""# Validation

Made by `make validate` with hpcrub {__version__}; do not edit. The cases are in
`evidence/validation/`, and their fast part is in the tests. All use the kernel of the studies.
Every case ends with its thresholds, which come from theory or from what is asked of the program;
`make validate` prints them and fails when one does."""


def main(cases=CASES, docs=DOCS):
    """Run cases and write their page; returns the exit code, 1 if a threshold is not kept."""
    parts, failed = [HEAD], 0
    for case in cases:
        start = time.perf_counter()
        text, verdicts = case.section(docs / "figures")
        parts += [text, report.verdict_table(verdicts)]
        name = case.__name__.rpartition(".")[2]
        print(f"{name}: {time.perf_counter() - start:.0f} s", flush=True)
        for v in verdicts:
            word = "passed" if v.passed else "FAILED"
            print(f"  {word}: {v.what}: {v.value:.3g} ({v.allowed})", flush=True)
        failed += sum(not v.passed for v in verdicts)
    (docs / "validation.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")
    if failed:
        print(f"{failed} thresholds are not kept", file=sys.stderr)
    return min(failed, 1)


if __name__ == "__main__":
    sys.exit(main())
