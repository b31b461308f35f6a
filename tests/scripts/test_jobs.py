"""The job scripts without Slurm and without the program; `make test-slurm` has both."""

import os
import shutil
import signal
import subprocess
import time

import pytest

from tests.program import ROOT

JOBS = ROOT / "jobs" / "slurm"
PROGRAM = """\
#!/bin/bash
echo "$@" >>"$LOG"
case "$*" in
*"hpcrub merge"*) touch "$LOG.merged"; exit ;;
*--status*)
    [ ! -e "$LOG.merged" ] || exit "$MERGED"
    echo "$TOLD"
    exit "$STATUS" ;;
esac
trap 'echo told >>"$LOG"; until [ -e "$LOG.end" ]; do sleep 0.02; done; exit 75' USR1
echo started >>"$LOG"
[ -z "$CODE" ] || exit "$CODE"
for _ in {1..400}; do sleep 0.05; done
"""


@pytest.fixture
def job(tmp_path):
    """Function that starts a job script with words and variables, in place of Slurm."""
    shutil.copytree(JOBS, tmp_path / "jobs/slurm")
    (tmp_path / "site.sh").write_text('source jobs/slurm/site.sh\nLAUNCHER="env PATH=$PATH"\n')
    log = tmp_path / "log"
    log.touch()
    for path, text in (
        (tmp_path / ".venv/bin/python", PROGRAM),
        (tmp_path / "bin/scontrol", '#!/bin/bash\necho scontrol "$@" >>"$LOG"\n'),
    ):
        path.parent.mkdir(parents=True)
        path.write_text(text)
        path.chmod(0o755)
    environment = os.environ | {
        "PATH": f"{tmp_path / 'bin'}:{os.environ['PATH']}",
        "HPCRUB_SITE": str(tmp_path / "site.sh"),
        "SLURM_SUBMIT_DIR": str(tmp_path),
        "SLURM_JOB_ID": "7",
        "LOG": str(log),
        "STATUS": "75",
        "MERGED": "0",  # of --status after a merge
        "TOLD": "results/a.h5: 3 of 8 samples",
        "CODE": "",
    }
    environment.pop("HPCRUB", None)

    def start(script, *words, **variables):
        command = ["bash", f"jobs/slurm/{script}", *words]
        return subprocess.Popen(command, cwd=tmp_path, env=environment | variables), log

    return start


def wait_for(log, text):
    deadline = time.monotonic() + 30
    while text not in log.read_text():
        assert time.monotonic() < deadline, f"no {text!r} in the log: {log.read_text()}"
        time.sleep(0.02)


@pytest.mark.parametrize("code", [0, 1, 2, 75, 138])
def test_a_job_ends_with_the_code_of_the_program(job, code):
    process, log = job("study.sbatch", "a.yaml", "--", "--set", "x=1 2", CODE=str(code))
    assert process.wait(timeout=30) == code
    first, second, started = log.read_text().splitlines()
    assert first.endswith("main.py a.yaml --set x=1 2 --status")
    assert second.endswith("main.py a.yaml --set x=1 2 --resume")
    assert started == "started"


@pytest.mark.parametrize(
    ("variables", "signals", "queued_again"),
    [
        ({}, [signal.SIGUSR1], True),
        ({"SLURM_RESTART_COUNT": "49"}, [signal.SIGUSR1], True),
        ({"SLURM_RESTART_COUNT": "50"}, [signal.SIGUSR1], False),
        ({}, [signal.SIGUSR1, signal.SIGTERM], False),
    ],
    ids=["time limit", "last but one time", "too often", "cancelled meanwhile"],
)
def test_a_job_stopped_before_its_limit_queues_itself_again(job, variables, signals, queued_again):
    process, log = job("study.sbatch", "a.yaml", **variables)
    wait_for(log, "started")
    for number in signals:
        process.send_signal(number)
        wait_for(log, "told")
    log.with_suffix(".end").touch()  # only now may the program end
    assert process.wait(timeout=30) == 75
    assert log.read_text().count("told") == 1
    assert ("scontrol requeue 7" in log.read_text()) == queued_again


