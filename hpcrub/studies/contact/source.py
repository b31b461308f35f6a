"""Result files of contact studies, as another study or a merge reads them."""

import hashlib
from pathlib import Path

import numpy as np

from hpcrub.config.schema import Config, differences
from hpcrub.errors import InputError
from hpcrub.results.layout import PENDING
from hpcrub.results.storage import ResultFile
from hpcrub.runs import result_files
from hpcrub.runs.study import Run
from hpcrub.studies.contact.study import STUDY

PHYSICS = (  # sections of the input
    *("disk.", "material.", "reduction.", "casing.", "contact.", "forcing."),
    *("speeds.", "time.", "steady_state."),
)
USED = (
    "sigma",
    "tuned/reference_amplitude_m",
    "samples/status",
    "samples/deviation",
    "samples/amplification",
    "samples/linear_amplification",
)


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
    file = open_contact(path)
    try:
        _check_complete(file, config)
    except BaseException:
        file.close()
        raise
    return file


def open_contact(path: str | Path) -> ResultFile:
    """The open file of a contact study, complete or not. Raises InputError for any other."""
    file = ResultFile(path)
    try:
        if file.config.study != STUDY.name:
            raise InputError(f"{path} is of the study {file.config.study}, not contact")
        result_files.check(file, Run(STUDY, file.config))
    except BaseException:
        file.close()
        raise
    return file


def _check_complete(file, config):
    path = file.path
    if file.config.is_part:
        raise InputError(f"sources: {path} is a part; merge all parts (hpcrub merge)")
    n_pending = int(np.count_nonzero(file.status() == PENDING))
    if n_pending and not file.config.convergence.stop_when_converged:
        raise InputError(f"sources: {path} still lacks {n_pending} samples; --resume its study")
    if config is not None:
        other = [d for d in differences(file.config, config) if d.startswith(PHYSICS)]
        if other:
            raise InputError(f"sources: {path} has {'; '.join(other)}")
