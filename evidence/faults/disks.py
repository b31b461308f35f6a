"""Disks that are full, read-only or gone."""

import contextlib
import shutil
import subprocess

from evidence.faults.job import Job, Skip, carried_on, damage, judged, run, script, undisturbed

SMALLER = "--set", "mistuning.samples=2"


@contextlib.contextmanager
def mounted(folder, *words):
    """A file system of its own in a folder, mounted with these words."""
    folder.mkdir(parents=True)
    if subprocess.run(["mount", *words, folder], capture_output=True).returncode != 0:
        raise Skip("needs root, the right to mount, and ext4")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", folder], check=True)


def small_disk(folder, size):
    """One of so many bytes."""
    return mounted(folder, "-t", "tmpfs", "-o", f"size={size}", "tmpfs")


def full_while_running(folder):
    """The file has its final size from the start: only the figure fails, which is said."""
    expected, _ = undisturbed()
    with small_disk(folder / "results", "1m") as disk:
        job = Job(folder, "study.yaml", ranks=2)
        job.until(job.result.exists)
        with open(disk / "ballast", "wb", buffering=0) as ballast, contextlib.suppress(OSError):
            while True:
                ballast.write(bytes(1024))
        code = job.wait()
        (disk / "ballast").unlink()
        problem = damage(job.result, expected)
        if not problem and "No space left" not in job.output():
            problem = "does not say that there is no figure"
        trial = judged(job, code, [0], [], problem)
        yield trial._replace(problem=trial.problem or carried_on(job, expected, 0))


FAILING = """\
import os
from hpcrub.studies.contact import layout as contact_file

write, n_written = contact_file.write_sample, 0

def failing(file, *arguments):
    # from the second sample on, the descriptor is one of a disk without room
    global n_written
    n_written += 1
    if n_written == 2:
        for number in os.listdir("/proc/self/fd"):
            if os.path.realpath(f"/proc/self/fd/{number}").endswith(".h5"):
                os.dup2(os.open("/dev/full", os.O_RDWR), int(number))
    write(file, *arguments)

contact_file.write_sample = failing
"""


def write_error(folder):
    """No room while samples are written: one line, no traceback, no crash at the end."""
    job, code = run(folder / "job", "study.yaml", script=script(folder, FAILING))
    yield judged(job, code, [1], ["cannot write", "No space left on device"])


def disk_lost(folder):
    """The system gives a disk up while samples are written, as after an error of its blocks."""
    for ranks in (0, 2):
        place = folder / f"{ranks}"
        place.mkdir(parents=True)
        image = place / "results.img"  # of a disk of its own, which can fail
        with open(image, "wb") as file:
            file.truncate(2**24)
        subprocess.run(["mkfs.ext4", "-q", image], capture_output=True)
        with mounted(place / "results", "-o", "loop", image) as disk:
            job = Job(place, "study.yaml", ranks=ranks)
            job.until_done(1)
            subprocess.run(["mount", "-o", "remount,abort", disk], check=True)
            yield judged(job, job.wait(), [1], ["cannot write", "Read-only file system"])


def removed(folder):
    """The output folder goes while the study runs: said in one line."""
    for ranks in (0, 2):
        job = Job(folder / f"{ranks}", "study.yaml", ranks=ranks)
        job.until_done(1)
        gone = job.result.parent.rename(job.folder / "gone")  # in one step: a log may be written
        shutil.rmtree(gone)
        yield judged(job, job.wait(), [1], ["was removed or moved while this job ran"])


def read_only_folder(folder):
    """A disk that is mounted read-only, without and with a file on it."""
    with small_disk(folder / "disk", "2m") as disk:
        to = "--output", f"{disk}/results/study.h5", *SMALLER
        for arguments in ([], ["--resume"]):
            subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
            job, code = run(folder / "log", "study.yaml", *arguments, *to)
            yield judged(job, code, [2], ["Read-only file system"])
            subprocess.run(["mount", "-o", "remount,rw", disk], check=True)
            run(folder / "log", "study.yaml", *to)


def read_only_file(folder):
    """A result file that cannot be written, not even by root."""
    job, _ = run(folder, "study.yaml", *SMALLER)
    if subprocess.run(["chattr", "+i", job.result], capture_output=True).returncode != 0:
        raise Skip("needs root, and a file system with immutable files")
    try:
        for argument in ("--resume", "--overwrite"):
            job, code = run(folder, "study.yaml", argument, *SMALLER)
            yield judged(job, code, [2], ["Operation not permitted"])
    finally:
        subprocess.run(["chattr", "-i", job.result], check=True)


FAULTS = {
    "disk full while running": full_while_running,
    "disk without room while samples are written": write_error,
    "disk lost while samples are written": disk_lost,
    "output folder removed while running": removed,
    "disk mounted read-only": read_only_folder,
    "result file read-only": read_only_file,
}
