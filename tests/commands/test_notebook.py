"""Studies from Python, and what editors know of an input: as a person would use them."""

import json
import os
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import hpcrub
from hpcrub.commands import keys
from hpcrub.commands.notebook import Bar
from hpcrub.config.schema import Config
from hpcrub.config.text import key_table
from hpcrub.errors import HpcrubError, InputError
from hpcrub.studies import STUDIES
from tests.program import ENVIRONMENT, ROOT, refusal


def test_a_study_from_python(folder, capfd, monkeypatch):
    for name, value in ENVIRONMENT.items():  # as root, too
        monkeypatch.setenv(name, value)
    config = hpcrub.Config(study="modal", casing={"n_bumps": 3}, output="modal.h5")
    path = hpcrub.run(config)
    assert "full model, " in capfd.readouterr().out
    with hpcrub.open(path) as file:
        assert file.config.casing == config.casing
        assert file["full/frequencies_hz"][0] == pytest.approx(90.1, abs=0.05)
    keys_of_input = {"study": "modal", "casing": {"n_bumps": 5}, "output": "modal.h5"}
    again = hpcrub.run(keys_of_input, ranks=2, overwrite=True, quiet=True)
    assert again == path
    with hpcrub.open(path) as file:
        assert file.config.casing.n_bumps == 5
    assert capfd.readouterr().out == ""


class Cells:
    """What a notebook shows: a list of outputs, each with the pages that it had in turn."""

    def __init__(self):
        self.outputs = []

    HTML = staticmethod(str)

    def display(self, page, display_id):
        assert display_id
        self.outputs.append([page])
        return SimpleNamespace(update=self.outputs[-1].append)


def test_progress_in_a_notebook_is_one_bar(capsys):
    """It was an output for every line."""
    cells = Cells()
    show = Bar(cells)
    for line in (
        "loading the kernel\n",
        "samples: 1 of 8, 5 s left <b>\n",
        "samples: 8 of 8\n",
        "Verdict: usable.\n",
        "disks: 9 of at most about 7 (at most 60)\n",
    ):
        show(line)
    first, second = cells.outputs
    assert [re.search(r'value="(\d+)" max="(\d+)"', page).groups() for page in first] == [
        ("1", "8"),
        ("8", "8"),
    ]
    assert "&lt;b&gt;" in first[0]
    assert 'value="7" max="7"' in second[0]
    assert capsys.readouterr().out == "loading the kernel\nVerdict: usable.\n"


@pytest.mark.long
def test_input_files_are_configurations_too(folder):
    keys = "disk: {n_blades: 3, blade: {n_elements: 1}}\nreduction: {n_modes: 6}\n"
    (folder / "a.yaml").write_text("study: modal\n" + keys)
    made = hpcrub.run("a.yaml", output="four.h5", quiet=True, figures=True)
    assert made.with_suffix(".png").exists()
    with pytest.raises(InputError, match="--resume goes on with it, --overwrite replaces it"):
        hpcrub.run("a.yaml", output="four.h5", quiet=True)


@pytest.mark.long
def test_any_name_of_a_file_is_taken_and_returned_as_it_is(folder, monkeypatch):
    """A name beyond the first 65,536 characters was no file name, and ~ was returned as it was."""
    monkeypatch.setenv("HOME", str(folder))
    table = folder / "\U0001f600é.csv"
    table.write_text("angle_deg,radius_change_mm\n0,0\n90,-1\n180,0\n270,-1\n")
    config = hpcrub.Config(study="modal", casing={"profile_csv": str(table)}, output="~/-x.h5")
    with hpcrub.open(hpcrub.run(config, quiet=True)) as file:
        assert file.config.casing.profile_csv == str(table)
    made = hpcrub.run({"study": "modal", "output": "-x.h5"}, quiet=True, overwrite=True)
    assert made.exists()
    assert (folder / "-x.h5").exists()


@pytest.mark.parametrize("make", [hpcrub.run, lambda keys: hpcrub.Config().replace(keys)])
def test_wrong_input_is_an_exception_before_any_work(make):
    message = "study: 'modl' is not one of branches, .*did you mean modal"
    with pytest.raises(InputError, match=message):
        make({"study": "modl"})


def test_numbers_of_numpy_and_paths_are_values_too():
    """np.int64(20) was "not a whole number"."""
    mistuning = {"samples": np.int64(20), "half_range_percent": (np.float64(1), 2)}
    config = Config(mistuning=mistuning, output=Path("a", "b.h5"))
    assert config == Config(
        mistuning={"samples": 20, "half_range_percent": [1, 2]}, output="a/b.h5"
    )
    assert Config.from_yaml(config.to_yaml()) == config
    assert "true is not a whole number" in refusal(lambda: Config(mistuning={"samples": True}))


def test_no_ranks_are_refused():
    """A study ran on one rank."""
    assert (
        refusal(lambda: hpcrub.run(Config(study="modal"), 0))
        == "ranks: 0 is not a whole number from 1"
    )


def test_what_is_no_input_is_refused():
    """A list ended in a traceback."""
    assert refusal(lambda: hpcrub.run([1, 2])).startswith("[1, 2] is no Config, no keys")


def test_a_configuration_is_replaced_and_never_changed():
    config = hpcrub.Config(casing={"clearance_mm": 0.3})
    again = config.replace({"casing": {"n_bumps": 3}, "mistuning.pattern": [1.0] * 6 + [0.0] * 6})
    assert (again.casing.n_bumps, again.casing.clearance_mm) == (3, 0.3)
    assert again.mistuning.half_range_percent == (1.0,)  # as an input file with this pattern
    assert again.replace({"mistuning.pattern": [2.0] * 12}).mistuning.half_range_percent == (2.0,)
    assert config == hpcrub.Config(casing={"clearance_mm": 0.3})
    with pytest.raises(ValueError, match="frozen"):
        config.study = "modal"
    with pytest.raises(InputError, match="5 does not replace keys"):
        config.replace(5)


def test_an_mpirun_that_starts_nothing_says_why(tmp_path, monkeypatch):
    launcher = tmp_path / "mpirun"
    launcher.write_text("#!/bin/sh\necho There are not enough slots >&2\nexit 1\n")
    launcher.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    with pytest.raises(HpcrubError, match="There are not enough slots"):
        hpcrub.run(hpcrub.Config(output=str(tmp_path / "x.h5")), ranks=2)


def test_the_schema_of_editors_is_in_step_with_the_program():
    stored = json.loads((ROOT / "inputs/schema.json").read_text(encoding="utf-8"))
    now = keys.schema()
    names = now["properties"]["study"]["enum"]
    assert names == list(STUDIES)
    assert stored == now, "python -m hpcrub keys --schema > inputs/schema.json"
    for path in (ROOT / "inputs").glob("*.yaml"):
        first = path.read_text(encoding="utf-8").partition("\n")[0]
        assert first == "# yaml-language-server: $schema=schema.json"


def test_keys_are_printed(capsys):
    assert keys.main(["casing"]) == 0
    printed = capsys.readouterr().out
    wanted = [key.path for key in key_table(Config) if "casing" in key.path]
    assert [line.partition(":")[0] for line in printed.splitlines()[::2]] == wanted
    assert refusal(keys.main, ["clearence"]) == "no key has 'clearence' in its path"
