"""What `hpcrub inspect` says of a file, of whoever's making."""

import h5py
import numpy as np

from hpcrub.__main__ import main as program
from hpcrub.commands import inspect


def test_a_terminal_takes_nothing_of_a_file_for_a_command(path):
    with h5py.File(path, "r+") as file:
        file.attrs["note"] = "\x1b[2Jgone"
        file.attrs["many"] = np.arange(100_000)
        file.attrs["\x1b[31mred"] = 1
    text = "\n".join(inspect.description(str(path)))
    assert "\x1b" not in text
    assert "note: \\x1b[2Jgone" in text
    assert max(map(len, text.splitlines())) < 1000  # the words of all reasons


def test_a_small_file_that_claims_to_be_huge_is_described(path):
    """Datasets of petabytes without a value, groups a thousand deep, a group that holds itself."""
    with h5py.File(path, "r+") as file:
        file.create_dataset("huge", shape=(10**12,), dtype="f8", chunks=(1000,), fillvalue=1.0)
        file.create_dataset("wide", shape=(10**6, 10**6), dtype="f8", chunks=(10, 10))
        group = file
        for _ in range(1000):
            group = group.create_group("deeper")
        file["samples/everything"] = file["/"]
        file["around"] = h5py.SoftLink("/")
    text = list(inspect.description(str(path)))
    assert 10 < len(text) < 1000


def test_all_files_are_described_and_the_worst_is_the_exit_code(path, capsys):
    other = path.with_name("other.h5")
    other.write_text("hello")
    assert program(["inspect", str(other), str(path)]) == 2
    out, err = capsys.readouterr()
    assert err == f"hpcrub: error: {other} is not an HDF5 file\n"
    assert "done: 0 of 4 samples" in out
    assert "samples/amplitude_m (level 2 x sample 2 x speed 3) [m]: largest" in out


def test_a_file_of_the_first_layout_is_described(path):
    with h5py.File(path, "r+") as file:
        del file.attrs["layout"]
        for name in ("programs", "samples/computed_by", "tuned/computed_by"):
            del file[name]
    lines = "\n".join(inspect.description(str(path)))
    assert "computed by:\n    unknown hpcrub 0.1.0 (revision" in lines
    assert "samples/computed_by" not in lines
