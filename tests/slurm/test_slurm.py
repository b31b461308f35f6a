"""The job scripts on a real Slurm (`make test-slurm`): what they compute is the single run's bits.

Everything is submitted with jobs/slurm/submit, as a user would. Long waits overlap: the jobs of
most tests are submitted first, and then looked at.
"""

import re
import resource
import shutil
import time

import h5py
import numpy as np
import pytest

from hpcrub.studies import open_result
from tests.program import ROOT, TINY, datasets, run
from tests.slurm.cluster import PATH, Cluster

SUBMIT = ROOT / "jobs/slurm/submit"
LAUNCHERS = {"mpirun": "mpirun", "srun": "srun --mpi=pmix"}
# Slurm looks every 30 s: the signal comes after 5 to 35 s; one rank takes as long as two with half
# of the work (that any rank that hears it stops all is tested in `tests.ranks`)
LIMIT = "RANKS=1 TIME=1 STOP_BEFORE=25"
BEGUN = 14  # samples after which a study is stopped: a block of the statistics and more
LONG, MEDIUM = 40.0, 10.0  # [core s]: one rank takes longer than 35 s; long enough to cancel
FINAL = {"COMPLETED", "FAILED", "CANCELLED", "TIMEOUT", "NODE_FAIL", "OUT_OF_MEMORY"}


def study_of(samples, bumps=4):
    text = TINY.replace("samples: 2", f"samples: {samples}").replace("step_s: 2e-5", "step_s: 1e-5")
    return text.replace("step: 1", "step: 5") + f"casing: {{n_bumps: {bumps}}}\n"


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    if not shutil.which("slurmctld", path=PATH):
        pytest.exit("there is no Slurm here, which `make test-slurm` installs", returncode=1)
    cluster = Cluster(tmp_path_factory.mktemp("slurm"))
    try:
        cluster.start()
        yield cluster
    finally:
        cluster.stop()


class Work:
    """A folder with inputs and a site's settings; what is submitted there, and what comes."""

    def __init__(self, cluster, folder, launcher="mpirun", more=""):
        self.cluster, self.folder = cluster, folder
        folder.mkdir(exist_ok=True)
        (folder / "site.sh").write_text(
            f"source {ROOT}/jobs/slurm/site.sh\n"
            f'RANKS=2 MEMORY=500M LAUNCHER="{LAUNCHERS[launcher]}" {more}\n'
        )

    def write(self, samples, name="study", bumps=4, more=""):
        (self.folder / f"{name}.yaml").write_text(study_of(samples, bumps) + more)

    def submit(self, *words):
        """Numbers of the jobs submitted."""
        done = self.cluster.run(SUBMIT, *words, folder=self.folder)
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

    def result(self, name="study"):
        return self.folder / f"results/{name}.h5"

    def wait_for_samples(self, name="study"):
        deadline = time.monotonic() + 300
        while n_done(self.result(name)) < BEGUN:
            assert time.monotonic() < deadline, self.log()
            time.sleep(0.1)


def n_done(path):
    if not path.exists():
        return 0
    with h5py.File(path, "r", locking=False) as file:
        return int(np.count_nonzero(file["samples/status"][()]))


@pytest.fixture(scope="module")
def single(tmp_path_factory):
    """Datasets of studies that one command computes, without Slurm, by (samples, bumps)."""
    folder, known = tmp_path_factory.mktemp("single"), {}

    def compute(*study):
        if study not in known:
            (folder / "study.yaml").write_text(study_of(*study))
            code, out, err = run(2, "study.yaml", "--overwrite", folder=folder)
            assert code == 0, out + err
            known[study] = datasets(folder / "results/study.h5")
        return known[study]

    return compute


@pytest.fixture(scope="module")
def samples_in(single):
    """Number of samples that take so many core seconds, however busy the machine is."""

    def spent(samples):
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        single(samples)
        return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before

    single(1)  # compiles the kernels
    few = spent(2)
    cost = max(spent(66) - few, 0.1) / 128
    return lambda seconds: int(seconds / cost / 2)


@pytest.fixture(scope="module")
def works(cluster, samples_in, tmp_path_factory):
    """Work of most tests, submitted at once: {name: (Work, jobs)}."""
    base = tmp_path_factory.mktemp("work")
    found = {
        "limit": Work(cluster, base / "limit", more=LIMIT),
        "parts": Work(cluster, base / "parts", "srun"),
        "failing": Work(cluster, base / "failing", "srun"),
        "check": Work(cluster, base / "check"),
    }
    found["limit"].write(samples_in(LONG))
    found["parts"].write(7)
    found["parts"].write(7, "sweep", more="runs:\n- {casing.n_bumps: 4}\n- {casing.n_bumps: 3}\n")
    found["failing"].write(7)
    found["failing"].result().parent.mkdir()
    found["failing"].result("study.part-2-of-2").write_text("no HDF5")
    words = {
        "limit": "--parts 1 study.yaml", "parts": "--parts 2 study.yaml sweep.yaml",
        "failing": "--parts 2 study.yaml", "check": "--check",
    }  # fmt: skip
    return {name: (work, work.submit(*words[name].split())) for name, work in found.items()}


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


