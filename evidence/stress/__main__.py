"""Thousands of runs in the corners of the input, checked by other means than the sweep's own.

Ends with 1 if a check fails. All cases take 10 minutes and write docs/stress.md.
"""

import argparse
import itertools
import multiprocessing
import sys
import time

import numpy as np

from evidence import page
from evidence.stress import limits, plausibility, roundoff
from evidence.stress.checks import EVERY, examine
from evidence.stress.corners import CORNERS, cases
from hpcrub.contact import multipliers, status
from hpcrub.contact.status import DIVERGED, NOT_STEADY, STEADY
from hpcrub.response.sweep import warm_up

FAST = 0.01  # share of the cases: the first of every corner
WORKERS = 2
SCENES = 300  # random ones, at two time steps
LIMITS = 80  # with ever fewer steps, and half as many with few modes
MOST_SECONDS = 60  # for one case with all its checks


def main(argv=None):
    """Run, print, write the page; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m evidence.stress", description=__doc__)
    parser.add_argument("--fast", action="store_true",
                        help="the first case of every corner, without the page (20 s)")  # fmt: skip
    fast = parser.parse_args(argv).fast
    began = time.monotonic()
    warm_up()
    for case in itertools.islice(cases(), EVERY + 1):
        examine(case)  # whatever there is to compile: no case's time is spent on it
    findings, faults = run_cases(list(cases(FAST if fast else 1.0)))
    rounding, more = (None, []) if fast else roundoff.compare()
    faults += [("round-off", fault) for fault in more]
    scenes = [] if fast else plausibility.scenes(SCENES, seed=1)
    faults += [("plausibility", f"wrong: {f.keys}") for f in scenes if f.wrong.any()]
    text = report(findings, rounding, faults, time.monotonic() - began)
    print(text)
    if not fast:
        parts = {"plausibility": plausibility.table(scenes), "limits": limits.tables(LIMITS, 1)}
        page.replace(page.DOCS / "stress.md", results=text, **parts)
    for where, fault in faults:
        print(f"FAILED {where}: {fault}", file=sys.stderr)
    return 1 if faults else 0


def run_cases(todo):
    """Findings of all cases, and faults as (where, what), a case that hangs among them."""
    findings, faults = [], []
    with multiprocessing.get_context("spawn").Pool(WORKERS) as pool:
        waiting = [(case, pool.apply_async(examine, (case,))) for case in todo]
        for case, answer in waiting:
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


def report(findings, rounding, faults, seconds):
    """The generated part of docs/stress.md."""
    parts = [
        f"{sum(len(f.status) for f in findings):,} runs in {len(findings)} cases, "
        f"{seconds:.0f} s on {WORKERS} processes, {page.machine()}; "
        f"{len(faults)} failures.\n",
        corner_table(findings),
        reason_table(findings),
    ]
    if rounding is not None:
        parts.append(rounding_table(rounding))
    return "\n".join(parts)


def corner_table(findings):
    """One row per corner: what its points did and what the checks looked at."""
    heads = ["corner", "runs", "steady", "not steady", "diverged", "only by the step"]
    heads += ["steady, run on", "changed by > 1 %", "contact forces checked"]
    heads += ["penetration [round-off]", "left at a contact [m]", "operators judged"]
    heads += ["audited", "histories", "most sweeps"]
    rows = []
    for corner in CORNERS:
        mine = [f for f in findings if f.corner == corner]
        if not mine:
            continue
        found = np.concatenate([f.status for f in mine])
        counts = [np.count_nonzero(found == s) for s in (STEADY, NOT_STEADY, DIVERGED)]
        sums = (sum(getattr(f, name) for f in mine) for name in ("followed", "early"))
        worst, left = (np.max([getattr(f, name) for f in mine]) for name in ("penetration", "left"))
        numbers = [len(found), *counts, sum(f.unconfirmed for f in mine), *sums]
        numbers += [sum(f.contacts for f in mine)]
        most = max(f.sweeps.max() for f in mine)
        again = [sum(getattr(f, name) for f in mine) for name in ("judged", "audited", "histories")]
        row = [*(f"{n:,}" for n in numbers), f"{worst:.2g}", f"{left:.1g}"]
        rows.append([corner, *row, *(f"{n:,}" for n in again), f"{most}"])
    return page.table(heads, rows)


def reason_table(findings):
    """How often every reason was given."""
    reason = np.concatenate([f.reason for f in findings])
    counts = np.bincount(reason, minlength=len(status.WORDS))
    sweeps = np.concatenate([f.sweeps for f in findings])
    counts[status.BALANCE] = sum(f.unbalanced for f in findings)
    rows = [[w, f"{n:,}"] for w, n in zip(status.WORDS, counts, strict=True)]
    rows[status.BALANCE][0] += f" (of {sum(f.audited for f in findings):,} audited)"
    pivoted = np.count_nonzero(sweeps >= multipliers.MAX_SWEEPS)
    rows.append([f"(pivoting was needed, after {multipliers.MAX_SWEEPS} sweeps)", f"{pivoted:,}"])
    return page.table(["reason", "points"], rows)


def rounding_table(rounding):
    """Chaotic points and the changes of the others."""
    chaotic = rounding["chaotic"]
    rows = [["another order of lanes", "no bit", "no bit"]]
    for name, change in rounding["changes"].items():
        rows.append([name, f"{change[~chaotic].max():.1e}", f"{change[chaotic].max():.1e}"])
    heads = ["change", "largest effect on points that are not chaotic", "on chaotic points"]
    per_damping = chaotic.reshape(len(roundoff.DAMPING), -1)
    counts = [
        [f"{d:g}", f"{c.sum()} of {len(c)}"]
        for d, c in zip(roundoff.DAMPING, per_damping, strict=True)
    ]
    return page.table(["damping ratio", "chaotic points"], counts) + "\n" + page.table(heads, rows)


if __name__ == "__main__":
    sys.exit(main())
