"""Result files of contact studies, as another study or a merge reads them."""

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


def open_contact(path: str | Path) -> ResultFile:
    """The open file of a contact study, complete or not. Raises InputError for any other."""

    def check(file):
        if file.config.study != STUDY.name:
            raise InputError(f"{path} is of the study {file.config.study}, not contact")
        result_files.check(file, Run(STUDY, file.config))

    return result_files.open_checked(path, check)


def require_complete(file: ResultFile, config: Config) -> None:
    """Raise InputError unless an open contact study is complete, with the physics of `config`."""
    path = file.path
    if file.config.is_part:
        raise InputError(f"sources: {path} is a part; merge all parts (hpcrub merge)")
    n_pending = int(np.count_nonzero(file.status == PENDING))
    if n_pending and not file.config.convergence.stop_when_converged:
        raise InputError(f"sources: {path} still lacks {n_pending} samples; --resume its study")
    other = [d for d in differences(file.config, config) if d.startswith(PHYSICS)]
    if other:
        raise InputError(f"sources: {path} has {'; '.join(other)}")
