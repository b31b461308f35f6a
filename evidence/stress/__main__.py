"""``python -m evidence.stress [SHARE]``: all cases, their checks, round-off; writes docs/stress.md.

Ends with 1 if anything fails. SHARE (0 to 1) runs the first cases of every corner only and leaves
the report as it is.
"""

import itertools
import multiprocessing
import os
import platform
import re
import sys
import time
from pathlib import Path

import numpy as np

from evidence.stress import roundoff
from evidence.stress.checks import EVERY, examine
from evidence.stress.corners import CORNERS, cases
from hpcrub.contact import multipliers, reasons
from hpcrub.response.sweep import warm_up
from hpcrub.results.layout import DIVERGED, NOT_STEADY, STEADY

REPORT = Path(__file__).parents[2] / "docs" / "stress.md"
WORKERS = 2
MOST_SECONDS = 60  # for one case with all its checks


def main(share):
    """Run, print, write the report; returns the exit code."""
    began = time.monotonic()
    warm_up()
    for case in itertools.islice(cases(), EVERY + 1):
        examine(case)  # whatever there is to compile: no case's time is spent on it
    findings, faults = run_cases(list(cases(share)))
    rounding, more = roundoff.compare() if share == 1.0 else (None, [])
    faults += [("round-off", fault) for fault in more]
    text = report(findings, rounding, faults, time.monotonic() - began)
    print(text)
    if share == 1.0:
        old = REPORT.read_text(encoding="utf-8")
        block = re.compile(r"(?<=<!-- results -->\n).*?(?=<!-- end of results -->)", re.DOTALL)
        REPORT.write_text(block.sub(lambda _: text, old), encoding="utf-8")
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
        f"{seconds:.0f} s on {WORKERS} processes, {platform.machine()}; "
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
        status = np.concatenate([f.status for f in mine])
        counts = [np.count_nonzero(status == s) for s in (STEADY, NOT_STEADY, DIVERGED)]
        sums = (sum(getattr(f, name) for f in mine) for name in ("followed", "early"))
        worst, left = (np.max([getattr(f, name) for f in mine]) for name in ("penetration", "left"))
        numbers = [len(status), *counts, sum(f.unconfirmed for f in mine), *sums]
        numbers += [sum(f.contacts for f in mine)]
        most = max(f.sweeps.max() for f in mine)
        again = [sum(getattr(f, name) for f in mine) for name in ("judged", "audited", "histories")]
        row = [*(f"{n:,}" for n in numbers), f"{worst:.2g}", f"{left:.1g}"]
        rows.append([corner, *row, *(f"{n:,}" for n in again), f"{most}"])
    return _markdown(heads, rows)


def reason_table(findings):
    """How often every reason was given."""
    reason = np.concatenate([f.reason for f in findings])
    counts = np.bincount(reason, minlength=len(reasons.WORDS))
    sweeps = np.concatenate([f.sweeps for f in findings])
    counts[reasons.UNBALANCED] = sum(f.unbalanced for f in findings)
    rows = [[w, f"{n:,}"] for w, n in zip(reasons.WORDS, counts, strict=True)]
    rows[reasons.UNBALANCED][0] += f" (of {sum(f.audited for f in findings):,} audited)"
    pivoted = np.count_nonzero(sweeps >= multipliers.MAX_SWEEPS)
    rows.append([f"(pivoting was needed, after {multipliers.MAX_SWEEPS} sweeps)", f"{pivoted:,}"])
    return _markdown(["reason", "points"], rows)


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
    return _markdown(["damping ratio", "chaotic points"], counts) + "\n" + _markdown(heads, rows)


def _markdown(heads, rows):
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


if __name__ == "__main__":
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    sys.exit(main(float(sys.argv[1]) if len(sys.argv) > 1 else 1.0))
