"""Every study of several tasks has the same bits on two ranks; one job of both computes them all.

What a contact study does on ranks, stopped and resumed, is in `tests.ranks`.
"""

import shutil

import pytest

from tests.program import BRIEF, ROOT, TINY, computed, datasets, end_of_log, error_lines, run
from tests.studies.test_run_up import STUDY as RUN_UP

SIX = BRIEF.replace("samples: 2", "samples: 64").replace("[2, 4]", "[2]")
LEVEL = BRIEF.replace("samples: 2", "samples: 110").replace("[2, 4]", "[4]")
STUDIES = {
    "linear": "study: linear\nlinear: {n_diameters: [4]}\nmistuning: {samples: 8}\n",
    "checklist": f"study: checklist\nchecklist: {{disks: 2}}\n{BRIEF}",
    "rare": f"study: rare\nlimits: {{amplitude_mm: 15, probability_error: 0.4}}\n{LEVEL}",
    "threshold": "study: threshold\nlimits: {amplitude_mm: 15}\nthreshold: {tolerance: 0.6,"
    f" key: casing.clearance_mm, lowest: 0.2, highest: 1.4, probability: 0.4}}\n{LEVEL}",
    "patterns": "study: patterns\ndisk: {n_blades: 6}\npatterns: {types_percent: [3, -3],"
    f" percentile: 90, kept: 2, contact_samples: 2}}\n{SIX}",
    "run_up": RUN_UP,
    "own_law": f'{TINY}contact: {{own_law: "spring_law.py:Spring", friction: 0}}\n',
}
DRIVER = """\
import sys
from hpcrub.commands import run as cli

for name in sys.argv[1:]:
    assert cli.main([f"{name}.yaml", "--output", f"{name}-2.h5", "--no-figures"]) == 0
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder with the results of all studies of one rank, NAME.h5, and of two, NAME-2.h5."""
    folder = tmp_path_factory.mktemp("ranks")
    shutil.copy(ROOT / "inputs/spring_law.py", folder)
    for name, text in STUDIES.items():
        computed(folder, text, output=f"{name}.h5")
        (folder / "study.yaml").rename(folder / f"{name}.yaml")
    (folder / "driver.py").write_text(DRIVER)
    code, out, err = run(2, *STUDIES, folder=folder, script=folder / "driver.py")
    assert (code, error_lines(err)) == (0, []), out + err
    return folder


@pytest.mark.mpi
@pytest.mark.long
@pytest.mark.parametrize("name", STUDIES)
def test_two_ranks_give_the_same_bits(folder, name):
    assert datasets(folder / f"{name}-2.h5") == datasets(folder / f"{name}.h5")
    logged = end_of_log(folder / f"{name}-2.h5")
    assert logged["done_in_this_run"] > 0
    assert logged["idle_share"] < 1.0
