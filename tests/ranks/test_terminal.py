"""What a person meets at the terminal: what is compiled when, lines that fit the screen; what is
missing is said once: an h5py without MPI, a launcher whose ranks have no mpi4py."""

import contextlib
import io
import os
import pty
import re
import subprocess
import sys
from types import SimpleNamespace

import numba
import numpy as np
import pytest

from hpcrub import studies
from hpcrub.config.schema import Config
from hpcrub.contact.lanes import WIDTHS
from hpcrub.errors import InputError, complain
from hpcrub.ranks import parallel, progress
from hpcrub.ranks.parallel import Team
from hpcrub.ranks.runlog import Work
from hpcrub.results.layout import DONE
from hpcrub.runs import warmup
from hpcrub.runs.job import Job
from hpcrub.setup.problem import build_problem
from tests.program import ENVIRONMENT, ROOT, TINY, command, error_lines, run, run_here

COLUMNS = 60  # of the terminal
WARM = """\
import sys
from hpcrub import studies
from hpcrub.config import schema as config
from hpcrub.contact.integrate import integrate
from hpcrub.ranks.parallel import Team
from hpcrub.response import sweep
from hpcrub.runs import warmup
from hpcrub.setup import disks

for text in sys.argv[1:]:
    cfg = config.Config.from_yaml(text)
    problem = studies.run_of(cfg).prepare()
    study = studies.run_of(cfg).study
    warmup.warm_up(Team(), cfg, study.problem_of(problem), study.histories)
    warm = list(integrate.signatures)
    if cfg.study == "contact":
        modes = disks.modes_of(cfg, problem, disks.deviation(cfg, 0, 0))
        sweep.run_sweep(modes, problem.scene, cfg.speeds.values_hz)
    else:
        list(study.compute(cfg, problem, 0, lambda: None))
    assert warm == list(integrate.signatures)
    print(len(warm))
"""


def test_a_message_and_its_end_are_written_at_once(monkeypatch):
    """What mpirun printed of an abort in between stood on the same line."""
    pieces = []

    class Unbuffered(io.RawIOBase):
        def writable(self):
            return True

        def write(self, data):
            pieces.append(bytes(data))
            return len(data)

    monkeypatch.setattr(sys, "stderr", io.TextIOWrapper(Unbuffered(), write_through=True))
    complain("hpcrub: error: one")
    assert [*filter(None, pieces)] == [b"hpcrub: error: one\n"]


@pytest.mark.parametrize(("folder", "told"), [("", True), ("folder", False)])
def test_a_run_that_cannot_keep_compiled_code_says_so(folder, told, monkeypatch, capsys):
    monkeypatch.setattr(numba.config, "CACHE_DIR", folder)
    monkeypatch.setattr(warmup.sweep, "run_sweep", lambda *args, **how: None)
    warmup.warm_up(Team(), Config(), build_problem(Config()), False)
    assert ("XDG_CACHE_HOME" in capsys.readouterr().out) == told


class Three(Team):
    """One of three ranks, whose calls are its own alone."""

    def __init__(self, rank):
        super().__init__()
        self.rank, self.size = rank, 3

    def together(self, function):
        return function()


def test_the_last_rank_compiles_what_may_follow_while_it_would_wait(monkeypatch):
    """Its own kernel it loads after that, as all ranks do; a disk that cannot bend is no error."""
    done = []
    monkeypatch.setattr(numba.config, "CACHE_DIR", "folder")
    monkeypatch.setattr(warmup, "_load", lambda config, problem, histories: done.append(problem))
    problem = build_problem(Config())

    def none_there():
        raise InputError("no such disk")

    for rank, further, compiled in (
        (0, lambda: "next", [problem]), (1, lambda: "next", []),
        (2, lambda: "next", ["next"]), (2, None, []), (2, none_there, []),
    ):  # fmt: skip
        done.clear()
        warmup.warm_up(Three(rank), Config(), problem, False, further)
        assert done == [*compiled, problem]


def test_nothing_is_compiled_in_a_task(tmp_path):
    """There it would be compiled on all ranks at once, deaf to signals."""
    (tmp_path / "warm.py").write_text(WARM)
    contact = TINY.replace("to_hz: 34.4", "to_hz: 34.0")
    response = contact + "study: time_response\nhistory: {duration_s: 0.5}"
    many = TINY.replace("samples: 2", "samples: 500").replace("step_hz: 0.2", "step_hz: 0.1")
    code, out, err = run(0, contact, response, many, folder=tmp_path, script="warm.py", timeout=300)
    wider = 2 + (len(WIDTHS) > 1)  # five speeds fill eight lanes, and end with four
    numbers = [line for line in out.splitlines() if line.isdigit()]
    assert (code, numbers) == (0, ["1", "2", str(wider)]), err


