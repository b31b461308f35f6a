"""What can be computed: every study is a module with a `STUDY`, and one line in `STUDIES`.

In: a `Config`. Out: all that a result file holds. `docs/developing_a_study.md` shows how to add a
study.
"""

import difflib
import os
from pathlib import Path

from hpcrub.config.schema import Config
from hpcrub.errors import InputError
from hpcrub.results.storage import ResultFile
from hpcrub.runs import result_files
from hpcrub.runs.study import Run, Study
from hpcrub.studies import (
    branches,
    energy,
    interaction_map,
    linear,
    modal,
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
    )
}


# studies of hpcrub 0.1 that only drew what result files or the input hold
FIGURES = {
    "casing": "a figure of any result file or input",
    "cross": "a figure of a contact study",
    "damping": "a figure of contact studies that differ in their damping",
}


def run_of(config: Config) -> Run:
    """The run that a configuration describes. Raises InputError when there is no such study."""
    if config.study in FIGURES:
        raise InputError(
            f"study: {config.study} is {FIGURES[config.study]} now: "
            f"hpcrub plot --figure {config.study} FILE.h5"
        )
    if config.study not in STUDIES:
        near = difflib.get_close_matches(config.study, STUDIES, n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise InputError(f"study: {config.study!r} is not one of {', '.join(STUDIES)}{hint}")
    return Run(STUDIES[config.study], config)


def open_result(
    path: str | os.PathLike[str], config: Config | None = None, mode: str = "r"
) -> ResultFile:
    """Open a result file that holds all that its study needs.

    Parameters
    ----------
    path
        Result file, of any version of the program.
    config
        The configuration that it must have; None for any.
    mode
        "r" to read, "r+" to write too.

    Returns
    -------
    ResultFile
        To be closed by the caller, or used in a `with` statement.

    Raises
    ------
    InputError
        Says what is wrong with the file.
    """
    file = ResultFile(Path(path), mode=mode)
    try:
        if config is not None:
            result_files.check_config(file, config)
        result_files.check(file, run_of(file.config))
    except BaseException:
        file.close()
        raise
    return file
