"""Inputs that try to harm: outputs that are no place for a result, sizes, bombs and tags."""

import os

import h5py

from evidence.faults.job import SMALLER, Job, judged, run

OUTPUTS = {
    "the device /dev/null": "/dev/null",
    "a device that is full": "/dev/full",
    "a folder": "folder",
    "a FIFO": "fifo",
    "a link to itself": "loop",
    "a name of 300 characters": "n" * 300,
    "a name of 5000 characters": "n" * 5000,
    "a path of 100 folders": "a/" * 499 + "b",
    "a newline": "a\nb.h5",
    "a terminal's control codes": "a\x1b[2Jb.h5",
    "nothing": "",
    "a file in a file": "precious/a.h5",
    "the home page of the kernel": "/proc/self/a.h5",
    "somebody's file": "precious",
    "somebody's file, by ..": "folder/../precious",
    "somebody's file, by a link": "link",
    "somebody's HDF5 file": "foreign.h5",
    "the input itself": "study.yaml",
    "its own figure": "a.png",
    "its own log": "a.runs.jsonl",
}
ALLOWED = ("a path of 100 folders",)


def outputs(folder):
    """--overwrite destroys nothing that is not a result of hpcrub."""
    for number, (name, output) in enumerate(OUTPUTS.items()):
        place = folder / f"{number}"
        precious(place)
        before = contents(place)
        job, code = run(place, "study.yaml", "--overwrite", "--output", output)
        problem = ""
        if name not in ALLOWED and contents(place) != before:
            problem = f"{name}: files changed"
        trial = judged(job, code, [0] if name in ALLOWED else [2], problem=problem)
        yield trial._replace(problem=trial.problem and f"{name}: {trial.problem}")


def precious(folder):
    """A folder with an input and things that must not be harmed."""
    (folder / "folder").mkdir(parents=True)
    os.mkfifo(folder / "fifo")
    (folder / "loop").symlink_to("loop")
    (folder / "precious").write_text("export PATH\n")
    (folder / "link").symlink_to("precious")
    (folder / "study.yaml").write_text("study: casing\n")
    with h5py.File(folder / "foreign.h5", "w") as file:
        file["x"] = 1.0


def contents(folder):
    """Kind and bytes of everything in a folder, the program's output aside."""
    files = [p for p in folder.iterdir() if p.name not in ("out", "err")]
    return {p.name: (p.lstat().st_mode, p.is_file() and p.read_bytes()) for p in files}


SIZES = {
    "10¹² samples": ["mistuning.samples=1000000000000"],
    "10⁶ samples x 10⁵ speeds": [
        "mistuning.samples=1000000",
        "speeds.from_hz=20",
        "speeds.to_hz=119",
        "speeds.step_hz=0.001",
    ],
    "31,000 degrees of freedom": ["disk.n_blades=200", "disk.blade.n_elements=50"],
    "a revolution in 17 minutes": [
        "speeds.from_hz=1e-3",
        "speeds.to_hz=1e-3",
        "steady_state.max_time_s=1e4",
    ],
    "steps of 10⁻³⁰⁰ s": ["time.step_s=1e-300"],
}


def sizes(folder):
    """Refused with disk and memory, before any work."""
    for number, (name, keys) in enumerate(SIZES.items()):
        arguments = [word for key in keys for word in ("--set", key)]
        job, code = run(folder / f"{number}", "study.yaml", *arguments)
        problem = f"{name}: a folder was made" if job.result.parent.exists() else ""
        trial = judged(job, code, [2], ["GB of disk", "GB of memory"], problem)
        yield trial._replace(problem=trial.problem and f"{name}: {trial.problem}")


LAUGHS = "\n".join(
    f"l{n}: &l{n} [{', '.join([f'*l{n - 1}'] * 9 if n else ['ha'] * 9)}]" for n in range(10)
)
TEXTS = {
    "a billion laughs": LAUGHS,
    "a tag that runs a program": "study: !!python/object/apply:os.system ['touch harmed']",
    "a tag of its own": "study: !harm contact",
    "a merge key": "<<: {study: contact}",
    "99,999 brackets": "[" * 99_999,
    "99,999 braces": "{" * 99_999,
    "400 levels": "".join(" " * n + "a:\n" for n in range(400)),
    "a key of 9,999 sections": "sweep:\n- ? " + "a." * 9_999 + "a\n  : 1",
    "a number of 90,000 digits": "casing: {n_bumps: " + "9" * 90_000 + "}",
    "a million characters": "#" * 1_000_000,
    "15,000 keys": "\n".join(f"k{n}: 1" for n in range(15_000)),
    "a sweep of 1000 sweeps": "sweep: [" + ", ".join(["{casing.n_bumps: 3}"] * 1000) + "]",
    "zeros": "\0" * 100,
    "another alphabet's digits": "casing: {n_bumps: ４}",
}


def texts(folder):
    """YAML that would grow, run or never end."""
    for number, (name, text) in enumerate(TEXTS.items()):
        place = folder / f"{number}"
        place.mkdir(parents=True)
        (place / "study.yaml").write_text(text, encoding="utf-8")
        job = Job(place, "study.yaml")
        code = job.wait(30)
        problem = f"{name}: it ran" if (place / "harmed").exists() else ""
        trial = judged(job, code, [2], problem=problem)
        if not trial.problem and len(job.errors()) > 2000:
            trial = trial._replace(problem=f"a message of {len(job.errors())} characters")
        yield trial._replace(problem=trial.problem and f"{name}: {trial.problem}")


def options(folder):
    """The same through --set, and no input at all."""
    deep = "a." * 50_000 + "a=1"
    for arguments in (["--set", deep], ["--set", "study=&a [*a]"], ["--set", "=" * 9999]):
        job, code = run(folder, "study.yaml", *arguments, *SMALLER)
        yield judged(job, code, [2])
    for name in ("/dev/null", "folder", "x" * 5000, "study.yaml/x", "/proc/self/mem"):
        (folder / "folder").mkdir(exist_ok=True)
        job, code = run(folder, name)
        yield judged(job, code, [2])


FAULTS = {
    "outputs that are no place for a result": outputs,
    "absurd sizes": sizes,
    "YAML that would grow, run or never end": texts,
    "options and files that are none": options,
}
