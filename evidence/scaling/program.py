"""The program itself on the ranks that are at hand: messages, whole studies, writing."""

import json
import os
import pickle
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from evidence.scaling import simulate
from tests.program import ENVIRONMENT, ROOT

SAMPLES = 10  # of each level, in whole studies
SLEPT, NAP = 160, 3e-3  # samples of ranks that sleep, and [s] from one of their polls to the next
STUDY = """\
speeds: {{from_hz: 33.5, to_hz: 35.5, step_hz: 0.05}}
mistuning: {{samples: {samples}}}
"""

# tasks that cost nothing: what is left is rank 0's work for each of them
MESSAGES = """\
import sys, time
from hpcrub.results import contact_file
from hpcrub.ranks import parallel, schedule

schedule.SERVES_ONLY = 0
N = 4000
RESULT = 1, 1.5, 1.5, 10**6, 0.3, 1e-3, ""

def program(team):
    start = time.process_time()
    team.run_tasks([(0, i) for i in range(N)], lambda task, poll: RESULT)
    if team.rank == 0:
        print((time.process_time() - start) / N)
    return 0

sys.exit(parallel.run(program))
"""

# the real dispatcher with ranks that sleep instead of computing, so that none lacks a core
SLEEPING = """\
import pickle, sys, time
from hpcrub.ranks import parallel, schedule
from evidence.scaling.simulate import TUNED_RUNS

costs, n_samples, nap = pickle.load(open(sys.argv[1], "rb"))
most = max(costs.parts[0])

def program(team):
    cut = schedule.n_parts(TUNED_RUNS, team.size, most)
    tuned = [schedule.Tuned(run, part, cut) for run in range(TUNED_RUNS) for part in range(cut)]
    samples = ((0, number) for number in range(n_samples))
    tasks = schedule.StudyTasks(tuned, samples, n_samples, most)
    left, parts = [len(tuned)], {}

    def compute(task, poll):
        tuned = isinstance(task, schedule.Tuned)
        number = (task.run if tuned else task.sample) % len(costs.whole)
        seconds = costs.whole[number] if task.n_parts == 1 else (
            costs.parts[number][task.n_parts][task.part])
        until = time.perf_counter() + seconds * (tuned or not task.response)
        while time.perf_counter() < until:
            time.sleep(min(nap, max(0.0, until - time.perf_counter())))
            poll()
        while not tuned and task.n_parts == 1 and not poll():
            time.sleep(parallel.PAUSE)

    def collect(task, result):
        if isinstance(task, schedule.Tuned):
            left[0] -= 1
            if not left[0]:
                team.share(True)
        elif task.n_parts > 1:
            parts[task.sample] = parts.get(task.sample, 0) + 1
            if parts[task.sample] == task.n_parts:
                tasks.urgent.appendleft(task._replace(part=0, n_parts=1, response=(0,)))

    team.barrier()
    start = time.perf_counter()
    team.run_tasks(tasks, compute, collect)
    if team.rank == 0:
        print(time.perf_counter() - start)
    return 0

sys.exit(parallel.run(program))
"""

# rows of a sample, written by every rank at its own time, or by all ranks together
WRITING = """\
import sys, time
import h5py, numpy as np
from mpi4py import MPI
from hpcrub.results import contact_file
from hpcrub.results.layout import SAMPLE
from hpcrub.results.storage import ResultFile
from hpcrub.studies.files import lay_out
from evidence.scaling import costs

comm, collective, n = MPI.COMM_WORLD, sys.argv[1] == "collective", 100
config = costs.configuration(4, samples=n * comm.size)
if comm.rank == 0:
    lay_out(sys.argv[2], config)
comm.barrier()
file = ResultFile(sys.argv[2], comm, "r+")
values = {}
for name in SAMPLE:
    if f"samples/{name}" in file._datasets:
        values[name] = np.ones(file._datasets[f"samples/{name}"].shape[2:])
comm.barrier()
start = time.perf_counter()
for i in range(n):
    at = 0, i * comm.size + comm.rank
    if not collective:
        contact_file.write_sample(file, *at, values)
        continue
    for name, value in values.items():
        dataset = file._datasets[f"samples/{name}"]
        with dataset.collective:
            dataset[at] = value
seconds = (time.perf_counter() - start) / n
if comm.rank == 0:
    print(seconds)
file.close()
"""


def _mpi(n_ranks, script, *arguments, folder):
    path = Path(folder) / "script.py"
    path.write_text(script)
    command = ["mpirun", "-n", str(n_ranks), sys.executable, str(path), *map(str, arguments)]
    run = subprocess.run(command, check=True, capture_output=True, text=True, cwd=folder,
                         env=os.environ | ENVIRONMENT)  # fmt: skip
    return float(run.stdout.split()[-1])


def messages():
    """Seconds of rank 0 for one task: a message with its result, and one with the next task."""
    with tempfile.TemporaryDirectory() as folder:
        return _mpi(3, MESSAGES, folder=folder)


def sleeping(costs, all_ranks=(2, 4, 8, 16, 32), n_samples=SLEPT):
    """{ranks: seconds} of the real dispatcher, for ranks that sleep."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "costs.pickle"
        path.write_bytes(pickle.dumps((costs, n_samples, NAP)))
        for n_ranks in all_ranks:
            found[n_ranks] = _mpi(n_ranks, SLEEPING, path, folder=folder)
    return found


def slept(costs, machine, n_ranks, n_samples=SLEPT):
    """Seconds of the same in the simulation, with the same disks in the same order."""
    like, machine = costs._replace(polls=np.full(4, NAP)), machine._replace(finish=0.0)
    return simulate.study(like, machine, n_ranks, n_samples, drawn=False).seconds


def whole_studies(costs, machine, all_ranks=(1, 2, 4, 8)):
    """{ranks: (run log's summary, simulated seconds of the tuned disk and samples)}.

    The simulated ranks share this machine's cores; their speed is that of the run on one rank.
    """
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "study.yaml"
        path.write_text(STUDY.format(samples=SAMPLES))
        for n_ranks in all_ranks:
            command = ["mpirun", "-n", str(n_ranks), sys.executable, str(ROOT / "main.py")]
            command += [path.name, "--overwrite", "--no-figures"]
            subprocess.run(command, check=True, capture_output=True, cwd=folder,
                           env=os.environ | ENVIRONMENT)  # fmt: skip
            (log,) = Path(folder).rglob("*.runs.jsonl")
            summary = json.loads(log.read_text().splitlines()[-1])
            found[n_ranks] = [summary, n_ranks]
    one = integrating(found[1][0])
    speed = one / simulate.study(costs, machine, 1, 4 * SAMPLES).seconds
    for n_ranks in all_ranks:
        slow = speed * max(1.0, n_ranks / os.cpu_count())
        told = simulate.study(costs, machine._replace(slowdown=slow), n_ranks, 4 * SAMPLES)
        found[n_ranks][1] = told.seconds
    return found


def integrating(summary):
    """Seconds of the tuned disk and the samples in a run log's summary."""
    return sum(summary["phases"].get(name, 0.0) for name in ("tuned disk", "samples"))


def writing():
    """{(ranks, how): seconds to write one sample on every rank}, best of two."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for n_ranks in (2, 4):
            for how in ("independent", "collective") * 2:
                path = Path(folder) / f"{n_ranks}{how}.h5"
                path.unlink(missing_ok=True)
                seconds = _mpi(n_ranks, WRITING, how, path, folder=folder)
                found[n_ranks, how] = min(seconds, found.get((n_ranks, how), np.inf))
    return found
