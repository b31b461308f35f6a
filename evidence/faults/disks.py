"""Disks that are full, limited, read-only or gone, and files that are not what they should be."""

import contextlib
import os
import resource
import shutil
import subprocess

import h5py

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


def too_small(folder):
    """Found before any work."""
    with small_disk(folder / "disk", "48k") as disk:
        job, code = run(disk, "study.yaml")
        left = [p.name for p in (disk / "results").glob("*")]
        problem = f"left behind: {left}" if left else ""
        yield judged(job, code, [2], ["not enough disk", "GB of memory"], problem)


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


def quota(folder):
    """EFBIG while the file is laid out. A real quota (EDQUOT) needs a file system that has them;
    to hpcrub both are an OSError of the same call."""
    folder.mkdir(parents=True)
    limited = folder / "limited.py"
    limited.write_text(
        "import resource, sys\n"
        f"sys.path.insert(0, {str(ROOT)!r})\n"
        "from hpcrub.__main__ import main\n"
        "from hpcrub.results import storage\n"
        f"resource.setrlimit(resource.RLIMIT_FSIZE, (20000, {resource.RLIM_INFINITY}))\n"
        "sys.exit(main())\n"
    )
    job, code = run(folder, "study.yaml", script=limited)
    left = [p.name for p in (folder / "results").glob("*")]
    yield judged(
        job, code, [2], ["cannot write", "File too large"], f"left behind: {left}" if left else ""
    )


def log_full(folder):
    """The log has no place: the study goes on without."""
    expected, _ = undisturbed()
    full = folder / "full.py"
    folder.mkdir(parents=True)
    full.write_text(
        "import os, sys\n"
        f"sys.path.insert(0, {str(ROOT)!r})\n"
        "os.dup2(os.open('/dev/full', os.O_WRONLY), 1)\n"
        "from hpcrub.__main__ import main\n"
        "sys.exit(main())\n"
    )
    job, code = run(folder, "study.yaml", script=full)
    yield judged(job, code, [0], ["on without it"], damage(job.result, expected))


FAILING = """\
import os, sys
sys.path.insert(0, ROOT)
from hpcrub.__main__ import main
from hpcrub.results import contact_file

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


def spoilt_file(folder, spoil, words, *arguments):
    """A file that `spoil` has changed is refused by --resume and stays as it is."""
    job, _ = run(folder, "study.yaml", *SMALLER)
    spoil(job.result)
    before = job.result.read_bytes()
    for ranks in (0, 2):
        job, code = run(folder, "study.yaml", "--resume", *SMALLER, *arguments, ranks=ranks)
        problem = "" if job.result.read_bytes() == before else "the file was changed"
        yield judged(job, code, [2], words, problem)


def truncated(folder):
    """As by a copy that was interrupted."""

    def spoil(path):
        os.truncate(path, path.stat().st_size - 5000)

    yield from spoilt_file(folder, spoil, ["is truncated"])


def other_layout(folder):
    """Of a later program."""

    def spoil(path):
        with h5py.File(path, "r+", locking=False) as file:
            file.attrs["layout"] = 99

    yield from spoilt_file(folder, spoil, ["has layout 99"])


def other_configuration(folder):
    """The differing key is named."""
    words = ["casing.n_bumps: 4 in the file, 3 asked for"]
    yield from spoilt_file(folder, lambda path: None, words, "--set", "casing.n_bumps=3")


def changed_file(folder):
    """Somebody has added an attribute and a dataset: the study goes on."""
    job, _ = run(folder, "study.yaml", *SMALLER)
    with h5py.File(job.result, "r+", locking=False) as file:
        file.attrs["note"] = "mine"
        file["samples/mine"] = [1.0, 2.0]
    for ranks in (0, 2):
        job, code = run(folder, "study.yaml", "--resume", *SMALLER, ranks=ranks)
        yield judged(job, code, [0])


def two_jobs(folder):
    """The second job on a file says so and leaves it alone."""
    expected, _ = undisturbed()
    first = Job(folder / "first", "study.yaml", ranks=2)
    first.until(first.result.exists)
    for arguments in (["--resume"], ["--overwrite"]):
        name = folder / arguments[0]
        job, code = run(name, "study.yaml", *arguments, "--output", str(first.result))
        yield judged(job, code, [2], ["is in use by another job"])
    code = first.wait()
    yield judged(first, code, [0], problem=damage(first.result, expected))


FAULTS = {
    "disk too small": too_small,
    "disk full while running": full_while_running,
    "limit of a file's size (RLIMIT_FSIZE; as a quota would) while the file is laid out": quota,
    "disk without room while samples are written": write_error,
    "disk lost while samples are written": disk_lost,
    "no place for the log": log_full,
    "output folder removed while running": removed,
    "disk mounted read-only": read_only_folder,
    "result file read-only": read_only_file,
    "file truncated": truncated,
    "file of another layout": other_layout,
    "file of another configuration": other_configuration,
    "file changed by another program": changed_file,
    "two jobs on one file": two_jobs,
}
