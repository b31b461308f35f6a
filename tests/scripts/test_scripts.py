"""The job scripts without Slurm and without the program (`make test-slurm` has both); what pip
installs is the whole program."""

import os
import shutil
import signal
import subprocess
import sys
import time

import pytest

from tests.program import ROOT

JOBS = ROOT / "jobs" / "slurm"
PROGRAM = """\
#!/bin/bash
echo "$@" >>"$LOG"
case "$*" in
*--status*) exit "$STATUS" ;;
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


@pytest.mark.parametrize("code", [0, 75])
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


@pytest.mark.parametrize(
    ("task", "words"),
    [(1, "a.yaml --part 1/3"), (3, "a.yaml --part 3/3"), (4, "b c.yaml --part 1/3"), (7, None)],
)
def test_tasks_of_an_array_are_the_parts_of_all_inputs(job, task, words):
    variables = {"PARTS": "3", "SLURM_ARRAY_TASK_ID": str(task), "CODE": "0"}
    process, log = job("array.sbatch", "a.yaml", "b c.yaml", "--", "--set", "x=1", **variables)
    assert (process.wait(timeout=30) == 0) == (words is not None)
    lines = log.read_text().splitlines()
    assert [line.partition("main.py ")[2] for line in lines[:2]] == (
        [f"{words} --set x=1 {end}" for end in ("--status", "--resume")] if words else []
    )


@pytest.mark.long
def test_what_pip_installs_runs_without_the_checkout(tmp_path):
    """All packages are in the wheel, and so is the command."""
    for name in ("hpcrub", "pyproject.toml", "README.md"):  # setuptools writes beside its sources
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, tmp_path / name)
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation"]
    pip += ["--disable-pip-version-check", "--no-compile", "--no-index", "--target", "there", "."]
    alone = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    subprocess.run(pip, cwd=tmp_path, env=alone, check=True, capture_output=True)
    there, elsewhere = tmp_path / "there", tmp_path / "elsewhere"
    elsewhere.mkdir()
    alone |= {"PYTHONPATH": str(there)}
    show = "import hpcrub.commands.plot as last, hpcrub.commands.merge; print(last.__file__)"
    for command, begin in (
        ([str(there / "bin" / "hpcrub"), "--version"], "hpcrub "),
        ([sys.executable, "-c", show], str(there)),
    ):
        done = subprocess.run(command, cwd=elsewhere, env=alone, capture_output=True, text=True)
        assert done.stdout.startswith(begin), done.stderr
