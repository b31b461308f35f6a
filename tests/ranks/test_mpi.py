"""The same bits on any number of ranks, after any interruption; one error line; no hang."""

import os
import signal
import sys
import time

import h5py
import numpy as np
import pytest

from evidence.faults.job import children, is_alive
from evidence.truth.hexahedra import sector_arrays
from hpcrub.results import model_file
from tests.program import (
    BLISK,
    TINY,
    computed,
    datasets,
    end_of_log,
    error_lines,
    lay_out,
    load,
    run,
    run_here,
    run_on,
    start,
)

pytestmark = pytest.mark.mpi

N_SAMPLES = 12  # on each of two levels, and three runs of the tuned disk
SWEPT = 7  # sweeps of a rank after which it waits to be stopped: not all, on three ranks either
STUDY = TINY.replace("samples: 2", f"samples: {N_SAMPLES}, tuned_runs: 3")
STUDY += "contact: {law: abradable}\n"  # whose wear must be the same, too
RING = "ring: {thickness_mm: 30, width_mm: 20, waves: [0, 2, 3, 4]}"
SPATIAL = (  # in air, in a casing that vibrates; at as many speeds as fill eight lanes
    BLISK.replace("growth_time_s", f"{RING}, growth_time_s").replace("step_hz: 5", "step_hz: 2.5")
    + """\
contact: {law: abradable, coating: {yield_mpa: 0.5, tip_area_mm2: 400}}
mistuning: {half_range_percent: [2, 4], samples: 2, tuned_runs: 3}
convergence: {step: 1}
aero: {influence: [{blades: 0, damping_ratio: 0.005}, {blades: 1, damping_ratio: 0.001}]}
"""
)
WAIT = 60.0  # [s] for anything to happen

DRIVER = """\
import os, signal, sys, time
from hpcrub.ranks import parallel, schedule
from hpcrub.errors import InputError

if "several" in sys.argv:  # tasks with a message
    schedule.ONE_BY_ONE = 1

def program(team):
    def compute(task, poll):
        for _ in range(3):
            time.sleep(0.002)
            poll()
        if "task" in sys.argv and team.rank == int(sys.argv[2]) and task >= 5:
            raise ZeroDivisionError("one rank only")
        if "known" in sys.argv and team.rank == int(sys.argv[2]) and task >= 5:
            raise InputError("one rank only")
        if "signal" in sys.argv and team.rank == int(sys.argv[2]) and task >= 5:
            os.kill(os.getpid(), signal.SIGTERM)
        return team.rank, task
    def some_fail():
        if "together" in sys.argv and team.rank > 0:
            raise InputError(f"rank {team.rank} cannot")
        return team.rank
    assert team.together(some_fail) == team.rank
    assert team.on_root(lambda: team.rank) == 0
    for n_tasks in (0, 1, 40, 2):  # one after the other, fewer than ranks included
        if "late" in sys.argv and team.rank == int(sys.argv[2]):
            time.sleep(0.3)  # rank 0 has long said that nothing is to be done
            os.kill(os.getpid(), signal.SIGTERM)
        results = {}
        def collect(task, result):
            results[task] = result
            return "enough" in sys.argv and len(results) == 10
        team.run_tasks(range(n_tasks), compute, collect)
        if team.rank == 0 and "enough" not in sys.argv:
            assert sorted(results) == list(range(n_tasks))
            assert all(task == echo for task, (_, echo) in results.items())
            if n_tasks == 40:
                print("ranks at work:", len({rank for rank, _ in results.values()}))
        elif team.rank == 0 and n_tasks == 40:
            assert 10 <= len(results) <= 10 + 2 * team.size  # one ahead of the other
    return 0

sys.exit(parallel.run(program))
"""

HELD = f"""\
import sys, time
from hpcrub.response import sweep
from hpcrub.commands.run import main

run_sweeps, n_swept = sweep.run_sweeps, 0

def held(disks, scene, speeds_hz, poll=None, *more, **options):
    global n_swept
    until = time.monotonic() + {WAIT}
    while n_swept >= {SWEPT} and time.monotonic() < until:
        poll()
        time.sleep(0.001)
    n_swept += poll is not None  # not of the warm-up
    return run_sweeps(disks, scene, speeds_hz, poll, *more, **options)

sweep.run_sweeps = held
sys.exit(main())
"""

BAD_INPUTS = """\
import os, sys
from hpcrub.commands import run as cli
from hpcrub.ranks import parallel

def program(team):
    for arguments in sys.argv[1:]:
        team.barrier()
        if team.rank == 0:
            print(f"== {arguments}", file=sys.stderr, flush=True)
        codes = team.comm.gather(cli.main(arguments.split()))
        if team.rank == 0:
            print("codes", *codes, file=sys.stderr, flush=True)
    return 0

sys.exit(parallel.run(program))
"""


