"""Several runs of one input: one that fails keeps no other, a table says how each has ended."""

from pathlib import Path

import pytest

from hpcrub import studies
from hpcrub.commands import run as cli
from hpcrub.config.schema import Config, load_runs
from hpcrub.errors import InputError
from hpcrub.runs import execution
from hpcrub.studies import open_result
from tests.program import TINY

RUNS = "study: modal\nruns: [{disk.blade.n_elements: 3}, {disk.blade.n_elements: 5}]\n"


def test_a_table_at_the_end_and_the_total_before(folder, capfd):
    Path("a.yaml").write_text(RUNS)
    assert cli.main(["a.yaml", "--dry-run"]) == 0
    said = capfd.readouterr().out
    for text in ("run 1 of 2", "run 2 of 2", "all 2 runs:", "core hours"):
        assert text in said
    assert not Path("results").exists()
    assert cli.main(["a.yaml"]) == 0
    said = capfd.readouterr().out
    for text in ("run 2 of 2", "disk.blade.n_elements=5", "full model, "):
        assert text in said


def test_a_run_that_fails_does_not_keep_the_next_one(folder, capfd):
    stuck = "{contact.friction: 1, disk.blade.lean_deg: 0, output: stuck.h5}"
    last = "{study: modal, output: last.h5}"
    Path("a.yaml").write_text(TINY + f"runs: [{stuck}, {last}]\n")
    assert cli.main(["a.yaml", "--no-figures"]) == 1
    said = capfd.readouterr().out
    assert "this run failed: the tuned disk has no result at any speed" in said
    open_result("last.h5").close()
    assert cli.main(["a.yaml", "--no-figures", "--resume"]) == 1  # it is tried again, last.h5 not
    assert "full model, " in capfd.readouterr().out


def test_a_source_is_never_overwritten(folder):
    run = studies.run_of(Config.from_yaml("study: energy\nsources: [a.h5]\noutput: x/../a.h5"))
    with pytest.raises(InputError, match="is one of the sources"):
        execution.check_output(run, execution.Existing(overwrite=True))


@pytest.mark.parametrize(
    ("runs", "message"),
    [
        ("[{output: a.h5}, {output: ./a.h5}]", "two runs have the output a.h5"),
        ("[{casing.n_bumps: 3, casing: {n_bumps: 4}}]", "casing.n_bumps is given twice"),
        ("[{casing: {n_bumps: 4}, casing.n_bumps: 3}]", "casing.n_bumps is given twice"),
    ],
)
def test_runs_that_contradict_each_other(folder, runs, message):
    Path("a.yaml").write_text(f"runs: {runs}\n")
    with pytest.raises(InputError) as caught:
        load_runs("a.yaml")
    assert message in str(caught.value)