def test_an_output_without_our_characters_gets_others(monkeypatch):
    plain = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr(sys, "stdout", plain)
    progress.console().print("sigma of ±2 %: σ")
    plain.flush()
    assert plain.buffer.getvalue().rstrip() == b"sigma of ?2 %: ?"


LEFT = {
    None: "150, 6.67 min left",
    100: "about 100 (at most 150), about 3.33 min left",
    1000: "about 150 (at most 150), about 6.67 min left",
    40: "at most 150, more than the 40 expected",
    0: "at most 150",
}


@pytest.mark.parametrize("expected", LEFT)
def test_the_time_left_is_told_for_the_parts_that_are_expected(expected, capsys):
    """25 of this run took 100 s. Of 13,200 disks a search took 1,276, and "at most hours" left.

    Those before `begin`, such as the linear disks of a study of patterns, tell no time.
    """
    run = studies.run_of(Config(study="linear"))
    job = Job(run, Team(), None, None, progress.Progress(run.config))
    job.status, job.n_finished = np.repeat(np.uint8([1, 0]), [49, 101]), 49
    job.work, job.expected = Work(20), expected
    job.begin()
    job.work += Work(24)
    job.progress.began -= 100.0
    job.progress.shown -= 100.0
    job._collect([49], 1.0)
    assert capsys.readouterr().out == f"tasks: 50 of {LEFT[expected]}\n"


@pytest.mark.parametrize("stops", [True, False])
def test_a_contact_study_that_may_converge_before_its_end_says_at_most(stops, capsys):
    shown = progress.Progress(Config(convergence={"stop_when_converged": stops}))
    shown.start(np.zeros((1, 150), dtype=np.uint8))
    shown.began, shown.shown = shown.began - 100.0, shown.shown - 100.0
    shown.done = 24
    shown.sample(0, 24, SimpleNamespace(status=DONE), np.full((1, 150), np.nan))
    told = "at most 150, at most about" if stops else "150,"
    assert f"samples: 25 of {told} 8.33 min left (0.25/s)\n" in capsys.readouterr().out


RUNS = "A of the pattern: 1.00 / 1.00 / 3.00 (least, median and largest of 3 runs)"
FOUR = {"half_range_percent": [4]}


@pytest.mark.parametrize(
    ("mistuning", "values", "told"),
    [
        ({"pattern": [1.0] * 11 + [4.0]}, [1.2], "A of the pattern: 1.20"),
        ({"pattern": [1.0] * 12}, [1, 3, 1], RUNS),
        (FOUR, [1.2, np.nan], "A at ±4 %: 1.20"),
        (FOUR, [1, 3], "A at ±4 %: 1.02 / 2.00 / 2.98 (percentiles 1/50/99)"),
    ],
)
def test_one_disk_has_no_percentiles_on_its_way(mistuning, values, told, capsys):
    """An explicit pattern was told as "A at ±4 %: 1.20 / 1.20 / 1.20 (percentiles 1/50/99)"."""
    shown = progress.Progress(Config(mistuning=mistuning))
    shown.start(np.zeros((1, len(values)), dtype=np.uint8))
    shown.done, shown.shown = len(values) - 1, shown.shown - 100.0
    shown.sample(0, 0, SimpleNamespace(status=DONE), np.array([values], dtype=float))
    assert capsys.readouterr().out.endswith(f"/s); {told}\n")


@pytest.mark.long
def test_a_reader_that_leaves_and_a_full_disk_end_no_command(tmp_path):
    """`hpcrub keys | head` was a traceback; so was a study whose log stood on a full disk."""
    (tmp_path / "a.yaml").write_text("study: modal\noutput: a.h5\n")
    environment = os.environ | ENVIRONMENT | {"PYTHONPATH": str(ROOT)}
    end, gone = os.pipe()
    os.close(end)
    with os.fdopen(gone, "w") as left, open("/dev/full", "w") as full:
        study, lost = ["run", "a.yaml", "--no-figures"], "No space left on device"
        for out, words in ((left, ["keys"]), (full, ["--help"]), (full, study)):
            line = [sys.executable, "-m", "hpcrub", *words]
            how = {"cwd": tmp_path, "env": environment, "stderr": subprocess.PIPE}
            done = subprocess.run(line, stdout=out, text=True, **how)
            said = f"hpcrub: nothing is printed any more: {lost}\n" if out is full else ""
            assert (done.returncode, done.stderr) == (0, said)
    assert run_here("a.yaml", "--status", folder=tmp_path) == 0