def test_parts_and_their_merge(works, single):
    """Two inputs, one of two runs, by two parts, a task each; submitted again, they end at once."""
    work, (setup, array, merge) = works["parts"]
    assert work.wait(setup) == ["COMPLETED"], work.log()
    assert "set-up: works on 2 ranks with srun" in work.log("hpcrub-setup-*")
    assert work.wait(array) == ["COMPLETED"] * 4, work.log()
    assert work.wait(merge) == ["COMPLETED"], work.log()
    assert "study.h5: 14 of 14 samples, from 2 files" in work.log("hpcrub-merge-*")
    assert datasets(work.result()) == single(7)
    merged = [p for p in (work.folder / "results").rglob("*n_bumps*.h5") if "part" not in p.name]
    assert len(merged) == 2
    for bumps in (4, 3):
        (path,) = [p for p in merged if f"n_bumps={bumps}" in p.name]
        assert datasets(path) == single(7, bumps)
    assert work.result().with_suffix(".png").exists()
    assert not list(work.folder.glob("check-*"))
    _, array, merge = work.submit("--parts", "2", "study.yaml")
    assert work.wait(merge) == ["COMPLETED"], work.log()
    assert "ranks, into" not in work.log(f"hpcrub-array-{array}_*")  # no rank was started
    assert "files" not in work.log(f"hpcrub-merge-{merge}")  # nothing to merge either


def test_after_a_failed_task_nothing_is_merged(works, single):
    work, (_, array, merge) = works["failing"]
    assert sorted(work.wait(array)) == ["COMPLETED", "FAILED"], work.log()
    assert work.wait(merge) == ["CANCELLED"]
    assert "study.part-2-of-2.h5 as HDF5: " in work.log("hpcrub-array-*_2")
    assert not work.result().exists()
    work.result("study.part-2-of-2").unlink()  # mended, and submitted again
    _, array, merge = work.submit("--parts", "2", "study.yaml")
    assert work.wait(merge) == ["COMPLETED"], work.log()
    assert datasets(work.result()) == single(7)


def test_cancelled_and_submitted_again(cluster, tmp_path, samples_in, single):
    """mpirun does not pass on what its ranks say when it is told to stop itself; that they have
    stopped in good order, the statistics in the file show."""
    samples = samples_in(MEDIUM)
    begun = []
    for launcher in LAUNCHERS:
        work = Work(cluster, tmp_path / launcher, launcher)
        work.write(samples)
        begun.append((work, work.submit("study.yaml")[1]))
    for work, job in begun:
        work.wait_for_samples()
        cluster.ask("scancel", job)
    for work, job in begun:
        assert work.wait(job) == ["CANCELLED"], work.log()
        deadline = time.monotonic() + 40
        while cluster.ask("squeue", "-h", f"--jobs={job}") and time.monotonic() < deadline:
            time.sleep(0.2)  # completing: the ranks close the file
        assert "queued again" not in work.log()
        assert BEGUN <= n_done(work.result()) < 2 * samples
        with open_result(work.result()) as file:
            assert np.isfinite(file.read("statistics/contact/amplification")[:, 0, 0]).all()
    assert "hpcrub: stopped: SIGTERM" in work.log("hpcrub-[0-9]*")
    again = work.submit("study.yaml")[1]
    assert work.wait(again) == ["COMPLETED"], work.log()
    assert "samples are already there" in work.log()
    assert datasets(work.result()) == single(samples)


def test_time_limit_then_queued_again_and_resumed(works, samples_in):
    """A task of an array, which holds up its merge until it has gone on to its end.

    That such a study has the bits of one that was not stopped is in the test before this one.
    """
    work, (_, array, merge) = works["limit"]
    assert work.wait(merge, 900) == ["COMPLETED"], work.log()
    log = work.log("hpcrub-array-*")
    told = work.cluster.ask("scontrol", "--oneliner", "show", "job", array)
    restarts = int(re.search(r"Restarts=(\d+)", told)[1])
    assert restarts >= 1, told
    assert log.count("job: stopped before the time limit; queued again") == restarts, log
    assert "hpcrub: stopped: SIGUSR1 came" in log
    assert "samples are already there" in log
    assert n_done(work.result()) == 2 * samples_in(LONG)


def test_wrong_input_is_told_before_anything_is_queued(cluster, tmp_path):
    work = Work(cluster, tmp_path / "work")
    work.write(3)
    for words, message in (
        (["study.yaml", "--", "--set", "casing.n_bumpz=3"], "did you mean casing.n_bumps?"),
        (["--parts", "4", "study.yaml"], "3 samples cannot be cut into 4 parts"),
        (["--parts", "x", "study.yaml"], "--parts: how many?"),
        (["--nonsense"], "unknown option --nonsense"),
        ([], "no input given"),
    ):
        done = cluster.run(SUBMIT, *words, folder=work.folder)
        assert done.returncode == 2, words
        assert message in done.stderr
        assert "job" not in done.stdout
