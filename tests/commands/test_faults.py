"""What every reader says of a damaged file; `make test-faults` breaks disks and processes, too."""

from pathlib import Path

import pytest

from hpcrub.__main__ import main as program
from tests.plot.stored import PHYSICS
from tests.program import TINY, error_lines, lay_out

READERS = [
    "inspect cut.h5", "report cut.h5", "plot cut.h5", "study.yaml --resume --output cut.h5",
    "energy.yaml --output of_source.h5", "merge merged.h5 cut.h5", "merge x.h5 cut.h5 --samples 3",
]  # fmt: skip


@pytest.mark.parametrize("words", READERS)
def test_every_reader_refuses_a_damaged_file(folder, words, capfd):
    """A result file without its end."""
    Path("study.yaml").write_text(TINY)
    energy = "study: energy\nsources: [cut.h5]\nenergy: {samples: 2}\nmistuning: {samples: 2}\n"
    Path("energy.yaml").write_text(energy + PHYSICS)
    Path("cut.h5").write_bytes(Path(lay_out("whole.h5")).read_bytes()[:-100])
    assert program(words.split()) == 2
    (line,) = error_lines(capfd.readouterr().err)
    assert "truncated file" in line
