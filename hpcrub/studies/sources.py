"""The contact study from whose result file another study starts."""

import hashlib
from pathlib import Path

import numpy as np

from hpcrub.config.schema import Config, differences
from hpcrub.errors import InputError
from hpcrub.results.layout import DONE, PENDING
from hpcrub.results.storage import ResultFile
from hpcrub.studies import contact

PHYSICS = (
    *("disk", "material", "reduction", "casing", "contact", "forcing"),
    *("speeds", "time", "steady_state"),
)
USED = (
    "sigma",
    "tuned/reference_amplitude_m",
    "samples/status",
    "samples/deviation",
    "samples/amplification",
    "samples/linear_amplification",
)


def amplifications(path: str | Path) -> list[np.ndarray]:
    """A_nl and A_lin of every sample of a contact study, (V, n) each [-], NaN where not done.

    Raises InputError for a file that is not a complete contact study.
    """
    file = complete(path)
    done = file.status() == DONE
    names = "samples/amplification", "samples/linear_amplification"
    values = [np.where(done, file.read(name), np.nan) for name in names]
    file.close()
    return values


def fingerprint(path: str | Path) -> str:
    """Checksum of all that a study may have from a contact study, in hexadecimal digits.

    Raises InputError as `complete`.
    """
    file = complete(path)
    digest = hashlib.sha256(str(file.config.damping).encode())
    for name in USED:
        digest.update(np.ascontiguousarray(file.read(name)).tobytes())
    file.close()
    return digest.hexdigest()


def complete(path: str | Path, config: Config | None = None) -> ResultFile:
    """The open file of a complete contact study, with the same physics as `config` when given.

    Raises InputError, naming what is wrong with it.
    """
    file = ResultFile(path)
    try:
        _check(file, config)
    except BaseException:
        file.close()
        raise
    return file


def _check(file, config):
    path = file.path
    if file.config.study != contact.STUDY.name:
        raise InputError(f"sources: {path} is of the study {file.config.study}, not contact")
    contact.STUDY.check_file(file)
    if file.config.is_part:
        raise InputError(f"sources: {path} is a part; merge all parts (hpcrub merge)")
    n_pending = int(np.count_nonzero(file.status() == PENDING))
    if n_pending and not file.config.convergence.stop_when_converged:
        raise InputError(f"sources: {path} still lacks {n_pending} samples; --resume its study")
    if config is not None:
        other = [d for d in differences(file.config, config) if d.split(".")[0] in PHYSICS]
        if other:
            raise InputError(f"sources: {path} has {'; '.join(other)}")
