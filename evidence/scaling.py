"""Measure how a study scales on the ranks of this machine; writes docs/scaling.md (1 min)."""

import argparse
import json
import sys
import tempfile
from pathlib import Path

from evidence import page
from evidence.program import run
from evidence.progress import followed
from hpcrub.config.schema import Config, load_runs
from hpcrub.config.text import counted

EACH = 10  # samples per level
RANKS = 1, 2, 4, 8
SMALL = {  # 9 speeds: two parts
    "casing.n_bumps": 6, "speeds.from_hz": 22.0, "speeds.to_hz": 22.4, "reduction.n_modes": 12,
    "mistuning.half_range_percent": [4.0], "mistuning.tuned_runs": 2,
}  # fmt: skip


def whole_studies(config, n_each, all_ranks):
    """{ranks: summary in the run log} of a study of n_each samples per level; the ranks share the
    cores."""
    few = config.replace({"mistuning.samples": n_each})
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "study.yaml"
        path.write_text(few.to_yaml())
        names = [counted(n, "rank") for n in all_ranks]
        for n_ranks in followed(all_ranks, "whole studies", names=names):
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


def main(argv=None):
    """Measure and write; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m evidence.scaling", description=__doc__)
    parser.add_argument("--fast", action="store_true",
                        help="the whole way with one sample, without the page (10 s)")  # fmt: skip
    if parser.parse_args(argv).fast:
        print(table(whole_studies(Config().replace(SMALL), 1, (1, 2))))
        return 0
    cases = load_runs(page.ROOT / "inputs" / "nodal_diameters.yaml")
    (studied,) = (case for case in cases if case.casing.n_bumps == 4)
    studies = table(whole_studies(studied, EACH, RANKS))
    machine = f"Measured with {page.machine()}."
    page.replace(page.DOCS / "scaling.md", studies=studies, machine=machine)
    return 0


if __name__ == "__main__":
    sys.exit(main())
