"""Write docs/validation.md and its figures: ``python -m validation``."""

import sys
import time
from pathlib import Path

from hpcrub import __version__
from validation import bouncing_bar, cantilever, energy_audit, full_disk, linear_load, moving_wall

CASES = (bouncing_bar, moving_wall, cantilever, full_disk, linear_load, energy_audit)
HEAD = f"""# Validation

Made by `make validate` with hpcrub {__version__}; do not edit. The cases are in `validation/`,
their fast part is in the tests. All use the kernel of the studies, `hpcrub.kernel.march`."""


def main():
    """Run all cases; returns the exit code."""
    docs = Path(__file__).parent.parent / "docs"
    parts = [HEAD]
    for case in CASES:
        start = time.perf_counter()
        parts.append(case.section(docs / "figures"))
        name = case.__name__.partition(".")[2]
        print(f"{name}: {time.perf_counter() - start:.0f} s", flush=True)
    (docs / "validation.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
