"""An effect from a file outside the package is wherever those of the package are."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.program import ENVIRONMENT, ROOT, TINY, contents

RUN = """
import sys
sys.path.insert(0, sys.argv[1])
import offset  # which makes the effect known
from hpcrub.__main__ import main
from hpcrub.commands import report

report.of_study = lambda *_, **__: iter(())  # pictures take most of the time
for words in ("a.yaml", "c.yaml", "a.yaml --set contact.friction=0 --output b.h5"):
    assert main(["run", *words.split(), "--no-figures"]) == 0
for name in "ab":
    assert main(["report", f"{name}.h5"]) == 0
"""


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """A folder with results of a contact study and of a checklist, and what was printed."""
    folder = tmp_path_factory.mktemp("own_effect")
    (folder / "a.yaml").write_text(f"{TINY}output: a.h5\n")
    (folder / "c.yaml").write_text(
        f"{TINY}study: checklist\nchecklist: {{disks: 1}}\noutput: c.h5\n"
    )
    command = [sys.executable, "-c", RUN, str(Path(__file__).parent)]
    env = os.environ | ENVIRONMENT | {"PYTHONPATH": str(ROOT)}
    found = subprocess.run(command, cwd=folder, env=env, capture_output=True, text=True)
    assert found.returncode == 0, found.stdout + found.stderr
    return folder, found.stdout


def test_its_quantities_are_in_the_result_file(done):
    with_it, without = (contents(done[0] / name) for name in ("a.h5", "b.h5"))
    assert not [name for name in without if "offset" in name]
    offset, largest = with_it["samples/offset_m"], with_it["samples/largest_offset_m"]
    assert (offset > 0.0).all()
    np.testing.assert_array_equal(offset.max(axis=-1), largest)
    assert (offset < with_it["samples/amplitude_m"]).all()  # which is never below a mean


def test_it_is_in_summary_verdict_and_checklist(done):
    folder, printed = done
    tuned = 1e3 * contents(folder / "a.h5")["tuned/offset_m"].max()
    assert f"tuned offset {tuned:.4g} mm" in printed
    assert "- the tips have an offset" in printed
    words = "Percentiles of largest offsets, and their intervals (95 %) [mm]"
    assert words in " ".join(printed.split())
    assert "twice the offset:" in printed


def test_it_is_in_reports_or_what_they_leave_out(done):
    pages = [(done[0] / f"{name}.html").read_text() for name in "ab"]
    assert ["the tips have an offset" in page for page in pages] == [True, False]
    assert ["No tip is dragged aside." in page for page in pages] == [False, True]
