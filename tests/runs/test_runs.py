"""Several runs of one input: all are checked first, one that fails keeps no other."""

from pathlib import Path

import h5py
import numpy as np
import pytest

from hpcrub import plot, studies
from hpcrub.commands import run as cli
from hpcrub.config import parts
from hpcrub.config.schema import Config, differences, load_runs
from hpcrub.errors import InputError
from hpcrub.plot.pictures import draw
from hpcrub.ranks.runlog import RunLog, Work
from hpcrub.runs import cost, execution
from hpcrub.setup.problem import build_problem
from hpcrub.studies import open_result
from tests.plot.stored import PATTERN, PHYSICS
from tests.program import TINY, lay_out, refusal

RUNS = "study: modal\nruns: [{disk.blade.n_elements: 3}, {disk.blade.n_elements: 5}]\n"
DAMPINGS = "runs: [{material.damping_ratio: 5e-3}, {material.damping_ratio: 4e-3, output: low.h5}]"


def test_a_table_at_the_end_and_the_total_before(folder, capfd):
    Path("a.yaml").write_text(RUNS)
    assert cli.main(["a.yaml", "--dry-run"]) == 0
    said = capfd.readouterr().out
    for text in ("run 1 of 2", "run 2 of 2", "all 2 runs:", "core hours"):
        assert text in said
    assert not Path("results").exists()
    assert cli.main(["a.yaml", "--no-figures"]) == 0
    said = capfd.readouterr().out
    for text in ("run 2 of 2", "disk.blade.n_elements=5", "full model, "):
        assert text in said


def test_an_output_of_the_command_line_is_refused_where_runs_name_their_own(tmp_path):
    """The runs' own outputs would be written, and with --overwrite replaced."""
    path = tmp_path / "a.yaml"
    path.write_text(TINY + "runs: [{output: first.h5}, {casing.n_bumps: 3}]")
    assert len(load_runs(path)) == 2
    with pytest.raises(InputError, match=r"output: 1 of 2 runs .* replace 'elsewhere.h5'"):
        load_runs(path, ["output=elsewhere.h5"])


