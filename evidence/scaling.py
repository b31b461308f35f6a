"""Measure how a study scales on the ranks of this machine; writes docs/scaling.md (1 min)."""

import argparse
import json
import tempfile
from pathlib import Path

from evidence import page
from evidence.program import run
from evidence.progress import followed
from hpcrub.config.schema import load_runs
from hpcrub.config.text import counted

EACH = 10  # samples per level
RANKS = 1, 2, 4, 8


def whole_studies():
    """{ranks: summary in the run log} of a study of EACH samples per level; the ranks share the
    cores."""
    cases, found = load_runs(page.ROOT / "inputs" / "nodal_diameters.yaml"), {}
    (studied,) = (case for case in cases if case.casing.n_bumps == 4)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "study.yaml"
        path.write_text(studied.replace({"mistuning.samples": EACH}).to_yaml())
        names = [counted(n, "rank") for n in RANKS]
        for n_ranks in followed(RANKS, "whole studies", names=names):
            run(n_ranks, page.ROOT / "main.py", path.name, "--output", "study.h5", "--overwrite",
                "--no-figures", folder=folder, capture_output=True)  # fmt: skip
            log = Path(folder) / "study.runs.jsonl"
            found[n_ranks] = json.loads(log.read_text().splitlines()[-1])
    return found


def table(studies):
    """Table of the seconds of the tuned disk and the samples, by ranks; the first has one."""
    rows, one = [], None
    for n_ranks, summary in studies.items():
        seconds = sum(summary["phases"].get(name, 0.0) for name in ("tuned disk", "samples"))
        one = one or seconds
        idle = f"{100 * summary['idle_share']:.1f} %"
        rows.append([n_ranks, f"{seconds:.1f}", f"{one / seconds:.2f}", idle])
    return page.table(["ranks", "measured [s]", "speed-up", "ranks idle"], rows)


def main():
    """Measure and write."""
    argparse.ArgumentParser(prog="python -m evidence.scaling", description=__doc__).parse_args()
    page.replace(page.DOCS / "scaling.md", studies=table(whole_studies()), machine=page.measured())


if __name__ == "__main__":
    main()