STEP = "time.scheme=central_difference --set=time.step_s=2e-4 --set=time.steps_per_bump_width=1"
MESSAGES = {
    "tiny.yaml --set casing.n_bumpz=4": "casing.n_bumpz: unknown key; did you mean casing.n_bumps?",
    f"tiny.yaml --output=a.h5 --set={STEP}": "time.step_s: 0.0002 is not below ",
    "broken.yaml": "broken.yaml: line 2, column 1: ",
    "tiny.yaml --output tiny.yaml/x.h5": "tiny.yaml is no folder",
    "tiny.yaml --resume --set casing.n_bumps=3": "another configuration: casing.n_bumps: 4 in",
    "tiny.yaml --nonsense": "unrecognized arguments: --nonsense (--help lists the options)",
    "tiny.yaml --resume --overwrite": "not allowed with",
}


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Folder with an input, and the bits of its results on one rank in this process."""
    return on_one_rank(tmp_path_factory.mktemp("study"), STUDY)


@pytest.fixture(scope="module")
def spatial(tmp_path_factory):
    """The same of blades that move in three dimensions and cut with two points each."""
    folder = tmp_path_factory.mktemp("spatial")
    model_file.write(folder / "sector.h5", sector_arrays(lean=0.6))
    folder, found = on_one_rank(folder, SPATIAL)
    depths = np.frombuffer(found["samples/worn_depth_m"])
    assert len(set(depths)) > 6  # of 5 speeds and 4 samples
    assert depths.max() > 1e-6
    return folder, found


def on_one_rank(folder, text):
    return folder, datasets(computed(folder, text, output="serial.h5"))


@pytest.fixture
def held(tmp_path):
    """The program, but every rank goes on to the end only when nobody stops it."""
    (tmp_path / "held.py").write_text(HELD)
    return tmp_path / "held.py"


@pytest.fixture
def driver(tmp_path):
    (tmp_path / "driver.py").write_text(DRIVER)
    return tmp_path / "driver.py"


@pytest.mark.parametrize(("kind", "ranks"), [("study", 2), ("spatial", 3)])
def test_same_bits_on_any_number_of_ranks(request, kind, ranks):
    folder, expected = request.getfixturevalue(kind)
    run_on(ranks, "study.yaml", "--output", f"{ranks}.h5", folder=folder)
    assert datasets(folder / f"{ranks}.h5") == expected
    assert not (folder / f"{ranks}.h5.hpcrub-lock").exists()


@pytest.mark.long
def test_more_ranks_than_samples(study):
    """The sweeps of 9 speeds are cut into parts, on different ranks.

    And the statistics have no percentile: HDF5 changes the metadata of a dataset of length zero
    when it opens it; if only some ranks did, these would wait for the others for ever at the end.
    """
    folder, _ = study
    keys = "mistuning.samples=1", "mistuning.half_range_percent=[4]", "mistuning.tuned_runs=1"
    single = [f"--set={key}" for key in (*keys, "speeds.step_hz=0.05", "convergence.step=10")]
    assert run_here("study.yaml", "--output", "s1.h5", *single, folder=folder) == 0
    run_on(3, "study.yaml", "--output", "s3.h5", *single, folder=folder)
    assert datasets(folder / "s1.h5") == datasets(folder / "s3.h5")


def wait_for_samples(process, path, n_wanted):
    """Wait until so many samples are in the file of a running program."""
    deadline = time.monotonic() + WAIT
    while time.monotonic() < deadline and process.poll() is None:
        if path.exists():
            with h5py.File(path, "r", locking=False) as file:
                if np.count_nonzero(file["samples/status"][()]) >= n_wanted:
                    return
        time.sleep(0.02)
    process.kill()
    pytest.fail("".join(process.communicate()))


@pytest.mark.parametrize(
    ("ranks", "number", "resumed_on"),
    [
        pytest.param(2, signal.SIGINT, 1, marks=pytest.mark.long),
        pytest.param(3, signal.SIGUSR1, 1, marks=pytest.mark.long),
        (0, signal.SIGTERM, 2),
    ],
)
def test_stopped_and_resumed_gives_the_same_bits(
    study, held, monkeypatch, capfd, ranks, number, resumed_on
):
    """mpirun passes SIGUSR1 on to its ranks; at SIGINT and SIGTERM it ends them by SIGTERM and
    returns 1, whatever they return."""
    # a busy machine may need far more than the second that mpirun leaves them
    monkeypatch.setenv("OMPI_MCA_odls_base_sigkill_timeout", "6")
    folder, expected = study
    ended = ranks > 0 and number != signal.SIGUSR1
    path = folder / f"{number.name}-{ranks}.h5"
    arguments = ["study.yaml", "--output", path.name, "--no-figures"]
    process = start(ranks, held, *arguments, folder=folder)
    wait_for_samples(process, path, 3)
    process.send_signal(number)
    out, err = process.communicate(timeout=WAIT)
    assert process.returncode == (1 if ended else 75), out + err
    (line,) = error_lines(err)
    assert line.startswith(f"hpcrub: stopped: {'SIGTERM' if ended else number.name}")
    assert "--resume" in line
    with h5py.File(path) as file:
        done = file["samples/status"][()] > 0
        n_done = np.count_nonzero(done)
        assert f"{n_done} of {2 * N_SAMPLES} samples" in line
        assert 3 <= n_done < 2 * N_SAMPLES
        # the statistics of what is there, of each level up to its first gap; rank 0 may not have
        # heard of the last sample of each rank
        leading = np.cumprod(done, axis=1).sum()
        n_blocks = np.isfinite(file["statistics/contact/amplification"][:, 0]).sum()
        assert leading - ranks <= n_blocks <= leading  # without mpirun: exactly
    if not ended:  # after that mpirun leaves little time
        summary = end_of_log(path)
        assert (summary["exit_code"], summary["exit_reason"]) == (75, "stopped")
        assert 0 < summary["done_in_this_run"] <= n_done
    resume(folder, resumed_on, arguments, capfd)
    assert datasets(path) == expected


def resume(folder, ranks, arguments, capfd):
    """Go on to the end, on one rank in this process, and check that what is there is kept."""
    if ranks > 1:
        out = run_on(ranks, *arguments, "--resume", folder=folder)
    else:
        assert run_here(*arguments, "--resume", folder=folder) == 0
        out, _ = capfd.readouterr()
    assert f"of {2 * N_SAMPLES} samples are already there" in out


@pytest.mark.skipif(sys.platform != "linux", reason="looks for the ranks in /proc")
@pytest.mark.parametrize("victim", ["mpirun", pytest.param("all ranks", marks=pytest.mark.long)])
def test_killed_and_resumed_gives_the_same_bits(study, held, capfd, victim):
    """kill -9; what mpirun leaves behind when it is killed must not write on."""
    folder, expected = study
    path = folder / f"killed-{victim}.h5"
    arguments = ["study.yaml", "--output", path.name, "--no-figures"]
    process = start(2, held, *arguments, folder=folder)
    wait_for_samples(process, path, 3)
    of_mpirun = children(process.pid)
    for pid in of_mpirun if victim == "all ranks" else [process.pid]:
        os.kill(pid, signal.SIGKILL)
    process.communicate(timeout=WAIT)
    assert process.returncode != 0
    until = time.monotonic() + WAIT
    while any(map(is_alive, of_mpirun)) and time.monotonic() < until:
        time.sleep(0.02)
    resume(folder, 1, arguments, capfd)
    assert datasets(path) == expected


@pytest.mark.parametrize("mode", ["enough", "several"])
def test_tasks_are_all_done_once(driver, tmp_path, mode):
    code, out, err = run(3, mode, folder=tmp_path, script=driver)
    assert (code, error_lines(err)) == (0, []), err
    assert "ranks at work: 3" in out or mode == "enough"


@pytest.mark.parametrize("rank", [0, 2])
def test_a_rank_that_raises_aborts_the_job(driver, tmp_path, rank):
    code, _, err = run(3, "task", rank, folder=tmp_path, script=driver, timeout=30)
    assert code == 1
    assert "ZeroDivisionError: one rank only" in err


@pytest.mark.parametrize(
    ("words", "code", "line"),
    [
        (["signal", 2], 75, "stopped: SIGTERM"),
        (["late", 2], 75, "stopped: SIGTERM"),  # all is done
        (["known", 1], 2, "error: one rank only"),
        (["together"], 2, "error: rank 1 cannot"),
    ],
)
def test_what_happens_to_some_ranks_stops_all_and_is_said_once(driver, tmp_path, words, code, line):
    found, _, err = run(3, *words, folder=tmp_path, script=driver, timeout=30)
    assert found == code
    assert error_lines(err) == [f"hpcrub: {line}"]
    assert "Traceback" not in err


def test_bad_input_is_one_line_on_any_number_of_ranks(tiny, tmp_path):
    """All in one job, which every rank survives: the next input is tried on the same ranks."""
    (tmp_path / "broken.yaml").write_text("casing: {n_bumps: [4\n")
    (tmp_path / "bad_inputs.py").write_text(BAD_INPUTS)
    lay_out(tmp_path / "results" / "tiny.h5", load(tiny))
    code, out, err = run(2, *MESSAGES, folder=tmp_path, script="bad_inputs.py")
    assert code == 0, out + err
    attempts = err.split("== ")[1:]
    assert len(attempts) == len(MESSAGES)
    for attempt in attempts:
        name, *said = attempt.strip().split("\n")
        assert "Traceback" not in attempt
        (line,) = error_lines(attempt)
        assert line.startswith("hpcrub: error: "), name
        assert MESSAGES[name] in line
        assert "codes 2 2" in said, name