@pytest.mark.long
def test_where_nothing_can_be_printed_at_all_a_study_is_computed(tiny):
    """Not even that nothing is printed any more, which ended the study before its first sample."""
    with open("/dev/full", "w") as full:
        for unbuffered, words, code in (
            ("1", [tiny, "--no-figures"], 0),
            ("", ["inspect", "x.h5"], 2),
        ):
            environment = os.environ | ENVIRONMENT | {"PYTHONUNBUFFERED": unbuffered}
            how = {"cwd": tiny.parent, "env": environment, "stderr": full}
            line = command(0, ROOT / "main.py", *words)
            assert subprocess.run(line, stdout=full, **how).returncode == code
    assert run_here(tiny, "--status", folder=tiny.parent) == 0


@pytest.mark.skipif(not os.path.exists("/dev/ptmx"), reason="no terminals here: no /dev/ptmx")
def test_lines_and_tables_fit_the_terminal(tiny):
    try:
        pid, terminal = pty.fork()
    except OSError as error:
        pytest.skip(f"no terminals here: {error}")
    if pid == 0:
        os.chdir(tiny.parent)
        os.environ.update(ENVIRONMENT, COLUMNS=str(COLUMNS), TERM="xterm")
        more = "--no-figures", "--set=mistuning.samples=10"
        os.execv(sys.executable, command(0, ROOT / "main.py", "tiny.yaml", *more))
    output = bytearray()
    with contextlib.suppress(OSError):  # how Linux says that the other side has closed it
        while part := os.read(terminal, 65536):
            output += part
    os.close(terminal)
    plain = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", output.decode())
    assert os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 0, plain
    lines = re.split(r"[\r\n]+", plain)
    assert any(line.startswith("samples: 20 of 20, 0 s left (") for line in lines)
    told = [line for line in lines if str(tiny.parent) not in line]
    assert max(map(len, told)) <= COLUMNS  # the name of a file may be longer


@pytest.mark.mpi
@pytest.mark.long
def test_an_h5py_without_mpi_is_one_line(tiny, tmp_path):
    lines = [
        "import h5py",
        "from types import SimpleNamespace",
        "h5py.get_config = lambda: SimpleNamespace(mpi=False)",
        "from hpcrub.commands.run import main",
        "raise SystemExit(main())",
    ]
    (tmp_path / "main.py").write_text("\n".join(lines))
    code, _, err = run(2, "tiny.yaml", folder=tmp_path, script="main.py")
    assert code == 2
    (line,) = error_lines(err)
    assert line.startswith("hpcrub: error: this h5py is built without MPI")
    assert "`make setup`" in line
    assert "pip" not in line  # which would build mpi4py too, in tens of gigabytes
    assert not (tmp_path / "results").exists()


def test_without_mpi4py_one_rank_works_and_a_launcher_is_an_error(tiny, monkeypatch, capfd):
    """Several ranks that cannot see each other must not each compute, or write, everything."""
    monkeypatch.setitem(sys.modules, "mpi4py", None)
    monkeypatch.setenv("OMPI_COMM_WORLD_SIZE", "3")
    for rank, n_lines in ((0, 1), (1, 0)):
        monkeypatch.setenv("OMPI_COMM_WORLD_RANK", str(rank))
        assert run_here(tiny, folder=tiny.parent) == 2
        lines = error_lines(capfd.readouterr().err)
        assert ["mpi4py" in line for line in lines] == [True] * n_lines
    monkeypatch.delenv("OMPI_COMM_WORLD_SIZE")
    assert run_here(tiny, folder=tiny.parent) == 0


def test_the_time_left_is_told_where_a_task_has_several_parts(capsys):
    """Linear disks of a pattern are computed 32 together: 32 times too much was told."""
    run = studies.run_of(Config(study="patterns"))
    job = Job(run, Team(), None, None, progress.Progress(run.config))
    job.status, job.expected = np.zeros((5, 96), dtype=np.uint8), 320
    job.begin()
    job.progress.began -= 100.0
    job.progress.shown -= 100.0
    job._collect([(0, slice(0, 32))], 100.0)
    told = "disks: 32 of about 320 (at most 480), about 15 min left\n"
    assert capsys.readouterr().out == told


def test_a_value_of_thousands_of_characters_is_not_echoed(capsys):
    def wrong():
        raise InputError(f"casing.n_bmps{5000 * 'x'}: unknown key; did you mean casing.n_bumps?")

    assert parallel.alone(wrong) == 2
    line = capsys.readouterr().err
    assert line.startswith("hpcrub: error: casing.n_bmpsxxx")
    assert line.endswith("xxx: unknown key; did you mean casing.n_bumps?\n")
    assert len(line) < 1000
