"""Thousands of runs in the corners of the input, checked by other means than the sweep's own.

Ends with 1 if a check fails. All cases take 20 minutes and write docs/stress.md.
"""

import argparse
import itertools
import multiprocessing
import sys
import time

import numpy as np

from evidence import page, progress
from evidence.stress import plausibility
from evidence.stress.checks import EVERY, examine
from evidence.stress.corners import CORNERS, cases
from evidence.stress.plausibility import WORKERS
from hpcrub.contact import status
from hpcrub.contact.lcp.gauss_seidel import MAX_SWEEPS
from hpcrub.contact.status import DIVERGED, NOT_STEADY, STEADY

FAST = 0.01  # share of the cases: the first of every corner
COUNTED = "unconfirmed", "followed", "early", "contacts", "audited", "histories"  # by the checks
MOST_SECONDS = 60  # for one case with all its checks


def main(argv=None):
    """Run, print, write the page; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m evidence.stress", description=__doc__)
    parser.add_argument("--fast", action="store_true",
                        help="few cases and scenes, without the page (30 s)")  # fmt: skip
    fast = parser.parse_args(argv).fast
    began = time.monotonic()
    first = list(itertools.islice(cases(), EVERY + 1))
    for case in progress.followed(first, "compiling"):
        examine(case)  # whatever there is to compile: no case's time is spent on it
    findings, faults = run_cases(list(cases(FAST if fast else 1.0)))
    counts = plausibility.FAST_SCENES if fast else plausibility.SCENES
    scenes = {kind: plausibility.scenes(n, 1, kind) for kind, n in counts.items()}
    faults += [(kind, f"wrong: {f.keys}") for kind in scenes for f in scenes[kind] if f.wrong.any()]
    text, table = report(findings, faults, time.monotonic() - began), plausibility.table(scenes)
    print(text, table, sep="\n")
    if not fast:
        page.replace(page.DOCS / "stress.md", results=text, plausibility=table)
    for where, fault in faults:
        print(f"FAILED {where}: {fault}", file=sys.stderr)
    return 1 if faults else 0


def run_cases(todo):
    """Findings of all cases, and faults as (where, what), a case that hangs among them."""
    findings, faults = [], []
    with multiprocessing.get_context("spawn").Pool(WORKERS) as pool:
        waiting = [(case, pool.apply_async(examine, (case,))) for case in todo]
        for case, answer in progress.followed(waiting, "cases"):
            where = f"{case.corner}, case {case.number}"
            try:
                # earlier cases are done, so that its turn came before the clock starts
                found = answer.get(timeout=MOST_SECONDS)
            except multiprocessing.TimeoutError:
                faults.append((where, f"not finished after {MOST_SECONDS} s"))
                break
            except Exception as error:  # whatever it is, it is a finding
                faults.append((where, f"{type(error).__name__}: {error}"))
                continue
            findings.append(found)
            faults += [(where, fault) for fault in found.faults]
    return findings, faults


def report(findings, faults, seconds):
    """The generated part of docs/stress.md."""
    n_runs = sum(len(f.status) for f in findings)
    head = (f"{n_runs:,} runs in {len(findings)} cases, {seconds:.0f} s on {WORKERS} processes, "
            f"{page.machine()}; {len(faults)} failures.\n")  # fmt: skip
    return "\n".join([head, corner_table(findings), reason_table(findings)])


def corner_table(findings):
    """One row per corner: what its points did and what the checks looked at."""
    heads = ["corner", "runs", "steady", "not steady", "diverged", "only by the step"]
    heads += ["steady, run on", "changed by > 1 %", "contact forces checked"]
    heads += ["penetration [round-off]", "audited", "histories", "most sweeps"]
    rows = []
    for corner in CORNERS:
        mine = [f for f in findings if f.corner == corner]
        if not mine:
            continue
        found = np.concatenate([f.status for f in mine])
        counts = [np.count_nonzero(found == s) for s in (STEADY, NOT_STEADY, DIVERGED)]
        checked = [f"{sum(f.counts[name] for f in mine):,}" for name in COUNTED]
        checked.insert(4, f"{np.max([f.counts['penetration'] for f in mine]):.2g}")
        most = max(f.sweeps.max() for f in mine)
        rows.append([corner, *(f"{n:,}" for n in (len(found), *counts)), *checked, f"{most}"])
    return page.table(heads, rows)


def reason_table(findings):
    """How often every reason was given."""
    reason = np.concatenate([f.reason for f in findings])
    counts = np.bincount(reason, minlength=len(status.WORDS))
    sweeps = np.concatenate([f.sweeps for f in findings])
    counts[status.BALANCE] = sum(f.counts["unbalanced"] for f in findings)
    rows = [[w, f"{n:,}"] for w, n in zip(status.WORDS, counts, strict=True)]
    rows[status.BALANCE][0] += f" (of {sum(f.counts['audited'] for f in findings):,} audited)"
    pivoted = np.count_nonzero(sweeps >= MAX_SWEEPS)
    rows.append([f"(pivoting was needed, after {MAX_SWEEPS} sweeps)", f"{pivoted:,}"])
    return page.table(["reason", "points"], rows)


if __name__ == "__main__":
    sys.exit(main())
