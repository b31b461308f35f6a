"""What `hpcrub inspect` says of a file, of whoever's making."""

import h5py
import numpy as np

from hpcrub.__main__ import main as program
from hpcrub.commands import inspect


def test_long_attributes_are_cut(path):
    with h5py.File(path, "r+") as file:
        file.attrs["many"] = np.arange(100_000)
        file.attrs["note"] = "two\nlines"
    text = "\n".join(inspect.description(str(path)))
    assert "note: two\\nlines" in text
    assert max(map(len, text.splitlines())) < 1000  # the words of all reasons


def test_all_files_are_described_and_the_worst_is_the_exit_code(path, capsys):
    other = path.with_name("other.h5")
    other.write_text("hello")
    assert program(["inspect", str(other), str(path)]) == 2
    out, err = capsys.readouterr()
    assert err == f"hpcrub: error: {other} is not an HDF5 file\n"
    assert "done: 0 of 4 samples" in out
    assert "samples/amplitude_m (level 2 x sample 2 x speed 3) [m]: largest" in out


def test_a_command_that_is_misspelt_is_told_the_right_one(capsys):
    assert program(["runn", "own.yaml"]) == 2
    assert "runn is no command and no file; did you mean hpcrub run?" in capsys.readouterr().err
