"""Hold the kernel against solutions that share no code with it; writes docs/validation.md (3 min).

Every case ends with thresholds, from theory or from what is asked of the program. Ends with 1 if
one of them is not kept.
"""

import sys
from functools import partial
from importlib import import_module

from evidence import page

CASES = "bouncing_bar", "moving_wall", "clamped_rod", "bent_blade", "run_up"  # modules here


def main():
    """Run cases and write their parts of the page; returns the exit code."""
    failed = []

    def measure(name):
        parts, verdicts = import_module(f"evidence.validation.{name}").section()
        rows = []
        for v in verdicts:
            word, value = "passed" if v.passed else "FAILED", f"{v.value:.3g}"
            rows.append([v.what, value, v.allowed, word if v.passed else f"**{word}**"])
            print(f"  {word}: {v.what}: {value} ({v.allowed})", flush=True)
        failed.extend(v.what for v in verdicts if not v.passed)
        heads = ["threshold", "found", "allowed", "verdict"]
        return parts | {"thresholds": page.table(heads, rows)}

    cases = {name: partial(measure, name) for name in CASES}
    page.sections("validation", __doc__, page.DOCS / "validation.md", cases, on_machine=False)
    if failed:
        print(f"{len(failed)} thresholds are not kept", file=sys.stderr)
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