def test_what_is_finished_is_not_started(job):
    process, log = job("array.sbatch", "a.yaml", STATUS="0", PARTS="3", SLURM_ARRAY_TASK_ID="2")
    assert process.wait(timeout=30) == 0
    (line,) = log.read_text().splitlines()
    assert line.endswith("main.py a.yaml --part 2/3 --part-by samples --status")


@pytest.mark.parametrize(
    ("task", "words"),
    [(1, "a.yaml --part 1/3"), (3, "a.yaml --part 3/3"), (4, "b c.yaml --part 1/3"), (7, None)],
)
def test_tasks_of_an_array_are_the_parts_of_all_inputs(job, task, words):
    variables = {"PARTS": "3", "PART_BY": "level", "SLURM_ARRAY_TASK_ID": str(task), "CODE": "0"}
    process, log = job("array.sbatch", "a.yaml", "b c.yaml", "--", "--set", "x=1", **variables)
    assert (process.wait(timeout=30) == 0) == (words is not None)
    lines = log.read_text().splitlines()
    assert [line.partition("main.py ")[2] for line in lines[:2]] == (
        [f"{words} --part-by level --set x=1 {end}" for end in ("--status", "--resume")]
        if words
        else []
    )


@pytest.fixture
def parts(tmp_path):
    """Function that makes files of results, named as those of parts."""
    (tmp_path / "results").mkdir()

    def make(*names):
        for name in names:
            (tmp_path / f"results/{name}.h5").touch()

    return make


MERGE = "-m hpcrub merge results/{0}.h5 results/{0}.part-1-of-2.h5 results/{0}.part-2-of-2.h5"


def merge_calls(log):
    """What the merging job has the program do, without the program's folder."""
    lines = [line for line in log.read_text().splitlines() if line != "started"]
    return [line.rpartition("main.py ")[2] for line in lines]


def test_parts_are_merged_and_the_study_ended(job, parts):
    """All runs of an input; parts of another number of parts are not taken."""
    runs = "a", "b"
    parts(*(f"{run}.part-{i}-of-2" for run in runs for i in (1, 2)), "a.part-1-of-3")
    told = "\n".join(f"results/{run}.h5: 3 of 8 samples" for run in runs)
    words = "a.yaml", "--", "--set", "x=1"
    process, log = job("merge.sbatch", *words, PARTS="2", TOLD=told, CODE="0")
    assert process.wait(timeout=30) == 0
    assert merge_calls(log) == [
        "a.yaml --set x=1 --status",
        *(f"{MERGE.format(run)} --overwrite" for run in runs),
        "a.yaml --set x=1 --status",
        "a.yaml --set x=1 --resume",
    ]


def test_what_is_merged_already_is_kept(job, parts):
    parts("a", "a.part-1-of-2", "a.part-2-of-2")
    process, log = job("merge.sbatch", "a.yaml", PARTS="2", CODE="0")
    assert process.wait(timeout=30) == 0
    assert merge_calls(log)[1] == f"{MERGE.format('a')} results/a.h5 --overwrite"


@pytest.mark.parametrize(
    ("variables", "code", "calls"),
    [
        ({"STATUS": "0", "CODE": "0"}, 0, ["--status", "--resume"]),  # complete: nothing to merge
        ({"STATUS": "2"}, 2, ["--status"]),  # wrong input
        ({"MERGED": "75"}, 75, ["--status", "--overwrite", "--status"]),  # parts that lack samples
    ],
)
def test_a_merge_ends_with_the_code_of_the_program(job, parts, variables, code, calls):
    parts("a.part-1-of-2", "a.part-2-of-2")
    process, log = job("merge.sbatch", "a.yaml", "b.yaml", PARTS="2", **variables)
    assert process.wait(timeout=30) == code
    done = [line.split()[-1] for line in merge_calls(log)]
    assert done == calls * (2 if code == 0 else 1)
