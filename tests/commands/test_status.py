"""`hpcrub run --status`: how far a result file is, and how long the rest will take."""

import json
import os

import h5py
import pytest

from hpcrub.results import layout
from tests.program import TINY, lay_out, load, run_here

BEGAN = 1_800_000_000  # seconds since 1970
TEXT = "study: linear\nmistuning: {samples: 200}\n"  # 16 tasks


def log(*lines):
    """A log of runs, each (second at which it began, tasks it has computed or None)."""
    rows = []
    for began, n_done in lines:
        start = f"2027-01-15T08:{began // 60:02}:{began % 60:02}+00:00"
        rows.append({"event": "start", "start": start, "ranks": 2})
        if n_done is not None:
            rows.append({"event": "end", "start": start, "done_in_this_run": n_done})
    return "".join(f"{json.dumps(row)}\n" for row in rows)


@pytest.mark.parametrize(
    ("lines", "left"),
    [
        ([(0, None)], ", about 60 s left on 2 ranks"),  # 4 in 20 s, 12 to go
        ([(0, 2), (10, None)], ", about 60 s left on 2 ranks"),  # 2 of them in 10 s
        ([(0, 4)], ", about 60 s left on 2 ranks"),  # stopped
        ([(0, None), (10, None)], ""),  # killed: what it did is not known
        ([], ""),
    ],
)
def test_the_time_left_is_that_at_the_rate_of_the_last_run(folder, capsys, lines, left):
    (folder / "study.yaml").write_text(f"{TEXT}output: one.h5\n")
    path = lay_out(folder / "one.h5", load(folder / "study.yaml"))
    with h5py.File(path, "r+") as file:
        assert file["status"].size == 16
        file["status"][:4] = layout.DONE
    (folder / "one.runs.jsonl").write_text(log(*lines))
    os.utime(path, (BEGAN + 20, BEGAN + 20))
    assert run_here("study.yaml", "--status", folder=folder) == 75
    assert capsys.readouterr().out.endswith(f"one.h5: 4 of 16 tasks{left}\n")


def test_of_a_complete_study_no_time_is_left(folder, capsys):
    (folder / "study.yaml").write_text(f"{TINY}output: one.h5\n")
    assert run_here("study.yaml", folder=folder) == 0
    assert run_here("study.yaml", "--status", folder=folder) == 0
    assert "left" not in capsys.readouterr().out.splitlines()[-1]
