"""Break disks, files and processes on purpose and check what the program does.

Ends with 1 if anything is wrong. All faults take 20 to 40 minutes and write docs/faults.md.
"""

import argparse
import collections
import concurrent.futures
import re
import sys
import tempfile
import time
from pathlib import Path

from evidence import page
from evidence.faults import disks, signals
from evidence.faults.job import Skip

AT_ONCE = 6  # faults: most of the time they wait
HEADS = ("fault", "trials", "exit codes (how often)", "when, or for example", "problems")
GROUPS = {"signals": signals.FAULTS, "disks and files": disks.FAULTS}


def main(argv=None):
    """Run, print, write the page; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m evidence.faults", description=__doc__)
    parser.add_argument("word", nargs="*", help="only faults with a WORD in their name; no page")
    words = parser.parse_args(argv).word
    began = time.monotonic()
    chosen = [
        (group, name)
        for group, faults in GROUPS.items()
        for name in faults
        if not words or any(word in name for word in words)
    ]
    with (
        tempfile.TemporaryDirectory(prefix="faults-") as folder,
        concurrent.futures.ProcessPoolExecutor(AT_ONCE) as pool,
    ):
        found = list(pool.map(row, *zip(*chosen, strict=True), [Path(folder)] * len(chosen)))
    problems = [problem for _, some in found for problem in some]
    tables = []
    for group in GROUPS:
        rows = [line for (g, _), (line, _) in zip(chosen, found, strict=True) if g == group]
        if rows:
            tables.append(f"**{group[0].upper()}{group[1:]}**\n\n{page.table(HEADS, rows)}")
    text = f"{time.monotonic() - began:.0f} s; {len(problems)} problems.\n\n" + "\n".join(tables)
    print(text)
    if not words:
        page.replace(page.DOCS / "faults.md", results=text)
    for problem in problems:
        print(f"FAILED {problem}", file=sys.stderr)
    return 1 if problems else 0


def row(group, name, folder):
    """Cause one fault: the line of its table, and what went wrong."""
    place = folder / _slug(group) / _slug(name)
    began, codes, said, n_trials = time.monotonic(), collections.Counter(), "", 0
    whens, mine = collections.Counter(), []
    try:
        for trial in GROUPS[group][name](place):
            n_trials += 1
            codes[str(trial.code)] += 1
            said = said or trial.said
            whens.update([trial.when] * bool(trial.when))
            if trial.problem:
                mine.append(f"{name}: {trial.problem}")
    except Skip as reason:
        said = str(reason)
    except Exception as error:  # the trial itself went wrong: as bad as what it looks for
        mine.append(f"{name}: {type(error).__name__}: {error}")
    took = time.monotonic() - began
    told = f"{name}: {n_trials} trials, {len(mine)} problems, {took:.0f} s"
    print("\n".join([told, *mine]), flush=True)
    ends = ", ".join(f"{code} ({n})" for code, n in codes.most_common())
    message = ", ".join(f"{n} {when}" for when, n in whens.most_common()) or said
    message = re.sub(r"/\S*/", "", message.removeprefix("hpcrub: ")).replace("|", "/")
    message = message if len(message) <= 110 else message[:107] + "..."
    return [name, f"{n_trials}", ends or "skipped", message, f"{len(mine)}"], mine


def _slug(name):
    return re.sub(r"\W+", "-", name)


if __name__ == "__main__":
    sys.exit(main())
