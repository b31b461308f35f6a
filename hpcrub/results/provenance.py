"""Identity of the program that computes a result: its text, its version, its libraries."""

import contextlib
import hashlib
import importlib.metadata
import subprocess
from functools import cache
from pathlib import Path

from hpcrub import __version__

SHOWING = "plot", "commands"  # rooms whose text cannot change a number; that of any other room may
LIBRARIES = "numpy", "scipy", "numba", "h5py", "mpi4py"
PACKAGE = Path(__file__).resolve().parents[1]


@cache
def program_text() -> str:
    """Return the checksum of the sources of all rooms but `SHOWING`, 16 hexadecimal digits.

    Two programs with the same checksum compute the same numbers.
    """
    digest = hashlib.sha256()
    for source in sorted(PACKAGE.glob("*/**/*.py")):
        if (name := source.relative_to(PACKAGE)).parts[0] not in SHOWING:
            digest.update(f"{name}\n".encode())
            digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def origin() -> dict[str, str]:
    """Return attributes: text, version and known revision of the program; versions of libraries."""
    versions = {"program_text": program_text(), "program_version": __version__}
    if revision := git_revision():
        versions["git_revision"] = revision
    for library in LIBRARIES:
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            versions[f"{library}_version"] = importlib.metadata.version(library)
    return versions


@cache
def git_revision() -> str | None:
    """Return the commit of a checkout, with -dirty for changed files; None if it is not known."""
    folder = PACKAGE.parent
    if not (folder / ".git").exists():
        return None
    command = ["git", "-C", str(folder), "describe", "--always", "--dirty", "--abbrev=40"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=10, check=True)
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()
