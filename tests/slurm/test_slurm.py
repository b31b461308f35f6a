"""The job scripts on a real Slurm (`make test-slurm`): what they compute is the single run's bits.

Everything is submitted with jobs/slurm/submit, as a user would. Long waits overlap: the jobs of
most tests are submitted first, and then looked at.
"""

import os
import re
import resource
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest

from tests.program import ROOT
from tests.slurm.cluster import Cluster, install

SUBMIT = ROOT / "jobs/slurm/submit"
STUDY = """\
output: results/{name}.h5
speeds: {{from_hz: 34.0, to_hz: 34.4, step_hz: 0.2}}
reduction: {{n_modes: 12}}
time: {{step_s: 1e-5}}
steady_state: {{first_check_s: 0.2, max_time_s: 0.5}}
casing: {{n_bumps: {bumps}}}
mistuning: {{half_range_percent: [2, 4], samples: {samples}}}
convergence: {{step: 5}}
"""
LAUNCHERS = {"mpirun": "mpirun", "srun": "srun --mpi=pmix"}
LIMIT = "TIME=1 STOP_BEFORE=25"  # Slurm looks every 30 s: the signal comes after 5 to 35 s
BEGUN = 14  # samples after which a study is stopped: a block of the statistics and more
LONG, MEDIUM = 75.0, 16.0  # [core s]: two ranks take longer than 35 s; long enough to cancel
FINAL = {"COMPLETED", "FAILED", "CANCELLED", "TIMEOUT", "NODE_FAIL", "OUT_OF_MEMORY"}
ENVIRONMENT = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
    "PYTHONPATH": str(ROOT),  # for python -m hpcrub merge, wherever the package is installed
}


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    try:
        install()
    except RuntimeError as error:
        pytest.exit(f"make test-slurm: {error}", returncode=1)
    os.environ.update(ENVIRONMENT)
    cluster = Cluster(tmp_path_factory.mktemp("slurm"))
    try:
        cluster.start()
        yield cluster
    finally:
        cluster.stop()


