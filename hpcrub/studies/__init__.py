"""What can be computed: every study is a module with a `STUDY`, and one line in `STUDIES`.

Their names are those of `hpcrub.config.study_keys.StudyName`. In: a `Config`. Out: all that a
result file holds. `docs/developing_a_study.md` shows how to add a study.
"""

import os

from hpcrub.config.schema import Config
from hpcrub.results.storage import ResultFile
from hpcrub.runs import result_files
from hpcrub.runs.study import Run, Study
from hpcrub.studies import (
    branches,
    energy,
    interaction_map,
    linear,
    modal,
    threshold,
    time_response,
)
from hpcrub.studies.contact import study as contact

STUDIES: dict[str, Study] = {
    module.STUDY.name: module.STUDY
    for module in (
        contact,
        modal,
        linear,
        time_response,
        interaction_map,
        energy,
        branches,
        threshold,
    )
}


def run_of(config: Config) -> Run:
    """The run that a configuration describes."""
    return Run(STUDIES[config.study], config)


def open_result(
    path: str | os.PathLike[str], config: Config | None = None, mode: str = "r"
) -> ResultFile:
    """Open a result file of any version that holds all that its study needs.

    config: the configuration that it must have; None for any. mode: "r" to read, "r+" to write too.
    Raises InputError, which says what is wrong with the file.
    """

    def check(file):
        if config is not None:
            result_files.check_config(file, config)
        result_files.check(file, run_of(file.config))

    return result_files.open_checked(path, check, mode)
