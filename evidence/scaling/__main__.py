"""Measure how a study scales on this machine; writes docs/scaling.md (5 min)."""

import argparse
import sys

from evidence import page, progress
from evidence.scaling import costs, program, report
from hpcrub.config.schema import Config, load_runs

SAMPLES = 6  # measured of each case, whole and in parts
EACH = 10  # samples per level of the whole studies
RANKS = 1, 2, 4, 8  # of the whole studies
SMALL = {  # 9 speeds: two parts
    "casing.n_bumps": 6, "speeds.from_hz": 22.0, "speeds.to_hz": 22.4, "reduction.n_modes": 12,
    "mistuning.half_range_percent": [4.0], "mistuning.tuned_runs": 2,
}  # fmt: skip


def measure(cases, n_samples, n_each, all_ranks):
    """Everything that is measured, as one dictionary.

    cases: configurations; n_samples: of each case; n_each, all_ranks: samples per level and numbers
    of ranks of whole studies.
    """
    costs.measure(cases[0], 1)  # compiles
    by_bumps = sorted(cases, key=lambda case: case.casing.n_bumps)
    measured = progress.followed(by_bumps, "costs of samples, cases")
    found = {"costs": {c.casing.n_bumps: costs.measure(c, n_samples) for c in measured}}
    print("messages", flush=True)
    found["receive"], found["send"] = program.messages()
    return found | {"studies": program.whole_studies(cases[0], n_each, all_ranks)}


def main(argv=None):
    """Measure and write; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m evidence.scaling", description=__doc__)
    parser.add_argument("--fast", action="store_true",
                        help="the whole way with one sample, without the page (20 s)")  # fmt: skip
    if parser.parse_args(argv).fast:
        found = measure([Config().replace(SMALL)], 1, 1, (1, 2))
        print("\n".join(report.write(found).values()))
        return 0
    cases = load_runs(page.ROOT / "inputs" / "nodal_diameters.yaml")
    cases = sorted(cases, key=lambda case: case.casing.n_bumps != 4)  # the studied one first
    found = measure(cases, SAMPLES, EACH, RANKS)
    parts = report.write(found) | {"machine": f"Measured with {page.machine()}."}
    page.replace(page.DOCS / "scaling.md", **parts)
    return 0


if __name__ == "__main__":
    sys.exit(main())
