"""The studies: every module here is the study of its name.

A study takes a `Config` and computes all that its result file holds. How to add a study is shown in
`docs/developing_a_study.md`.
"""

import os
from importlib import import_module

from hpcrub.config.schema import Config
from hpcrub.config.study_keys import STUDY_NAMES
from hpcrub.results.storage import ResultFile
from hpcrub.runs import result_files
from hpcrub.runs.study import Run, Study

STUDIES: dict[str, Study] = {
    name: import_module(f"hpcrub.studies.{name}").STUDY for name in STUDY_NAMES
}


def run_of(config: Config) -> Run:
    """Run that a configuration describes."""
    return Run(STUDIES[config.study], config)


def open_result(
    path: str | os.PathLike[str], config: Config | None = None, mode: str = "r"
) -> ResultFile:
    """Open a result file of any version that holds all that its study needs.

    config: configuration that the file must have, None: any; mode: "r" to read, "r+" to write.
    Raises InputError, which says what is wrong with the file.
    """

    def check(file: ResultFile) -> None:
        if config is not None:
            result_files.check_config(file, config)
        result_files.check(file, run_of(file.config))

    return ResultFile(path, None, mode, check)
