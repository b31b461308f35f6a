"""The program itself on the ranks that are at hand: messages, and whole studies."""

import json
import tempfile
from pathlib import Path

from evidence.page import ROOT
from evidence.program import run
from evidence.progress import followed
from hpcrub.config.text import counted

# tasks that cost nothing: what is left is rank 0's work for each, its book of the study included
MESSAGES = """\
import sys, time
import numpy as np
from hpcrub.ranks import parallel, schedule

schedule.SERVES_ONLY = 0
N = 4000
RESULT = 1, 1.5, 1.5, 10**6, 0.3, 1e-3, ""
status, amplification = np.zeros((1, N), np.uint8), np.full((2, 1, N), np.nan)

def collect(task, result):
    status[task] = result[0]
    amplification[:, *task] = result[1:3]

def program(team):
    start = time.process_time()
    team.run_tasks([(0, i) for i in range(N)], lambda task, poll: RESULT, collect)
    if team.rank == 0:
        print((time.process_time() - start) / N)
    return 0

sys.exit(parallel.run(program))
"""
RECEIVING = 2 / 3  # of rank 0's work for a task: its result; the rest is to send the next


def messages():
    """Seconds of rank 0 for a message with a result, and for one with the next task."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "messages.py"
        path.write_text(MESSAGES)
        both = float(run(3, path, folder=folder, capture_output=True).split()[-1])
    return RECEIVING * both, (1.0 - RECEIVING) * both


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
            run(n_ranks, ROOT / "main.py", path.name, "--output", "study.h5", "--overwrite",
                "--no-figures", folder=folder, capture_output=True)  # fmt: skip
            log = Path(folder) / "study.runs.jsonl"
            found[n_ranks] = json.loads(log.read_text().splitlines()[-1])
    return found


def integrating(summary):
    """Seconds of the tuned disk and the samples in a run log's summary."""
    return sum(summary["phases"].get(name, 0.0) for name in ("tuned disk", "samples"))