class Work:
    """A folder with inputs and a site's settings; what is submitted there, and what comes."""

    def __init__(self, cluster, folder):
        self.cluster, self.folder = cluster, folder
        folder.mkdir(exist_ok=True)

    def write(self, name, samples, bumps=4):
        (self.folder / f"{name}.yaml").write_text(
            STUDY.format(name=name, samples=samples, bumps=bumps)
        )

    def site(self, launcher="mpirun", more=""):
        (self.folder / "site.sh").write_text(
            f"source {ROOT}/jobs/slurm/site.sh\n"
            f'RANKS=2 MEMORY=500M LAUNCHER="{LAUNCHERS[launcher]}" {more}\n'
        )

    def submit(self, *words):
        """Numbers of the jobs submitted."""
        done = self.cluster.run(
            SUBMIT, *words, folder=self.folder, HPCRUB_SITE=str(self.folder / "site.sh")
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return re.findall(r"job (\d+)", done.stdout)

    def wait(self, job, timeout=600):
        """Final states of a job, or of all tasks of an array."""
        deadline = time.monotonic() + timeout
        while time.monotonic() < deadline:
            told = self.cluster.ask("scontrol", "--oneliner", "show", "job", job)
            states = re.findall(r"JobState=(\S+)", told)
            if states and set(states) <= FINAL:
                return states
            time.sleep(0.5)
        pytest.fail(f"job {job} is not over:\n{told}\n{self.log()}")

    def log(self, pattern="*"):
        """All output of the jobs whose log has such a name."""
        logs = sorted((self.folder / "logs").glob(f"{pattern}.out"))
        return "\n".join(f"== {path.name}\n{path.read_text()}" for path in logs)

    def datasets(self, name):
        return datasets(self.folder / f"results/{name}.h5")


def datasets(path):
    found = {}
    with h5py.File(path, "r", locking=False) as file:
        file.visititems(
            lambda name, item: (
                found.update({name: item[()].tobytes()}) if isinstance(item, h5py.Dataset) else None
            )
        )
    return found


def n_done(path):
    if not path.exists():
        return 0
    with h5py.File(path, "r", locking=False) as file:
        return int(np.count_nonzero(file["samples/status"][()]))


@pytest.fixture(scope="module")
def single(tmp_path_factory):
    """Datasets of studies that one command computes, without Slurm, by (samples, bumps)."""
    folder, known = tmp_path_factory.mktemp("single"), {}

    def compute(samples, bumps=4):
        if (samples, bumps) not in known:
            name = f"single-{samples}-{bumps}"
            (folder / f"{name}.yaml").write_text(
                STUDY.format(name=name, samples=samples, bumps=bumps)
            )
            command = ["mpirun", "-n", "2", sys.executable, ROOT / "main.py", f"{name}.yaml"]
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stdout + done.stderr
            known[samples, bumps] = datasets(folder / f"results/{name}.h5")
        return known[samples, bumps]

    return compute


@pytest.fixture(scope="module")
def cost(single):
    """Core seconds of a sample, however busy the machine is."""

    def spent(samples):
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        single(samples)
        return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before

    single(1)  # compiles the kernels
    few = spent(2)
    return max(spent(66) - few, 0.1) / 128


@pytest.fixture(scope="module")
def works(cluster, cost, tmp_path_factory):
    """Work of most tests, submitted at once: {name: (Work, jobs)}."""
    base = tmp_path_factory.mktemp("work")
    found = {}
    work = Work(cluster, base / "limit")
    work.write("long", int(LONG / cost / 2))
    work.site("mpirun", LIMIT)
    found["limit"] = work, work.submit("long.yaml")
    work = Work(cluster, base / "parts")
    work.write("study", 11)
    work.site("mpirun")
    found["parts"] = work, work.submit("--parts", "3", "study.yaml")
    work = Work(cluster, base / "cases")
    work.write("nd4", 7)
    work.write("nd3", 7, bumps=3)
    work.site("srun")
    words = "--parts", "2", "nd4.yaml", "nd3.yaml"
    found["cases"] = work, work.submit(*words)
    work = Work(cluster, base / "failing")
    work.write("study", 11)
    work.site("srun")
    (work.folder / "results").mkdir()
    (work.folder / "results/study.part-2-of-3.h5").write_text("no HDF5")
    found["failing"] = work, work.submit("--parts", "3", "study.yaml")
    work = Work(cluster, base / "check")
    work.site("mpirun")
    found["check"] = work, work.submit("--check")
    work = Work(cluster, base / "sweep")
    work.write("study", 7)
    with open(work.folder / "study.yaml", "a", encoding="utf-8") as file:
        file.write("runs:\n- {casing.n_bumps: 4}\n- {casing.n_bumps: 3}\n")
    work.site("mpirun")
    found["sweep"] = work, work.submit("--parts", "2", "study.yaml")
    return found


def test_check_answers(works):
    work, jobs = works["check"]
    assert work.wait(*jobs) == ["COMPLETED"], work.log()
    assert work.log().splitlines()[-1].startswith("set-up: works on 2 ranks with mpirun")
    assert [path.name for path in work.folder.iterdir() if path.name != "site.sh"] == ["logs"]


def test_a_rank_has_a_core_of_two_hyper_threads(works):
    work, (setup, array, _) = works["parts"]
    for job in (setup, array):
        told = work.cluster.ask("scontrol", "--oneliner", "show", "job", job)
        assert set(re.findall(r"NumCPUs=(\d+)", told)) == {"4"}, told  # of two ranks


def test_a_sweep_in_an_array(works, single):
    """Each task computes its part of both runs; every run gets its merged file."""
    work, (_, array, merge) = works["sweep"]
    assert work.wait(array) == ["COMPLETED"] * 2, work.log()
    assert work.wait(merge) == ["COMPLETED"], work.log()
    merged = [p for p in (work.folder / "results").rglob("*.h5") if "part" not in p.name]
    assert len(merged) == 2
    for bumps in (4, 3):
        (path,) = [p for p in merged if f"n_bumps={bumps}" in p.name]
        assert datasets(path) == single(7, bumps)


def test_parts_and_their_merge(works, single):
    work, (setup, array, merge) = works["parts"]
    assert work.wait(setup) == ["COMPLETED"], work.log()
    assert "set-up: works on 2 ranks with mpirun" in work.log("hpcrub-setup-*")
    assert work.wait(array) == ["COMPLETED"] * 3, work.log()
    assert work.wait(merge) == ["COMPLETED"], work.log()
    assert "study.h5: 22 of 22 samples, from 3 files" in work.log("hpcrub-merge-*")
    assert work.datasets("study") == single(11)
    assert (work.folder / "results/study.png").exists()
    assert not list(work.folder.glob("check-*"))


def test_finished_tasks_end_at_once(works, single):
    work, _ = works["parts"]
    _, array, merge = work.submit("--parts", "3", "study.yaml")
    assert work.wait(array) == ["COMPLETED"] * 3, work.log()
    log = work.log(f"hpcrub-array-{array}_*")
    assert log.count("samples\n") == 3
    assert "ranks, into" not in log  # no rank was started
    assert work.wait(merge) == ["COMPLETED"], work.log()
    assert "files" not in work.log(f"hpcrub-merge-{merge}")  # nothing to merge either
    assert work.datasets("study") == single(11)


def test_cases_on_srun(works, single):
    """Two values of n_d by two levels, a task each, and a merged file for each n_d."""
    work, (_, array, merge) = works["cases"]
    assert work.wait(array) == ["COMPLETED"] * 4, work.log()
    assert work.wait(merge) == ["COMPLETED"], work.log()
    assert work.datasets("nd4") == single(7)
    assert work.datasets("nd3") == single(7, bumps=3)


def test_after_a_failed_task_nothing_is_merged(works, single):
    work, (_, array, merge) = works["failing"]
    assert sorted(work.wait(array)) == ["COMPLETED", "COMPLETED", "FAILED"], work.log()
    assert work.wait(merge) == ["CANCELLED"]
    assert "study.part-2-of-3.h5 is not an HDF5 file" in work.log("hpcrub-array-*_2")
    assert not (work.folder / "results/study.h5").exists()
    (work.folder / "results/study.part-2-of-3.h5").unlink()  # mended, and submitted again
    _, array, merge = work.submit("--parts", "3", "study.yaml")
    assert work.wait(merge) == ["COMPLETED"], work.log()
    assert work.datasets("study") == single(11)


def wait_for_samples(work, name="study"):
    deadline = time.monotonic() + 300
    path = work.folder / f"results/{name}.h5"
    while n_done(path) < BEGUN:
        if time.monotonic() > deadline:
            pytest.fail(f"{n_done(path)} samples in {path}, not {BEGUN}:\n{work.log()}")
        time.sleep(0.1)


def test_cancelled_and_submitted_again(cluster, tmp_path, cost, single):
    """mpirun does not pass on what its ranks say when it is told to stop itself; that they have
    stopped in good order, the statistics in the file show."""
    samples = int(MEDIUM / cost / 2)
    begun = []
    for launcher in LAUNCHERS:
        work = Work(cluster, tmp_path / launcher)
        work.write("study", samples)
        work.site(launcher)
        begun.append((work, work.submit("study.yaml")[1]))
    for work, job in begun:
        wait_for_samples(work)
        cluster.ask("scancel", job)
    for work, job in begun:
        assert work.wait(job) == ["CANCELLED"], work.log()
        deadline = time.monotonic() + 40
        while cluster.ask("squeue", "-h", f"--jobs={job}") and time.monotonic() < deadline:
            time.sleep(0.2)  # completing: the ranks close the file
        assert "queued again" not in work.log()
        path = work.folder / "results/study.h5"
        assert BEGUN <= n_done(path) < 2 * samples
        with h5py.File(path, "r", locking=False) as file:
            assert np.isfinite(file["statistics/contact/percentile"][:, 0, 0]).all()
    assert "hpcrub: stopped: SIGTERM" in work.log("hpcrub-[0-9]*")
    again = [(work, work.submit("study.yaml")[1]) for work, _ in begun]
    for work, job in again:
        assert work.wait(job) == ["COMPLETED"], work.log()
        assert "samples are already there" in work.log()
        assert work.datasets("study") == single(samples)


def test_a_task_that_queues_itself_again_holds_up_the_merge(cluster, tmp_path, cost, single):
    """With the signal that Slurm sends before the time limit, but not at the limit."""
    samples = int(MEDIUM / cost / 2)
    work = Work(cluster, tmp_path / "work")
    work.write("study", samples)
    work.site("srun")
    _, array, merge = work.submit("--parts", "2", "study.yaml")
    wait_for_samples(work, "study.part-1-of-2")
    cluster.ask("scancel", "--signal=USR1", "--batch", f"{array}_1")
    assert work.wait(merge) == ["COMPLETED"], work.log()
    log = work.log(f"hpcrub-array-{array}_1")
    assert log.count("hpcrub: stopped: SIGUSR1 came") == 1
    assert log.count("queued again") == 1
    assert "samples are already there" in log
    assert "from 2 files" in work.log("hpcrub-merge-*")
    assert work.datasets("study") == single(samples)


def test_time_limit_then_queued_again_and_resumed(works, cost, single):
    work, (_, job) = works["limit"]
    assert work.wait(job, 900) == ["COMPLETED"], work.log()
    log = work.log("hpcrub-[0-9]*")
    told = work.cluster.ask("scontrol", "--oneliner", "show", "job", job)
    restarts = int(re.search(r"Restarts=(\d+)", told)[1])
    assert restarts >= 1, told
    assert log.count("job: stopped before the time limit; queued again") == restarts, log
    assert "hpcrub: stopped: SIGUSR1 came" in log
    assert "samples are already there" in log
    assert work.datasets("long") == single(int(LONG / cost / 2))


def test_wrong_input_is_told_before_anything_is_queued(cluster, tmp_path):
    work = Work(cluster, tmp_path / "work")
    work.write("study", 3)
    work.site()
    for words, message in (
        (["study.yaml", "--", "--set", "casing.n_bumpz=3"], "did you mean casing.n_bumps?"),
        (["--parts", "4", "study.yaml"], "3 samples cannot be cut into 4 parts"),
        (["--parts", "x", "study.yaml"], "--parts: how many?"),
        (["--nonsense"], "unknown option --nonsense"),
        ([], "no input given"),
    ):
        done = cluster.run(SUBMIT, *words, folder=work.folder, HPCRUB_SITE="site.sh")
        assert done.returncode == 2, words
        assert message in done.stderr
        assert "job" not in done.stdout
