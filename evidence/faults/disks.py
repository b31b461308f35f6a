"""Disks that are full, read-only or gone."""

import contextlib
import os
import shutil
import subprocess

from evidence.faults.job import (
    ROOT,
    SMALLER,
    Job,
    Skip,
    carried_on,
    damage,
    judged,
    run,
    undisturbed,
)


@contextlib.contextmanager
def small_disk(folder, size):
    """A file system of its own in a folder."""
    folder.mkdir(parents=True)
    mount = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)]
    if os.geteuid() != 0 or subprocess.run(mount, capture_output=True).returncode != 0:
        raise Skip("needs root, and the right to mount")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


def fill(path):
    """A file that takes all that is left of a disk."""
    with open(path, "wb", buffering=0) as ballast, contextlib.suppress(OSError):
        while True:
            ballast.write(bytes(1024))


def full_while_running(folder):
    """The file has its final size from the start: only the figure fails, which is said."""
    expected, _ = undisturbed()
    with small_disk(folder / "results", "1m") as disk:
        job = Job(folder, "study.yaml", ranks=2)
        job.until(job.result.exists)
        fill(disk / "ballast")
        code = job.wait()
        (disk / "ballast").unlink()
        problem = damage(job.result, expected)
        if not problem and "No space left" not in job.output():
            problem = "does not say that there is no figure"
        trial = judged(job, code, [0], [], problem)
        yield trial._replace(problem=trial.problem or carried_on(job, expected))


FAILING = """\
import os, sys
sys.path.insert(0, ROOT)
from hpcrub import studies
from hpcrub.__main__ import main
from hpcrub.studies.contact import file as contact_file

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
sys.exit(main())
""".replace("ROOT", repr(str(ROOT)))


def write_error(folder):
    """No room while samples are written: one line, no traceback, no crash at the end."""
    folder.mkdir(parents=True)
    (folder / "failing.py").write_text(FAILING)
    job, code = run(folder / "job", "study.yaml", script=folder / "failing.py")
    yield judged(job, code, [1], ["cannot write", "No space left on device"])


@contextlib.contextmanager
def disk_of_blocks(folder):
    """A file system on a disk of its own, which can fail."""
    folder.mkdir(parents=True)
    image = folder.with_suffix(".img")
    with open(image, "wb") as file:
        file.truncate(2**24)
    made = subprocess.run(["mkfs.ext4", "-q", image], capture_output=True)
    mount = ["mount", "-o", "loop", str(image), str(folder)]
    if made.returncode or subprocess.run(mount, capture_output=True).returncode:
        raise Skip("needs root, the right to mount, and ext4")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


def disk_lost(folder):
    """The system gives a disk up while samples are written, as after an error of its blocks."""
    for ranks in (0, 2):
        with disk_of_blocks(folder / f"{ranks}" / "results") as disk:
            job = Job(folder / f"{ranks}", "study.yaml", ranks=ranks)
            job.until_done(1)
            subprocess.run(["mount", "-o", "remount,abort", str(disk)], check=True)
            yield judged(job, job.wait(), [1], ["cannot write", "Read-only file system"])


def removed(folder):
    """The output folder goes while the study runs: said in one line."""
    for ranks in (0, 2):
        job = Job(folder / f"{ranks}", "study.yaml", ranks=ranks)
        job.until_done(1)
        gone = job.result.parent.rename(job.folder / "gone")  # in one step: a log may be written
        shutil.rmtree(gone)
        code = job.wait()
        yield judged(job, code, [1], ["was removed or moved while this job ran"])


def read_only_folder(folder):
    """A disk that is mounted read-only, without and with a file on it."""
    with small_disk(folder / "disk", "2m") as disk:
        log = folder / "log"
        for arguments in ([], ["--resume"]):
            subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
            output = disk / "results" / "study.h5"
            job, code = run(log, "study.yaml", *arguments, "--output", str(output), *SMALLER)
            yield judged(job, code, [2], ["Read-only file system"])
            subprocess.run(["mount", "-o", "remount,rw", str(disk)], check=True)
            run(log, "study.yaml", "--output", str(output), *SMALLER)


def read_only_file(folder):
    """A result file that cannot be written, not even by root."""
    job, _ = run(folder, "study.yaml", *SMALLER)
    if subprocess.run(["chattr", "+i", job.result], capture_output=True).returncode != 0:
        raise Skip("needs root, and a file system with immutable files")
    try:
        for arguments in (["--resume"], ["--overwrite"]):
            job, code = run(folder, "study.yaml", *arguments, *SMALLER)
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