def test_a_key_of_the_command_line_that_every_run_replaces_is_refused(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text(TINY + DAMPINGS.replace("output: low.h5", "casing: {n_bumps: 3}"))
    with pytest.raises(InputError, match=r"damping_ratio: 2 of 2 runs .* replace 0.001 of the"):
        load_runs(path, ["material.damping_ratio=0.001"])
    bumps = [config.casing.n_bumps for config in load_runs(path, ["casing.n_bumps=5"])]
    assert bumps == [5, 3]


@pytest.mark.parametrize("n_speeds", [1, 2, 9, 41])
def test_the_trial_of_a_dry_run_takes_as_many_speeds_as_a_disk_of_the_study(n_speeds):
    """Few speeds leave lanes idle: filled up in the trial, they seemed up to four times as fast."""
    speeds = {"from_hz": 33.5, "to_hz": 33.5 + 0.05 * (n_speeds - 1)}
    config = Config(speeds=speeds, steady_state={"first_check_s": 0.05, "max_time_s": 0.2})
    tried = cost.trial(config, build_problem(config)).result
    assert len(tried.time) == n_speeds


def test_a_dry_run_with_resume_counts_what_is_there(folder, capfd):
    """It told the time of a whole study, also of one that was finished."""
    text = "study: linear\nmistuning: {samples: 2}\noutput: a.h5\n"
    Path("a.yaml").write_text(text)
    with h5py.File(lay_out(Path("a.h5"), text), "r+") as file:
        file["status"][:3] = 1
    assert cli.main(["a.yaml", "--dry-run", "--resume"]) == 0
    assert "already there:        75 %" in capfd.readouterr().out
    assert cli.main(["a.yaml", "--no-figures", "--resume"]) == 0
    assert cli.main(["a.yaml", "--dry-run", "--resume"]) == 0
    assert "estimated run time:   0 s on 1 rank, 0 core hours" in capfd.readouterr().out


@pytest.mark.long
def test_runs_are_one_file_each_with_the_same_disks(folder, capfd):
    """A figure that does not suit them, the convergence of two samples, is left out in silence."""
    Path("a.yaml").write_text(TINY + DAMPINGS)
    assert cli.main(["a.yaml"]) == 0
    assert "no figure" not in capfd.readouterr().out
    for name in ("compare", "percentiles", "amplitudes", "running_means"):
        assert Path(f"results/a/{name}.png").exists()
    assert not Path("results/a/convergence_errors.png").exists()
    with open_result("results/a/damping_ratio=0.005.h5") as a, open_result("low.h5") as b:
        (line,) = differences(a.config, b.config)
        assert line == "material.damping_ratio: 0.005 in the file, 0.004 asked for"
        np.testing.assert_array_equal(a.read("samples/deviation"), b.read("samples/deviation"))


@pytest.mark.long
def test_runs_of_one_pattern_have_no_statistics(folder):
    Path("a.yaml").write_text(PHYSICS + PATTERN + DAMPINGS)
    assert cli.main(["a.yaml"]) == 0
    pictures = sorted(p.name for p in Path("results/a").glob("*.png"))
    assert pictures == ["compare.png", "damping_ratio=0.005.png"]


def test_a_run_may_start_from_the_one_before(folder, capfd):
    """Its dry run was refused, as the first result is not there yet."""
    second = "{study: energy, sources: [first.h5], energy.samples: 1, output: second.h5}"
    Path("a.yaml").write_text(TINY + f"runs: [{{output: first.h5}}, {second}]")
    assert cli.main(["a.yaml", "--dry-run"]) == 0
    assert "energy, 2 tasks, not estimated: from a run before it" in capfd.readouterr().out
    assert cli.main(["a.yaml", "--no-figures"]) == 0
    open_result("second.h5").close()


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
        ("4", "runs: 4 is not a list of 1 to 1000 runs"),
        ("[]", "is not a list of 1 to"),
        ("[3]", "runs: 3 does not replace keys"),
    ],
)
def test_wrong_runs(folder, runs, message):
    Path("a.yaml").write_text(f"study: contact\nruns: {runs}\n")
    assert message in refusal(load_runs, "a.yaml")


@pytest.mark.parametrize(
    ("second", "message"),
    [
        ("{time: {scheme: central_difference, step_s: 2e-4, steps_per_bump_width: 1}}", "the stab"),
        ("{casing: {n_bumps: 3}}", "two runs have the output"),
        ("{output: there.h5}", "there.h5 exists: --resume goes on with it"),
        ("{study: energy, sources: [nowhere.h5]}", "nowhere.h5 as HDF5: No such file"),
        ("{mistuning.samples: 1.0e+12}", "not enough"),
    ],
)
def test_all_runs_are_checked_before_the_first(folder, capfd, second, message):
    Path("a.yaml").write_text(TINY + f"runs: [{{casing.n_bumps: 3}}, {second}]")
    Path("there.h5").touch()
    assert cli.main(["a.yaml"]) == 2
    assert message in capfd.readouterr().err
    assert not Path("results").exists()


def test_results_whose_names_hold_numbers_share_nothing(folder):
    """r_0.25 and r_0.50, without .h5: the name does not end at its first point."""
    beside, runs = [], []
    for name in ("r_0.25", "r_0.50.h5"):
        cfg = Config.from_yaml(TINY + f"output: {folder / name}")
        lay_out(cfg.output, cfg)
        RunLog(cfg.output, 1).end(Work(), 0)
        part = parts.cut(cfg, 1, 2).output
        Path("a.yaml").write_text(f"output: {name}\nruns: [{{casing.n_bumps: 3}}]")
        runs += [run.output for run in load_runs("a.yaml")]
        (picture,) = draw(plot.summary, [cfg.output])
        beside.append({Path(part), picture})
    assert beside[0] == {folder / f"r_0.25{end}" for end in (".part-1-of-2.h5", ".png")}
    assert beside[1] == {folder / f"r_0.50{end}" for end in (".part-1-of-2.h5", ".png")}
    assert runs == ["r_0.25/n_bumps=3.h5", "r_0.50/n_bumps=3.h5"]
    assert Path("r_0.25.runs.jsonl").exists()
