"""The run_up study: any ranks, kills within a run, its sources, rates, limits and refusals."""

import os
import shutil
import signal
import time

import h5py
import numpy as np
import pytest

from evidence.truth.hexahedra import sector_arrays
from hpcrub.commands import merge
from hpcrub.config.schema import Config
from hpcrub.effects.coating import depth_of_all
from hpcrub.response.run_up import run_up
from hpcrub.results.layout import DONE
from hpcrub.results.verdict import SINGLE, USELESS
from hpcrub.runs import execution, kept
from hpcrub.setup.problem import build_problem
from hpcrub.studies import checklist, open_result, run_of
from hpcrub.studies.contact import trials
from hpcrub.studies.run_up import summary
from tests.program import (
    TINY,
    computed,
    contents,
    datasets,
    lay_out,
    load,
    refusal,
    run_here,
    start,
)
from tests.setup.test_imported import study_of
from tests.studies.common import refused_study

RUNS = """\
study: run_up
run_up: {from_hz: 33, to_hz: 35, hz_per_s: [2, 8], back: true, interval_hz: 0.25}
limits: {amplitude_mm: 20}
spectrum: {step_hz: 5}
contact: {law: abradable, coating: {yield_mpa: 0.5}}
"""
STUDY = TINY.partition("speeds")[0] + TINY.partition("\n")[2] + RUNS
# every state is kept at once, and the runs of one rank take longer
HELD = """\
import sys, time
from hpcrub.response import run_up
from hpcrub.runs import execution, kept
from hpcrub.commands.run import main

kept.EVERY, go_on = 0.0, run_up.Runner.go_on

def slowly(runner):
    for stretch in go_on(runner):
        time.sleep(0.05)
        yield stretch

run_up.Runner.go_on = slowly
sys.exit(main())
"""


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Folder with an input and its result file, computed on one rank."""
    folder = tmp_path_factory.mktemp("run_up")
    return folder, computed(folder, STUDY, output="one.h5")


@pytest.mark.long
def test_parts_are_merged_to_the_bits_of_the_whole(study, capsys):
    folder, path = study
    parts = []
    for k in (1, 2):
        assert run_here("study.yaml", "--output", "cut.h5", "--part", f"{k}/2", folder=folder) == 0
        parts.append(str(folder / f"cut.part-{k}-of-2.h5"))
    assert merge.main([str(folder / "merged.h5"), *reversed(parts)]) == 0
    assert "4 of 4 samples" in capsys.readouterr().out
    assert datasets(folder / "merged.h5") == datasets(path)


@pytest.mark.mpi
@pytest.mark.parametrize(
    "number", [signal.SIGKILL, pytest.param(signal.SIGTERM, marks=pytest.mark.long)]
)
def test_a_run_that_is_stopped_goes_on_with_the_same_bits(study, number):
    folder, path = study
    (folder / "held.py").write_text(HELD)
    name = f"stopped-{number.name}"
    arguments = "study.yaml", "--output", f"{name}.h5", "--no-figures"
    process = start(0, folder / "held.py", *arguments, folder=folder)
    until = time.monotonic() + 60.0
    while not list(folder.glob(f"{name}.task-*.npz")) and time.monotonic() < until:
        time.sleep(0.01)
    time.sleep(0.3)
    os.kill(process.pid, number)
    process.communicate()
    (state,) = folder.glob(f"{name}.task-*.npz")
    assert np.load(state)["periods"] > 0
    with h5py.File(folder / f"{name}.h5") as file:
        assert not (file["samples/status"][()] == DONE).all()
    assert run_here(*arguments[:-1], "--resume", folder=folder) == 0
    assert datasets(folder / f"{name}.h5") == datasets(path)
    assert not list(folder.glob(f"{name}.task-*"))


def test_a_state_is_kept_until_its_results_are_in_the_file(study, tmp_path, monkeypatch):
    """A kill between the end of a run and the end of its writing loses nothing."""
    monkeypatch.setattr(kept, "EVERY", 0.0)
    with open_result(study[1]) as file:
        config = file.config.replace({"output": str(tmp_path / "a.h5")})
    for task, n_states in (((1,), 2), ((0, 1), 2)):
        tasks = run_of(config).study.compute_all(
            config, build_problem(config), [task], lambda: None
        )
        assert next(tasks)[0] == task
        states = list(tmp_path.glob("a.task-*.npz"))
        assert len(states) == n_states
        states[0].with_name(f"{states[0].name}.hpcrub-part").touch()  # of a kill while it is kept
        assert next(tasks, None) is None  # the job has written the results, and goes on
        assert not list(tmp_path.glob("a.task-*"))


def test_status_tells_of_kept_states_and_a_new_result_forgets_them(tmp_path, capsys):
    (tmp_path / "study.yaml").write_text(STUDY)
    path = lay_out(tmp_path / "a.h5", STUDY)
    state = tmp_path / "a.task-0-1-0.npz"
    state.touch()
    run_here("study.yaml", "--output", str(path), "--status", folder=tmp_path)
    assert "; the state of 1 run in progress is in" in capsys.readouterr().out
    (tmp_path / "a-b.task-0-1-0.npz").touch()  # of another result
    config = load(tmp_path / "study.yaml").replace({"output": str(path)})
    execution.make_sure(run_of(config), execution.Existing(overwrite=True), [])
    assert [*tmp_path.glob("*.npz")] == [tmp_path / "a-b.task-0-1-0.npz"]


def test_a_state_of_another_input_is_not_taken(study, tmp_path):
    folder, path = study
    with open_result(path) as file:
        config = file.config.replace({"output": str(tmp_path / "a.h5")})
    states = [kept.Kept(c, (0, 1)) for c in (config, config.replace({"casing.n_bumps": 3}))]
    assert states[0].path == states[1].path

    class Counter:
        done = 0

        def go_on(self):
            while self.done < 3:
                self.done += 1
                yield self.done

        def result(self):
            return self.done

        def state(self):
            return {"done": np.array(self.done)}

        def restore(self, state):
            self.done = int(state["done"])

    def stop():
        raise kept.Interrupted("stop")

    with pytest.raises(kept.Interrupted):
        states[0].finish(Counter(), stop)
    (tmp_path / "b").mkdir()
    shutil.copy(states[0].path, tmp_path / "b/b.task-0-1.npz")
    states.append(kept.Kept(config.replace({"output": str(tmp_path / "b/b.h5")}), (0, 1)))
    for state, n_left in zip((states[1], states[0], states[2]), (3, 2, 2), strict=True):
        calls = []
        state.finish(Counter(), lambda calls=calls: calls.append(1))
        assert len(calls) == n_left


def test_results_fit_each_other(study):
    _, path = study
    found = contents(path)
    envelope, peak = found["samples/envelope_m"], found["samples/peak_amplitude_m"]
    assert envelope.shape == (2, 2, 2, 8, 2, 8)
    np.testing.assert_array_equal(np.nanmax(envelope, axis=-1), peak)
    best = np.nanargmax(envelope, axis=-1)
    np.testing.assert_array_equal(found["samples/peak_speed_hz"], found["interval_hz"][best])
    above, seconds = peak > 0.02, found["samples/seconds_above_s"]
    np.testing.assert_array_equal(seconds > 0.0, above)
    lasts = 2.0 / np.array([2.0, 8.0])
    assert (seconds <= lasts[:, None, None] * (1 + 1e-9) + 0.1).all()
    worn = found["samples/worn_depth_m"]
    assert (worn[..., 1] >= worn[..., 0]).all()  # a coating never grows back
    assert (worn > 0.0).all()
    tuned = np.median(found["tuned/peak_amplitude_m"], axis=1)
    ratio = np.median(peak, axis=3) / tuned
    np.testing.assert_array_equal(found["samples/amplification"], ratio)


def test_a_leg_in_which_the_tuned_disk_hardly_moves_has_no_amplification(study, tmp_path):
    """A run down in which only mistuned disks touched the casing had amplifications up to 435."""
    path = shutil.copy(study[1], tmp_path / "one.h5")
    with open_result(path, mode="r+") as file:
        peaks = file.read("tuned/peak_amplitude_m")
        for share, told in ((0.5, True), (0.05, False)):
            peaks[0, :, 1] = share * np.median(peaks[0, :, 0])
            file.write({"tuned/peak_amplitude_m": peaks}, ())
            known = np.isfinite(summary.amplifications(file))
            assert known[..., 0, 1].all() == told == known[..., 0, 1].any()
            assert known[..., 0].all()
            said = [f.advice for f in summary.findings(file) if f.why == "no reference"]
            assert [line.startswith("down at 2 Hz/s") for line in said] == [True] * (not told)


def test_peaks_at_the_ends_of_a_run_are_told_with_the_speed_of_the_end(study, tmp_path):
    """It was the middle of an interval: "speeds below 33.12 Hz" of a run from 33 Hz on."""
    path = shutil.copy(study[1], tmp_path / "one.h5")
    with open_result(path, mode="r+") as file:
        for end, words in ((0, "lowest"), (-1, "highest")):
            middle = file.read("interval_hz")[end]
            for group in ("tuned", "samples"):
                there = np.full_like(file.read(f"{group}/peak_speed_hz"), middle)
                file.write({f"{group}/peak_speed_hz": there}, ())
            (said,) = (f.advice for f in summary.findings(file) if f"{words} speed" in f.why)
            assert f" lie at the {words} speed, and may be higher beyond it: " in said
            assert said.endswith((" below 33 Hz", " above 35 Hz")[end])


@pytest.mark.parametrize(("n_runs", "severity"), [(0, None), (4, SINGLE), (5, USELESS)])
def test_runs_that_cut_through_the_coating_are_told(study, tmp_path, n_runs, severity):
    """They were usable, and nothing said that they had come to the casing."""
    path = shutil.copy(study[1], tmp_path / "one.h5")
    with open_result(path, mode="r+") as file:
        through = depth_of_all(file.config)
        depth = np.full_like(file.read("samples/worn_depth_m"), 0.5 * through)
        depth[0, 0, 0, :n_runs, 1] = through  # in the last leg, on the way down
        file.write({"samples/worn_depth_m": depth, "tuned/worn_depth_m": depth[0, 1]}, ())
        told = [f for f in summary.findings(file) if "cut through the coating" in f.why]
    assert [f.severity for f in told] == [severity] * (severity is not None)
    assert all(f.why.startswith(f"{n_runs} of 80 runs ") for f in told)


def test_the_answer_is_of_all_rates_and_of_mistuned_disks_and_has_the_limits(study):
    """The box of a report had the tuned disk at the first rate alone, and "a limit"."""
    _, path = study
    mine = contents(path)
    with open_result(path) as file:
        lines = list(run_of(file.config).study.conclusion(file, True))
        assert "levels x samples x runs x repeats = 2 x 2 x 2 x 8" in run_of(file.config).amount()
    up, down = 1e3 * np.median(
        np.median(mine["samples/peak_amplitude_m"][-1, :, 1], axis=1), axis=0
    )
    assert lines[1].startswith("tuned disk at 8 Hz/s: up ")
    assert lines[1].endswith(f"; median of 2 mistuned disks {up:.3g}, {down:.3g} mm")
    assert [line.partition(" %")[2][:32] for line in lines[2:]] == [
        " of all runs exceed 20 mm, for u"
    ] * 2


def test_the_steady_study_of_the_same_disks_stands_beside(tmp_path, capsys):
    plain = STUDY.replace(RUNS.splitlines()[-1] + "\n", "")
    steady = TINY.replace("step_hz: 0.2", "step_hz: 0.4") + "limits: {amplitude_mm: 20}\n"
    computed(tmp_path, steady, output="steady.h5")
    options = "--set", "sources=[steady.h5]", "--set", "run_up.hz_per_s=[4]"
    path = computed(tmp_path, plain, *options, output="beside.h5")
    assert "over steady" in capsys.readouterr().out
    mine, theirs = contents(path), contents(tmp_path / "steady.h5")
    np.testing.assert_array_equal(mine["samples/steady_peak_m"], theirs["samples/peak_amplitude_m"])
    np.testing.assert_array_equal(mine["samples/deviation"], theirs["samples/deviation"])
    with open_result(path, mode="r+") as file:
        beside = summary.beside_steady(file)
        assert "a steady study of other speeds" in [f.why for f in summary.findings(file)]
        file.write({"steady_speed_hz": np.linspace(33, 35, len(file.read("steady_speed_hz")))}, ())
        assert "a steady study of other speeds" not in [f.why for f in summary.findings(file)]
    for leg in range(2):
        ends = [
            [disk.min() / steady, disk.max() / steady]
            for disk, steady in zip(
                mine["samples/peak_amplitude_m"][:, :, 0, :, leg].reshape(4, 8),
                theirs["samples/peak_amplitude_m"].ravel(), strict=True,
            )
        ]  # fmt: skip
        assert beside["all below"][0, leg] == sum(high < 1.0 for _, high in ends)
        assert beside["all above"][0, leg] == sum(low > 1.0 for low, _ in ends)
        assert beside["largest ratio"][0, leg] == max(high for _, high in ends)
    for key in ("mistuning.seed=5", "casing.n_bumps=3"):
        code = run_here("study.yaml", "--output", "no.h5", *options, "--set", key, folder=tmp_path)
        assert code == 2
        assert "sources: " in capsys.readouterr().err


def test_a_clearance_over_the_time_ends_the_contact(tmp_path):
    # far from the casing until 0.5 s, then near; and the other way round
    text = STUDY.replace(RUNS.splitlines()[-1] + "\n", "") + "casing: {growth_time_s: 0.01}\n"
    peaks = []
    for gaps in ((5.0, 0.25), (0.25, 5.0)):
        table = f"[[0,{gaps[0]}],[0.25,{gaps[0]}],[0.26,{gaps[1]}],[0.5,{gaps[1]}]]"
        more = "--set", f"casing.clearance_s_mm={table}", "--set", "run_up.hz_per_s=[8]"
        path = computed(tmp_path, text, *more, "--overwrite", output="gap.h5")
        peaks.append(contents(path)["tuned/peak_amplitude_m"][0, :, :])
    assert (peaks[0][:, 0] < 1e-4).all()  # the way up: no contact in the first file
    assert (peaks[0][:, 1] > 5e-3).all()
    assert (peaks[1][:, 0] > 5e-3).all()


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("run_up.hz_per_s=[0]", "run_up.hz_per_s[0]: 0 is out of range"),
        ("run_up.to_hz=33", "run_up.to_hz: 33 is run_up.from_hz, too"),
        ("speeds.to_hz=34", "run_up.to_hz: a run from 33 to 35 Hz is not within"),
        ("run_up.speed_s_hz=[[0,33],[1,35]]", "cannot be combined with run_up.speed_s_hz"),
        ("casing.clearance_s_mm=[[0,1],[0.1,1]]", "points from 0 to 0.1 s say nothing of a run"),
        ("casing.clearance_s_mm=[[0,1],[0,1]]", "is not a list of 2 to 1000 increasing values"),
    ],
)
def test_runs_that_cannot_be_are_refused(tmp_path, capsys, key, words):
    assert words in refused_study(tmp_path, STUDY, key, capsys)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("[[0,33],[1,35],[2,33]]", "the speed turns back; if that is meant, say run_up.back: true"),
        ("[[0,33],[1,35],[1,36]]", "is not a list of 2 to 1000 increasing values"),
        ("[[0.5,33],[1,35]]", "the first time is 0.5 s, not 0"),
        ("[[0,0],[1,35]]", "0 Hz; speeds above 0 are allowed"),
    ],
)
def test_tables_that_cannot_be_are_refused(tmp_path, capsys, table, words):
    text = STUDY.replace("from_hz: 33, to_hz: 35, hz_per_s: [2, 8], back: true", "repeats: 8")
    assert words in refused_study(tmp_path, text, f"run_up.speed_s_hz={table}", capsys)


def test_a_run_beyond_the_matrices_of_a_model_file_is_refused(folder):
    arrays = sector_arrays()
    for part in ("data", "indices", "indptr"):
        arrays[f"K0/{part}"] = arrays[f"K1/{part}"] = arrays.pop(f"K/{part}")
    arrays["K1/data"] = 1e-9 * arrays["K0/data"]
    arrays["speeds_hz"] = np.array([0.0, 300.0, 600.0])
    text = "study: run_up\nreduction: {n_modes: 10}\nrun_up: {from_hz: 500, to_hz: 610}\n"
    config = study_of(arrays, text)
    assert "but matrices of 0 to 600 Hz" in refusal(run_of(config).prepare)
    assert run_of(config.replace({"run_up.to_hz": 600})).prepare().scene.repeats == 4


def test_a_table_from_a_file_is_kept_in_the_result(tmp_path):
    text = STUDY.replace("from_hz: 33, to_hz: 35, hz_per_s: [2, 8]", "speed_s_hz: table.csv")
    (tmp_path / "table.csv").write_text("time_s,speed_hz\n0,33\n0.2,35\n0.4,33\n")
    with open_result(computed(tmp_path, text)) as file:
        assert file.config.run_up.speed_s_hz == ((0.0, 33.0), (0.2, 35.0), (0.4, 33.0))
        np.testing.assert_array_equal(file.read("rises"), [1, 0])
        np.testing.assert_allclose(file.read("hz_per_s"), [10.0])


def test_a_checklist_of_run_ups_leaves_out_what_is_of_steady_motions():
    plain = STUDY.replace(RUNS.splitlines()[-1] + "\n", "").replace("run_up\n", "checklist\n", 1)
    config = Config.from_yaml(plain)
    n_disks = checklist.STUDY.sizes(config)["disk"]
    cases = {
        change.what: checklist.STUDY.case(config, number * n_disks)
        for number, change in enumerate(checklist.CHANGES)
    }
    assert cases["half the step of the speeds"] is None
    assert cases["followed twice as long"] is None
    assert cases["half the time step"].config.time.step_s == config.time.step_s / 2
    assert cases["as asked"].config.run_up.hz_per_s == (2.0, 8.0)
    with pytest.MonkeyPatch.context() as patch:  # any of its disks runs up
        seen = []
        patch.setattr(trials, "run_up_of", lambda *run: seen.append(run[2]) or run_up(*run))
        ((_, values),) = trials.peaks_of(
            config, build_problem(config), [cases["as asked"].blades], lambda: None
        )
    assert [schedule.slopes[0] for schedule in seen] == [2.0, 8.0]
    assert 0.005 < values["peak_amplitude_m"] < 0.05
